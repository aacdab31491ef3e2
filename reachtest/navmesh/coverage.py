"""What of a nav-mesh's goals a run has to reach: those on islands that are connected to a spawn.

Shape legend: F faces, I islands, G goals, n points.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from reachtest.geometry import triangle_normals
from reachtest.navmesh.faces import FaceIndex
from reachtest.navmesh.islands import Islands
from reachtest.records import Bools, Floats, Ints, NavMesh

STOOD_WITHIN_M = 0.5  # of a face: the feet are on it, however it floats


@dataclass(frozen=True)
class GoalIslands:
    """The nav-mesh's islands, and the goals on them."""

    labels: Ints  # [F] island of each face
    area_m2: Floats  # [I]
    connected: (
        Bools  # [I] to a spawn, over the surface and the nav-mesh's links; all, if no spawn stands on it
    )
    goal_island: Ints  # [G] -1 for none

    @property
    def goals_count(self) -> Bools:
        """Which goals [G] count for a pass: those on connected islands, and those on no island."""
        return np.asarray((self.goal_island < 0) | self.connected[self.goal_island], dtype=np.bool_)


def goal_islands(islands: Islands, spawns: Floats, goals: Floats) -> GoalIslands:
    """What `islands` say of spawn positions [n, 3] and goals [G, 3]."""
    areas = triangle_normals(islands.navmesh.triangles)[1]
    connected = islands.connected_to(spawns)
    known = bool(connected.any())
    return GoalIslands(
        labels=islands.labels,
        area_m2=np.bincount(islands.labels, weights=areas, minlength=islands.count).astype(np.float64),
        connected=connected if known else np.ones(islands.count, dtype=np.bool_),
        goal_island=islands.of(goals),
    )


def stood_on(navmesh: NavMesh, labels: Ints, points: Floats) -> Bools:
    """Which islands [I] one of `points` [n, 3] (feet) stands on."""
    result = np.zeros(int(labels.max()) + 1 if len(labels) else 0, dtype=np.bool_)
    if len(result):
        face, _ = FaceIndex(navmesh.triangles, STOOD_WITHIN_M).below(points, STOOD_WITHIN_M, STOOD_WITHIN_M)
        result[labels[face[face >= 0]]] = True
    return result
