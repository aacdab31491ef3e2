"""Who was in a solid or a forbidden zone, if only in passing: cached points are a metre apart, and a pillar is thinner.

Shape legend: T agent steps of a round, B lanes, M starts a lane, n positions, k solids and zones.
"""

from __future__ import annotations

import numpy as np

from reachtest.explore.rollout import Trajectories
from reachtest.offlimits import off_limits
from reachtest.records import Bools, Fall, Ints, Level, Origin

_NO_EXIT = np.full(3, np.nan)


class Trespasses:
    """`found` is where somebody was first seen in each of a level's solids and forbidden zones, by kind and name."""

    def __init__(self, level: Level) -> None:
        self.found: dict[tuple[str, str], Fall] = {}
        self._open = off_limits(level)  # where nobody was seen yet

    def note(self, rolled: Trajectories, parents: Ints, round_: int) -> None:
        """Look at a round's positions; `parents` [M, B] are what its lanes started from."""
        if not self._open:
            return
        positions = rolled.positions
        low = np.where(np.isnan(positions), np.inf, positions).min(axis=0)
        high = np.where(np.isnan(positions), -np.inf, positions).max(axis=0)
        lows, highs = np.array([one.low for one in self._open]), np.array([one.high for one in self._open])
        came_by: Bools = ((low[:, None] <= highs) & (high[:, None] >= lows)).all(axis=2)  # [B, k]
        for column in np.flatnonzero(came_by.any(axis=0)).tolist():
            one, lanes = self._open[column], np.flatnonzero(came_by[:, column])
            inside = np.flatnonzero(one.holds(positions[:, lanes].reshape(-1, 3)))
            if len(inside):
                step, lane = divmod(int(inside[0]), len(lanes))
                self.found[one.kind, one.name] = _seen(rolled, parents, round_, step, int(lanes[lane]))
        self._open = tuple(one for one in self._open if (one.kind, one.name) not in self.found)


def _seen(rolled: Trajectories, parents: Ints, round_: int, step: int, lane: int) -> Fall:
    parent = int(parents[rolled.which[step, lane], lane])
    origin = Origin(parent, round_, lane, int(rolled.start[step, lane]), step + 1)
    place = rolled.positions[step, lane]
    return Fall(origin, place, place, _NO_EXIT)
