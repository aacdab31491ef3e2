"""Triangles by the cells of a horizontal grid, walls included: which ones are near a point.

Shape legend: F triangles, n points.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from reachtest.records import Floats, Ints

_MOST_CELLS = 4_000_000
_PAIRS_AT_ONCE = 1 << 20  # bounds the memory of one vectorised pass to about 200 MB


class Columns:
    """Each triangle stands in every cell within `reach_m` of its box."""

    def __init__(self, triangles: Floats, reach_m: float, cell_m: float) -> None:
        """Index triangles [F, 3, 3]."""
        flat = triangles[:, :, :2]
        low, high = flat.min(axis=1) - reach_m, flat.max(axis=1) + reach_m
        self._low = low.min(axis=0) if len(flat) else np.zeros(2)
        extent = high.max(axis=0) - self._low if len(flat) else np.zeros(2)
        self._cell = max(cell_m, float(np.sqrt(extent.prod() / _MOST_CELLS)))
        self._shape = (extent // self._cell).astype(np.int64) + 1
        first = ((low - self._low) // self._cell).astype(np.int64)
        span = ((high - self._low) // self._cell).astype(np.int64) - first + 1
        row, place = ragged(span.prod(axis=1))
        key = (first[row, 0] + place // span[row, 1]) * self._shape[1] + first[row, 1] + place % span[row, 1]
        order = np.argsort(key, kind="stable")
        self._members = row[order]
        self._start = np.searchsorted(key[order], np.arange(self._shape.prod() + 1))

    def pairs(self, points: Floats) -> Iterator[tuple[int, int, Ints, Ints]]:
        """Points [n, 3] a slice at a time: begin, end, and the (row within the slice, triangle) pairs near."""
        cell = ((points[:, :2] - self._low) // self._cell).astype(np.int64)
        known = ((cell >= 0) & (cell < self._shape)).all(axis=1)
        key = np.where(known, cell[:, 0] * self._shape[1] + cell[:, 1], 0)
        counts = np.where(known, self._start[key + 1] - self._start[key], 0)
        total, begin = np.cumsum(counts), 0
        while begin < len(points):
            done = total[begin - 1] if begin else 0
            end = max(begin + 1, int(np.searchsorted(total, done + _PAIRS_AT_ONCE)))
            row, place = ragged(counts[begin:end])
            yield begin, end, row, self._members[self._start[key[begin:end]][row] + place]
            begin = end


def ragged(counts: Ints) -> tuple[Ints, Ints]:
    """For rows of `counts` items: the row of every item, and its place within the row."""
    row = np.repeat(np.arange(len(counts)), counts)
    return row, np.arange(len(row)) - np.repeat(np.cumsum(counts) - counts, counts)
