"""The goals nobody came near: part of an island one should get to, or islands that nobody was to get to anyway.

Shape legend: I islands, n goals.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from reachtest.findings.build import Cluster
from reachtest.findings.effort import attempts_at, describe, enough, open_areas
from reachtest.findings.evidence import Evidence
from reachtest.findings.places import plural, say_place
from reachtest.geometry import triangle_normals
from reachtest.records import Floats, Ints

NO_POINTS: Ints = np.empty(0, dtype=np.int64)
_SHOWN = 5  # islands that are named one by one


def unreached_areas(evidence: Evidence) -> list[Cluster]:
    """Unreached goals of connected islands that no mismatch explains, grouped by area.

    They gate once enough was done to get there, unless the gate allows for some (`min_goals_reached`).
    """
    exploration, counts = evidence.exploration, evidence.survey.counts
    least = evidence.level.gate.min_goals_reached
    allowed = least < 1 and (exploration.goal_step[counts] >= 0).mean() >= least
    areas = []
    for goals in open_areas(exploration, counts):
        attempts = attempts_at(exploration, goals)
        area = Cluster("unreached_area", "", NO_POINTS, (), exploration.goals[goals])
        details = describe(exploration, attempts, goals)
        areas.append(replace(area, details=details, never_gates=allowed or not enough(exploration, attempts)))
    return areas


def unconnected_islands(evidence: Evidence) -> list[Cluster]:
    """Roofs and outer shells: islands that nothing connects to a spawn and nobody was on, said once."""
    survey = evidence.survey
    islands = survey.islands
    left = np.flatnonzero(~islands.connected & ~survey.visited)
    if not len(left):
        return []
    left = left[np.argsort(-islands.area_m2[left], kind="stable")]
    triangles = evidence.level.navmesh.triangles
    area = islands.area_m2[left].sum()
    spots = [_spot(evidence, int(island)) for island in left[:_SHOWN]]
    details = [
        f"{islands.area_m2[island]:,.0f} m2 with {plural(int((islands.goal_island == island).sum()), 'goal')}"
        f" at {say_place(evidence.level, spot)}"
        for island, spot in zip(left, spots, strict=False)
    ]
    if len(left) > _SHOWN:
        details.append(f"and {len(left) - _SHOWN:,} smaller ones")
    reached = int((~islands.connected & survey.visited).sum())
    if reached:
        details.append(
            f"{plural(reached, 'more island')} without a connection: somebody got there all the same"
        )
    corners = triangles[np.isin(islands.labels, left)].reshape(-1, 3)
    are = "are" if len(left) > 1 else "is"
    return [
        Cluster(
            kind="unreached_area",
            label="islands that are connected to no spawn",
            points=NO_POINTS,
            falls=(),
            places=np.stack([corners.min(axis=0), corners.max(axis=0)]),
            details=tuple(details),
            title=f"{plural(len(left), 'island')} of the nav-mesh ({area:,.0f} m2) {are} not connected to any spawn",
            count=int(np.isin(islands.goal_island, left).sum()) or len(left),
            never_gates=True,
            position=spots[0],
        )
    ]


def _spot(evidence: Evidence, island: int) -> Floats:
    """A place [3] on an island: its first goal, or the middle of its largest face."""
    islands = evidence.survey.islands
    goals = np.flatnonzero(islands.goal_island == island)
    if len(goals):
        return evidence.exploration.goals[goals[0]]
    faces = evidence.level.navmesh.triangles[islands.labels == island]
    return np.asarray(faces[triangle_normals(faces)[1].argmax()].mean(axis=0))
