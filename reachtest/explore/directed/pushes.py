"""Who pushed at which place of the nav-mesh's border, whatever for.

Shape legend: n border places, T agent steps, B lanes.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from reachtest.explore.directed.places import Places
from reachtest.records import Floats, Ints

PUSHED_M = 1.25  # from a place: half the spacing aside, or up in a jump


class Pushes:
    """Counts episodes: `counts` [n] is how many pushed at each place."""

    def __init__(self, along: Places) -> None:
        self._headings = along.headings
        self._tree = cKDTree(along.positions.reshape(-1, 3))
        self.counts: Ints = np.zeros(len(along.positions), dtype=np.int64)

    def note(self, positions: Floats, sticks: NDArray[np.int8]) -> None:
        """Count who came by, pushing: `positions` [T, B, 3] after steps with `sticks` [T, B]."""
        t, lane = np.nonzero(np.isfinite(positions[:, :, 0]) & (sticks > 0))
        found = self._tree.query(positions[t, lane], k=[1, 2], distance_upper_bound=PUSHED_M)
        away, place = np.asarray(found[0]), np.asarray(found[1])
        step, column = np.nonzero(np.isfinite(away))
        place, t, lane = place[step, column], t[step], lane[step]
        outwards = (sticks[t, lane] - self._headings[place] + 1) % 8 <= 2  # give or take 45 degrees
        lanes = sticks.shape[1]
        once = np.unique(place[outwards] * lanes + lane[outwards])
        self.counts += np.bincount(once // lanes, minlength=len(self.counts))
