"""Where attempts at a goal can begin: at cached points from which one walks on, and which of them are near.

Shape legend: P cached points, n places, k points near each.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from reachtest.explore.forest import Forest
from reachtest.records import Floats, Ints

LOW_M = 1.5  # above a floor: who jumps along a beam still is on it, who falls off it is not
CHOICE = 32  # cached points around a goal to start from: all round it, and above and below
BY_STOREY, STRAIGHT = 0, 1  # the two ways to be near
_STOREY = np.array([1.0, 1.0, 4.0])  # one walks on along a beam, and does not get up from the ground below it


class Starts:
    """The cached points that stand, or fly so low that they soon will."""

    def __init__(self) -> None:
        self._storeys, self._points = Forest(), Forest()  # the same points; in the former heights count more
        self._ids: Ints = np.empty(0, dtype=np.int64)  # the cached points they are
        self._seen = 0  # cached points that were looked at

    def __len__(self) -> int:
        return len(self._ids)

    def note(self, positions: Floats, above_m: NDArray[np.floating]) -> None:
        """Take in what is new of the cached points at `positions` [P, 3], so far above a floor [P] [m]."""
        new = self._seen + np.flatnonzero(above_m[self._seen :] <= LOW_M)
        self._points.append(positions[new])
        self._storeys.append(positions[new] * _STOREY)
        self._ids = np.append(self._ids, new)
        self._seen = len(positions)

    def nearest(self, places: Floats) -> tuple[Floats, Ints]:
        """The points nearest to `places` [n, 3], by storey and straight: distances and which, [2, n, k] each.

        Where there are fewer than k, the rest is infinitely far, and no matter which.
        """
        ways = self._storeys.nearest(places * _STOREY, CHOICE), self._points.nearest(places, CHOICE)
        away, who = (np.stack(both) for both in zip(*ways, strict=True))
        return away, self._ids[who]
