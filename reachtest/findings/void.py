"""Where there is nothing to stand on: below it the player is out of the world.

Shape legend: n places, k samples.
"""

from __future__ import annotations

import numpy as np

from reachtest.geometry import ColumnIndex
from reachtest.records import Bools, Floats, Level

_SPACING_M = 0.25
_FARTHEST_M = 8.0  # a jump and what the fall adds to it


class Void:
    """The void around and in a level."""

    def __init__(self, level: Level) -> None:
        self.columns = ColumnIndex(level.collision)
        self._kill_z = level.kill_z_m
        self._up_m = level.character.step_height_m + 0.1

    def holds(self, points: Floats) -> Bools:
        """Whether nothing is below points [..., 3], or not before the player is out of the world."""
        flat = points.reshape(-1, 3)
        below, _ = self.columns.highest(flat, flat[:, 2] - self._kill_z, self._up_m)
        return np.isnan(below).reshape(points.shape[:-1])

    def entries(self, footings: Floats, ends: Floats) -> Floats:
        """Where falls crossed an edge [n, 3], seen from above: at the first void on the way from the last footing
        [n, 3] to the place [n, 3] at which they left the world. NaN where there is none.

        The way is taken to be straight: in the air one hardly steers.
        """
        flown = (ends - footings) * [1.0, 1.0, 0.0]
        far = np.linalg.norm(flown, axis=1, keepdims=True)
        steps = np.arange(0.0, _FARTHEST_M, _SPACING_M)
        along = np.minimum(steps, far)[:, :, None] * (flown / np.maximum(far, 1e-9))[:, None]
        ways = footings[:, None] + along  # [n, k, 3]
        void = self.holds(ways)
        entry = ways[np.arange(len(ways)), void.argmax(axis=1)]
        return np.where(void.any(axis=1, keepdims=True), entry, np.nan)
