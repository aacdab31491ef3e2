"""Where a character may be expected: on the nav-mesh, near it, and at the ends of its links.

A nav-mesh floats above or below its floor (a cell's height, the detail error; over a stair it lies flat, up to a
climb off the treads) and ends short of walls and ledges (the agent's radius, and up to a cell). Within the default
3 m of it all that is expected anyway; where a level asks for less, walking along a wall or up a stair still is.

Shape legend: n points, L links.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from reachtest.navmesh.islands import climb_of
from reachtest.records import Bools, Character, Floats, NavMesh
from reachtest.surface import SurfaceIndex

_CELL_PER_RADIUS = 0.5  # nav-mesh builders take a half to a third of the radius


class ExpectedSurface:
    """A `Surface`: the nav-mesh with its tolerances and its links' ends."""

    def __init__(self, navmesh: NavMesh, character: Character, expected_within_m: float) -> None:
        """Prepare to tell what is farther than `expected_within_m` from the nav-mesh and its links."""
        self._limit_m = expected_within_m
        self._surface = SurfaceIndex(navmesh.triangles, expected_within_m)
        self._scale = 1.0 / _tolerances(navmesh, character)
        needed = expected_within_m < (1.0 / self._scale).max()
        self._close = SurfaceIndex(navmesh.triangles * self._scale, 1.0) if needed else None
        ends = [(link.radius_m, end) for link in navmesh.links for end in (link.start, link.end)]
        radii = sorted({radius for radius, _ in ends})
        self._ends = [(radius, cKDTree([end for own, end in ends if own == radius])) for radius in radii]

    def distance(self, points: Floats) -> Floats:
        """Distance [n] of points [n, 3] to the nearest of it [m]; infinite where a character is not expected."""
        result = self._surface.distance(points)
        if self._close is not None:
            # At the wall or on the stair of an expected place: as far as is expected, and no farther.
            beyond = np.flatnonzero(np.isinf(result))
            result[beyond[self._within_tolerance(points[beyond])]] = self._limit_m
        return np.minimum(result, self._to_ends(points)) if self._ends else result

    def _within_tolerance(self, points: Floats) -> Bools:
        assert self._close is not None
        return self._close.within(points * self._scale)

    def _to_ends(self, points: Floats) -> Floats:
        """Distance [n] to the nearest link's end, each with a radius around it; infinite where not expected."""
        away = np.full(len(points), np.inf)
        known = np.isfinite(points).all(axis=1)
        for radius, ends in self._ends:
            near, _ = ends.query(points[known], distance_upper_bound=self._limit_m + radius)
            away[known] = np.minimum(away[known], np.maximum(near - radius, 0.0))
        return np.where(away <= self._limit_m, away, np.inf)


def floats_over(navmesh: NavMesh, character: Character, points: Floats) -> Bools:
    """Whether each of `points` [n, 3] (feet) is on the nav-mesh but for erosion and float, or at a link."""
    scale = 1.0 / _tolerances(navmesh, character)
    covered = SurfaceIndex(navmesh.triangles * scale, 1.0).within(points * scale)
    for link in navmesh.links:
        for end in (link.start, link.end):
            covered |= np.linalg.norm(points - end, axis=1) <= link.radius_m + character.radius_m
    return covered


def _tolerances(navmesh: NavMesh, character: Character) -> Floats:
    """Half axes [3] of the ellipsoid around a surface point in which its floor and its walls may be [m].

    It holds the box of erosion and float (hence the root of two): one may be at a wall on a stair.
    """
    radius = max(navmesh.agent.radius_m or 0.0, character.radius_m)
    climb = max(climb_of(navmesh), character.step_height_m)
    aside = radius * (1 + _CELL_PER_RADIUS)
    return np.sqrt(2.0) * np.array([aside, aside, climb])
