"""Roofs that are fine: inside an `allowed_off_mesh` zone everything is expected.

So the way off such a roof begins at the roof's edge: two holes in its rail are two bugs, and both are told.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from reachtest.interfaces import Surface
from reachtest.navmesh.expected import ExpectedSurface
from reachtest.records import Floats, Level, Zone

_SINK_M = 0.1  # feet sink a little into the floor, and a zone may begin right on it


def expected_surface(level: Level) -> Surface:
    """Where a character is expected in a level: near its nav-mesh, at its links' ends, and in its allowed zones."""
    surface = ExpectedSurface(level.navmesh, level.character, level.explore.expected_within_m)
    return AllowedZones(surface, level.zones)


class AllowedZones:
    """A `Surface` that is everywhere in its zones too."""

    def __init__(self, surface: Surface, zones: Sequence[Zone]) -> None:
        """Of `zones` those of kind `allowed_off_mesh` count."""
        self._surface = surface
        self._boxes = [(z.low - [0, 0, _SINK_M], z.high) for z in zones if z.kind == "allowed_off_mesh"]

    def distance(self, points: Floats) -> Floats:
        """Distance [n] of points [n, 3] to the surface [m]; 0 in a zone, infinite where not expected."""
        result = self._surface.distance(points)
        for low, high in self._boxes:
            result = np.where(((points >= low) & (points <= high)).all(axis=1), 0.0, result)
        return result
