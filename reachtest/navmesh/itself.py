"""On the nav-mesh itself, where "expected" reaches a few metres around it, and through walls."""

from __future__ import annotations

import numpy as np

from reachtest.records import Bools, Floats, Level
from reachtest.surface import SurfaceIndex

FLOAT_M = 1.0  # a nav-mesh is at most so much above or below its floor


class NavMeshItself:
    """Tells who stands on the nav-mesh: within a radius of it, seen from above.

    Who stands behind a wall is a radius and the wall away from a nav-mesh that reaches up to it.
    """

    def __init__(self, level: Level) -> None:
        radius_m = level.character.radius_m
        self._flat = np.array([1.0, 1.0, radius_m / FLOAT_M])
        self._surface = SurfaceIndex(level.navmesh.triangles * self._flat, radius_m)

    def holds(self, places: Floats) -> Bools:
        """Which of `places` [n, 3] are on it; none that is NaN."""
        return self._surface.within(places * self._flat)

    def last_of(self, places: Floats) -> int | None:
        """Which of `places` [n, 3] is the last on it; None if none is."""
        held = np.flatnonzero(self.holds(places))
        return int(held[-1]) if len(held) else None
