"""Roofs that are fine: inside an `allowed_off_mesh` zone everything is expected.

So the way off such a roof begins at the roof's edge: two holes in its rail are two bugs, and both are told.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from reachtest.interfaces import Surface
from reachtest.navmesh.expected import ExpectedSurface
from reachtest.records import Floats, Level, Zone


def expected_surface(level: Level) -> Surface:
    """Where a character is expected in a level: near its nav-mesh, at its links' ends, and in its allowed zones."""
    surface = ExpectedSurface(level.navmesh, level.character, level.explore.expected_within_m)
    return AllowedZones(surface, level.zones)


LANDING_M = 0.3  # who comes down is so deep in the floor for a tick, of a drop of 4 m


class AllowedZones:
    """A `Surface` that is everywhere in its zones too."""

    def __init__(self, surface: Surface, zones: Sequence[Zone]) -> None:
        """Of `zones` those of kind `allowed_off_mesh` count."""
        self._surface = surface
        self._zones = [zone for zone in zones if zone.kind == "allowed_off_mesh"]

    def distance(self, points: Floats) -> Floats:
        """Distance [n] of points [n, 3] to the surface [m]; 0 in a zone, infinite where not expected."""
        result = self._surface.distance(points)
        for zone in self._zones:
            inside = zone.holds(points) | zone.holds(points + [0.0, 0.0, LANDING_M])
            result = np.where(inside, 0.0, result)
        return result
