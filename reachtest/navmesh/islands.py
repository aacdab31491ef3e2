"""Islands of a nav-mesh: what one can walk between without leaving it, and what its links connect to a spawn.

Shape legend: F faces, I islands, n points.
"""

from __future__ import annotations

import numpy as np

from reachtest.connected import part_labels
from reachtest.navmesh.edges import neighbours
from reachtest.navmesh.faces import FaceIndex
from reachtest.records import Bools, Floats, Ints, NavMesh

CLIMB_M = 0.6  # where the file does not say: above every preset's step, below the head room of any storey
LEAST_CLIMB_M = 0.25  # Godot's default: slopes' borders and floats over floors are as exact as cells, no more
ROUNDING_M = 0.02  # a step of just the climb is one that is climbed
SPAWN_DOWN_M = 3.0  # a spawn may hang in the air
SPAWN_REACH_M = 1.0  # or stand where erosion took the surface away
LINK_REACH_M = 1.0  # link ends are snapped to polygons within their radius, or lie at the edge of one


def climb_of(navmesh: NavMesh) -> float:
    """By how much borders that belong together may differ in height [m], and a surface and its floor."""
    climb = navmesh.agent.climb_m
    return CLIMB_M if climb is None else max(climb, LEAST_CLIMB_M) + ROUNDING_M


def islands(navmesh: NavMesh, climb_m: float | None = None) -> Ints:
    """The island [F] of every face, numbered from 0 in the order of their first faces.

    Faces are of one island if they share an edge, or if their borders lie against each other: within 0.1 m
    horizontally and the agent's climb (`climb_m`, else that of `climb_of`) vertically. Links do not merge
    islands: see `Islands.connected_to`.
    """
    faces = len(navmesh.faces)
    if not faces:
        return np.empty(0, dtype=np.int64)
    climb = climb_of(navmesh) if climb_m is None else climb_m
    label = part_labels(faces, neighbours(navmesh, climb))
    _, first, inverse = np.unique(label, return_index=True, return_inverse=True)
    rank = np.empty(len(first), dtype=np.int64)
    rank[np.argsort(first)] = np.arange(len(first))
    return np.asarray(rank[inverse.reshape(-1)], dtype=np.int64)


class Islands:
    """The islands of one nav-mesh, found by place."""

    def __init__(self, navmesh: NavMesh) -> None:
        self.navmesh = navmesh
        self.labels = islands(navmesh)  # [F]
        self.count = int(self.labels.max()) + 1 if len(self.labels) else 0
        self._faces = FaceIndex(navmesh.triangles, SPAWN_REACH_M)

    def of(self, points: Floats) -> Ints:
        """The island [n] that each of `points` [n, 3] stands on or next to; -1 for none."""
        if not self.count:
            return np.full(len(points), -1, dtype=np.int64)
        face, _ = self._faces.below(points, SPAWN_DOWN_M, CLIMB_M)
        return np.where(face >= 0, self.labels[face], -1)

    def connected_to(self, points: Floats) -> Bools:
        """Which islands [I] one gets to from `points` [n, 3] (spawns) by walking and by the nav-mesh's links.

        A one-way link leads from its start to its end only.
        """
        reached = np.zeros(self.count, dtype=np.bool_)
        at = self.of(points)
        reached[at[at >= 0]] = True
        ways = _ways(self.navmesh, self.labels)
        while len(ways):
            new = ways[reached[ways[:, 0]] & ~reached[ways[:, 1]], 1]
            if not len(new):
                break
            reached[new] = True
        return reached


def link_islands(navmesh: NavMesh, labels: Ints) -> Ints:
    """The islands [L, 2] at the start and the end of every link; -1 where there is no surface."""
    if not navmesh.links:
        return np.empty((0, 2), dtype=np.int64)
    reach = max(LINK_REACH_M, *(link.radius_m for link in navmesh.links))
    ends = np.array([[link.start, link.end] for link in navmesh.links], dtype=np.float64).reshape(-1, 3)
    face, _ = FaceIndex(navmesh.triangles, reach).below(ends, LINK_REACH_M, LINK_REACH_M)
    return np.where(face >= 0, labels[face], -1).reshape(-1, 2)


def _ways(navmesh: NavMesh, labels: Ints) -> Ints:
    """Directed pairs of different islands [N, 2] that a link joins."""
    pairs = link_islands(navmesh, labels)
    both = np.array([link.both_ways for link in navmesh.links], dtype=np.bool_)
    ways = np.concatenate([pairs, pairs[both][:, ::-1]])
    return ways[(ways >= 0).all(axis=1) & (ways[:, 0] != ways[:, 1])]
