"""Where a character's feet could get to at the very most: an upper bound that ignores how far a jump carries.

Feet may be anywhere in free space that is connected to where they are: sideways and downwards without limit
(so every flight is allowed, however long), upwards only by a jump from a place to stand on. Space is cut into
cells of 0.25 m; every edge of the maps' pieces in plan lies on that grid, and tops are rounded up to it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from scipy.ndimage import label
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import breadth_first_order

CELL_M = LAYER_M = 0.25
TOP_M = 9.0  # higher than every roof one can get onto with a jump
WALK, JUMP, GRAVITY = 6.0, 4.2, 9.8  # the `unreal` preset


class FreeSpace:
    """The free space over a rectangle between heights 0 and `TOP_M`. Shape legend: [nx, ny] columns, K layers."""

    def __init__(self, pieces: Sequence[Any], area: tuple[float, float, float, float]) -> None:
        """`area` is (x0, y0, x1, y1) [m]; nobody gets out of it."""
        self.x0, self.y0, x1, y1 = area
        self.shape = (round((x1 - self.x0) / CELL_M), round((y1 - self.y0) / CELL_M))
        self.layers = round(TOP_M / LAYER_M)
        self.free = np.ones((self.layers, *self.shape), dtype=bool)
        self.ground = np.zeros(self.shape, dtype=bool)
        for piece in pieces:
            self._fill(piece)
        self._label()

    def _cells(self, low: float, high: float, axis: int) -> slice:
        origin, count = (self.x0, self.y0)[axis], self.shape[axis]
        a, b = (low - origin) / CELL_M, (high - origin) / CELL_M
        assert abs(a - round(a)) < 1e-6, "off the grid"
        assert abs(b - round(b)) < 1e-6, "off the grid"
        return slice(min(max(round(a), 0), count), min(max(round(b), 0), count))

    def _fill(self, piece: Any) -> None:
        xs, ys = (self._cells(piece.low[k], piece.high[k], k) for k in (0, 1))
        if xs.start == xs.stop or ys.start == ys.stop:
            return
        if piece.low[2] < 0:
            self.ground[xs, ys] = True
        base = max(0, int(np.ceil(piece.low[2] / LAYER_M - 1e-6)))
        if not piece.is_slope:
            self.free[base : max(0, int(np.ceil(piece.high[2] / LAYER_M - 1e-6))), xs, ys] = False
            return
        for strip, lower, upper in self._strips(piece, xs, ys):
            self.free[base : int(np.ceil(upper / LAYER_M - 1e-6)), *strip] = False
            self.free[int((lower + self._above(piece)) / LAYER_M) + 1 :, *strip] = False

    def _above(self, piece: Any) -> float:
        """How far above a slope a jump down it leads at the most [m]; a little more, for rounding."""
        axis = 0 if piece.uphill[1] == "x" else 1
        gradient = (piece.high[2] - piece.low[2]) / (piece.high[axis] - piece.low[axis])
        return (JUMP + WALK * gradient) ** 2 / (2 * GRAVITY) + 0.05

    def _strips(self, piece: Any, xs: slice, ys: slice) -> Iterator[tuple[tuple[slice, slice], float, float]]:
        """The cells across a slope, with the heights at their lower and upper end."""
        axis, along = (0, xs) if piece.uphill[1] == "x" else (1, ys)
        start = (self.x0, self.y0)[axis]
        length = piece.high[axis] - piece.low[axis]
        for k in range(along.start, along.stop):
            way = start + k * CELL_M - piece.low[axis]
            way = way if piece.uphill[0] == "+" else length - way - CELL_M
            ends = np.array([way, way + CELL_M])
            if piece.kind == "stairs":
                ends[1] = np.ceil(ends[1] / 0.5 - 1e-6) * 0.5
            lower, upper = piece.low[2] + (piece.high[2] - piece.low[2]) * ends / length
            cell = slice(k, k + 1)
            yield ((cell, ys) if axis == 0 else (xs, cell)), float(lower), float(upper)

    def _label(self) -> None:
        self.room = np.zeros(self.free.shape, dtype=np.int32)
        self.rooms = 0
        for k in range(self.layers):
            rooms, count = label(self.free[k])
            self.room[k] = np.where(rooms > 0, rooms + self.rooms, 0)
            self.rooms += count

    def standing(self, k: int) -> np.ndarray:
        """Cells [nx, ny] of layer `k` with a floor right below."""
        below = ~self.free[k - 1] if k else self.ground
        return np.asarray(self.free[k] & below)

    def reached(self, start: tuple[float, float], jump_m: float) -> np.ndarray:
        """Which cells [K, nx, ny] feet could get to from the ground at `start`, jumping `jump_m` high."""
        layers = int(jump_m / LAYER_M + 1e-6)
        a, b = np.concatenate([pairs for k in range(self.layers) for pairs in self._ways(k, layers)], axis=1)
        graph = coo_matrix((np.ones(len(a)), (a, b)), shape=(self.rooms + 1, self.rooms + 1)).tocsr()
        i, j = int((start[0] - self.x0) / CELL_M), int((start[1] - self.y0) / CELL_M)
        first = self.room[0, i, j]
        assert first, "the start is not free"
        known = np.zeros(self.rooms + 1, dtype=bool)
        known[breadth_first_order(graph, first, return_predecessors=False)] = True
        known[0] = False
        return np.asarray(known[self.room])

    def _ways(self, k: int, jump: int) -> Iterator[np.ndarray]:
        """Pairs [2, n] of rooms: from layer `k` down, and by a jump from its floors up."""
        if k:
            down = self.free[k] & self.free[k - 1]
            yield self._distinct(self.room[k][down], self.room[k - 1][down])
        i, j = np.nonzero(self.standing(k))
        origin = self.room[k, i, j]
        for up in range(1, min(jump, self.layers - 1 - k) + 1):
            room = self.room[k + up, i, j]
            i, j, origin, room = (v[room > 0] for v in (i, j, origin, room))
            yield self._distinct(origin, room)

    def _distinct(self, a: np.ndarray, b: np.ndarray) -> np.ndarray:
        key = np.unique(a.astype(np.int64) * (self.rooms + 1) + b)
        return np.stack(np.divmod(key, self.rooms + 1))

    def points(self, cells: np.ndarray) -> np.ndarray:
        """Positions [n, 3] [m] of the cells [K, nx, ny] that are true: middle in plan, lower end in height."""
        k, i, j = np.nonzero(cells)
        return np.column_stack([self.x0 + (i + 0.5) * CELL_M, self.y0 + (j + 0.5) * CELL_M, k * LAYER_M])
