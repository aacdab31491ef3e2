"""Who was in a solid or a forbidden zone, if only in passing: cached points are a metre apart, and a pillar is thinner.

Shape legend: T agent steps of a round, B lanes, M starts a lane, n positions, k solids and zones.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from reachtest.explore.rollout import Trajectories
from reachtest.geometry import body_inside
from reachtest.records import Bools, Character, Fall, Floats, Ints, Level, Origin, Solid

_NO_EXIT = np.full(3, np.nan)


class Trespasses:
    """`found` is where somebody was first seen in each of a level's solids and forbidden zones, by kind and name."""

    def __init__(self, level: Level) -> None:
        self.found: dict[tuple[str, str], Fall] = {}
        zones = [zone for zone in level.zones if zone.kind == "forbidden"]
        keys = [("inside_solid", solid.name) for solid in level.solids]
        self._keys = keys + [("forbidden_zone", zone.name) for zone in zones]
        boxes = [_box(solid, level.character) for solid in level.solids] + [zone.box for zone in zones]
        ends = np.array(boxes).reshape(-1, 2, 3)
        self._low, self._high = ends[:, 0], ends[:, 1]
        inside = [_of_solid(solid, level.character) for solid in level.solids]
        self._inside = inside + [zone.holds for zone in zones]
        self._open = np.arange(len(self._keys))  # where nobody was seen yet

    def note(self, rolled: Trajectories, parents: Ints, round_: int) -> None:
        """Look at a round's positions; `parents` [M, B] are what its lanes started from."""
        if not len(self._open):
            return
        positions = rolled.positions
        low = np.where(np.isnan(positions), np.inf, positions).min(axis=0)
        high = np.where(np.isnan(positions), -np.inf, positions).max(axis=0)
        near = (low[:, None] <= self._high[self._open]) & (high[:, None] >= self._low[self._open])
        came_by: Bools = near.all(axis=2)  # [B, k]
        for column in np.flatnonzero(came_by.any(axis=0)).tolist():
            number, lanes = int(self._open[column]), np.flatnonzero(came_by[:, column])
            some = positions[:, lanes]
            step, lane = np.divmod(np.flatnonzero(self._inside[number](some.reshape(-1, 3))), len(lanes))
            if len(step):
                self.found[self._keys[number]] = _seen(
                    rolled, parents, round_, int(step[0]), int(lanes[lane[0]])
                )
        self._open = self._open[[self._keys[number] not in self.found for number in self._open.tolist()]]


def _seen(rolled: Trajectories, parents: Ints, round_: int, step: int, lane: int) -> Fall:
    parent = int(parents[rolled.which[step, lane], lane])
    origin = Origin(parent, round_, lane, int(rolled.start[step, lane]), step + 1)
    place = rolled.positions[step, lane]
    return Fall(origin, place, place, _NO_EXIT)


def _box(solid: Solid, who: Character) -> tuple[Floats, Floats]:
    """Where the feet [3] to [3] of somebody in a solid may be."""
    low, high = solid.triangles.min(axis=(0, 1)), solid.triangles.max(axis=(0, 1))
    return low - [0, 0, who.height_m / 2], high - [0, 0, who.radius_m]


def _of_solid(solid: Solid, who: Character) -> Callable[[Floats], Bools]:
    return lambda feet: body_inside(feet, who, solid.triangles)
