"""The nav-mesh was built for somebody else: said once, with the numbers and the places.

Shape legend: N samples of the nav-mesh, K steps, n places.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from reachtest.findings.build import Cluster
from reachtest.findings.cluster import single_linkage
from reachtest.findings.evidence import Evidence
from reachtest.findings.places import plural, say_places
from reachtest.navmesh.promises import LOW, NARROW, STEEP, agent_differences
from reachtest.records import Floats, Ints

NO_POINTS: Ints = np.empty(0, dtype=np.int64)
_PLACE_M = 2.0  # samples and steps nearer than this are one place; so are the treads of one stair


@dataclass(frozen=True)
class _Complaint:
    """One thing the nav-mesh promises and the character cannot do."""

    short: str  # for the title
    detail: str  # with the places
    spots: list[Floats]  # the places [3], largest first
    samples: Floats  # [n, 3]


def navmesh_mismatch(evidence: Evidence) -> list[Cluster]:
    """At most one cluster: different agents, impossible places, and the goals that they explain."""
    level, survey = evidence.level, evidence.survey
    agents = agent_differences(level.navmesh.agent, level.character)
    complaints = [c for c in (*_impossible(evidence), *_high_steps(evidence)) if c is not None]
    if not agents and not complaints:
        return []
    details = [*agents, *(complaint.detail for complaint in complaints)]
    behind = evidence.exploration.goals[survey.explained]
    if len(behind):
        groups = single_linkage(behind, 2 * evidence.exploration.settings.goal_spacing_m)
        where = say_places(level, [behind[group[0]] for group in groups])
        area = plural(len(groups), "area")
        details.append(f"not reached for that reason: {plural(len(behind), 'goal')} in {area}, {where}")
    title = "; ".join(
        [*(["it was built for another agent"] if agents else []), *(c.short for c in complaints)]
    )
    spots = [spot for complaint in complaints for spot in complaint.spots]
    everywhere = [complaint.samples for complaint in complaints] or [level.navmesh.vertices]
    return [
        Cluster(
            kind="navmesh_mismatch",
            label="nav-mesh and character",
            points=NO_POINTS,
            falls=(),
            places=np.concatenate([*everywhere, behind]),
            details=tuple(details),
            title=f"The nav-mesh does not fit the character: {title}",
            count=len(spots) or 1,
            position=spots[0] if spots else level.spawns[0].position,
        )
    ]


def _impossible(evidence: Evidence) -> list[_Complaint | None]:
    who = evidence.level.character
    return [
        _places(evidence, LOW, "too low", "{:.2f} m", who.height_m),
        _places(evidence, NARROW, "too narrow", "{:.2g} m", 2 * who.radius_m),
        _places(evidence, STEEP, "too steep", "{:.0f} deg", who.slope_limit_deg),
    ]


def _places(evidence: Evidence, reason: int, what: str, unit: str, limit: float) -> _Complaint | None:
    """The samples that are impossible for one reason, by place; None if there are none."""
    promises = evidence.survey.promises
    chosen = promises.reason == reason
    if not chosen.any():
        return None
    samples, values = promises.samples.positions[chosen], promises.value[chosen]
    spots = _spots(samples, max(_PLACE_M, 2 * promises.samples.spacing_m))
    worst, verb = (values.max(), "walks up") if reason == STEEP else (values.min(), "needs")
    short = f"{what} at {plural(len(spots), 'place')} ({unit.format(worst)}, it {verb} {unit.format(limit)})"
    return _Complaint(short, f"{what}: {say_places(evidence.level, spots)}", spots, samples)


def _high_steps(evidence: Evidence) -> list[_Complaint | None]:
    """Steps that the surface leads over, and those that cut it into islands somebody gets to."""
    survey = evidence.survey
    promises, islands = survey.promises, survey.islands
    known = (islands.connected | survey.visited)[islands.labels[promises.samples.face[promises.cuts]]]
    cuts = known.any(axis=1)
    return [
        _steps(evidence, promises.steps, promises.rise_m, "steps of {} m"),
        _steps(evidence, promises.cuts[cuts], promises.cut_rise_m[cuts], "cut apart by steps of {} m"),
    ]


def _steps(evidence: Evidence, steps: Ints, rise_m: Floats, what: str) -> _Complaint | None:
    """Steps [K, 2] of samples, by place; None if there are none."""
    if not len(steps):
        return None
    samples = evidence.survey.promises.samples
    middles = samples.positions[steps].mean(axis=1)
    spots = _spots(middles, max(_PLACE_M, 2 * samples.spacing_m))
    low, high = (f"{rise:.2f}" for rise in (rise_m.min(), rise_m.max()))
    what = what.format(low if low == high else f"{low} to {high}")
    limit = f"it walks up {evidence.level.character.step_height_m:.2f} m"
    short = f"{what} at {plural(len(spots), 'place')} ({limit})"
    return _Complaint(short, f"{what}: {say_places(evidence.level, spots)}", spots, middles)


def _spots(points: Floats, link_m: float) -> list[Floats]:
    """One of `points` [n, 3] for each group of them, that of the largest group first."""
    groups = sorted(single_linkage(points, link_m), key=len, reverse=True)
    middles = [points[group].mean(axis=0) for group in groups]
    return [
        points[group[np.linalg.norm(points[group] - middle, axis=1).argmin()]]
        for group, middle in zip(groups, middles, strict=True)
    ]
