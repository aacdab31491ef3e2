"""What of a nav-mesh's goals a run has to reach: those on islands that are connected to a spawn.

Shape legend: F faces, I islands, G goals, n points.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from reachtest.geometry import triangle_normals
from reachtest.navmesh.faces import FaceIndex
from reachtest.navmesh.islands import connected_to, island_of, islands
from reachtest.records import Bools, Floats, Ints, NavMesh

STOOD_WITHIN_M = 0.5  # of a face: the feet are on it, however it floats


@dataclass(frozen=True)
class GoalIslands:
    """The nav-mesh's islands, and the goals on them."""

    labels: Ints  # [F] island of each face
    area_m2: Floats  # [I]
    connected: Bools  # [I] to a spawn, over the surface and the nav-mesh's links
    spawns_known: bool  # some spawn stands on the nav-mesh; if none does, every island counts as connected
    goal_island: Ints  # [G] -1 for none

    @property
    def goals_count(self) -> Bools:
        """Which goals [G] count for a pass: those on connected islands, and those on no island."""
        return np.asarray((self.goal_island < 0) | self.connected[self.goal_island], dtype=np.bool_)


def goal_islands(navmesh: NavMesh, spawns: Floats, goals: Floats) -> GoalIslands:
    """The islands of a nav-mesh, of spawn positions [n, 3] and of goals [G, 3]."""
    labels = islands(navmesh)
    areas = triangle_normals(navmesh.triangles)[1]
    count = int(labels.max()) + 1 if len(labels) else 0
    connected = connected_to(navmesh, labels, spawns)
    known = bool(connected.any())
    return GoalIslands(
        labels=labels,
        area_m2=np.bincount(labels, weights=areas, minlength=count).astype(np.float64),
        connected=connected if known else np.ones(count, dtype=np.bool_),
        spawns_known=known,
        goal_island=island_of(navmesh, labels, goals),
    )


def stood_on(navmesh: NavMesh, labels: Ints, points: Floats) -> Bools:
    """Which islands [I] one of `points` [n, 3] (feet) stands on."""
    result = np.zeros(int(labels.max()) + 1 if len(labels) else 0, dtype=np.bool_)
    if len(result):
        face, _ = FaceIndex(navmesh.triangles, STOOD_WITHIN_M).below(points, STOOD_WITHIN_M, STOOD_WITHIN_M)
        result[labels[face[face >= 0]]] = True
    return result
