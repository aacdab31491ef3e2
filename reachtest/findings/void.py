"""Where there is nothing to stand on: below it the player is out of the world.

Shape legend: n places, k samples.
"""

from __future__ import annotations

import numpy as np

from reachtest.columns import ColumnIndex
from reachtest.records import Bools, Floats, Level

_SPACING_M = 0.25
_STRETCH_M = 8.0  # looked at together: a jump and what the fall adds to it


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
        """Where falls crossed an edge [n, 3], NaN where there is none: the first void on the way, seen from above,
        from the last footing [n, 3] to the place [n, 3] at which they left the world; as high as the floor before it.

        The way is taken to be straight: in the air one hardly steers. The floor is the last one flown over: who jumps
        off a tower and over the rim of the ground fell off the ground.
        """
        flown = (ends - footings) * [1.0, 1.0, 0.0]
        far = np.linalg.norm(flown, axis=1)
        towards = flown / np.maximum(far, 1e-9)[:, None]
        result = np.full(footings.shape, np.nan)
        left, begin = np.arange(len(footings)), 0.0
        while len(left):
            steps = np.minimum(begin + np.arange(0.0, _STRETCH_M, _SPACING_M), far[left, None])  # [n, k]
            void = self.holds(footings[left, None] + steps[:, :, None] * towards[left, None])
            some = np.flatnonzero(void.any(axis=1))
            rows, at = left[some], steps[some, void[some].argmax(axis=1)][:, None]
            result[rows] = footings[rows] + at * towards[rows]
            before = footings[rows] + np.maximum(at - _SPACING_M, 0.0) * towards[rows]
            floor, _ = self.columns.highest(before, before[:, 2] - self._kill_z, self._up_m)
            result[rows, 2] = np.where(np.isfinite(floor), floor, footings[rows, 2])
            begin += _STRETCH_M
            left = left[~void.any(axis=1) & (far[left] >= begin)]
        return result

    def crossed(self, way: Floats) -> Floats:
        """Where a fall crossed an edge [3] on its `way` [n, 3] from the last footing on: the first void on it, as high
        as the floor before; NaN if it only ever was over a floor."""
        far = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(way, axis=0), axis=1))])
        steps = np.arange(0.0, far[-1] + _SPACING_M, _SPACING_M)
        places = np.stack([np.interp(steps, far, way[:, axis]) for axis in range(3)], axis=1)
        void = self.holds(places)
        if not void.any():
            return np.full(3, np.nan)
        first = int(void.argmax())
        floor, _ = self.columns.highest(
            places[max(first - 1, 0)][None], places[0, 2] - self._kill_z, self._up_m
        )
        height = floor[0] if np.isfinite(floor[0]) else way[0, 2]
        return np.append(places[first, :2], height)
