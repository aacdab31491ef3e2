"""Who stands where nobody is expected, of all agent steps: cached points are a metre apart, and a ledge is not.

Distances to a nav-mesh are dear and nearly everybody is well within reach of it, so each cell of a grid is measured
once, and who stands in a cell that is expected as a whole is not.

Shape legend: n positions, c cells.
"""

from __future__ import annotations

import math

import numpy as np

from reachtest.geometry import pack_cells
from reachtest.interfaces import Surface
from reachtest.records import Bools, Floats, Ints

_CELL_M, _CELLS = 1.0, 0.5  # side of a cell: so much, or that share of what is expected where that is less
_SHIFT_M = 0.137  # so that no cell's middle lies on a floor, as a rule: floors are at whole and half metres


class Astray:
    """Tells unexpected positions from expected ones."""

    def __init__(self, surface: Surface, expected_within_m: float) -> None:
        """`surface` tells distances up to `expected_within_m`."""
        self._surface = surface
        self._cell_m = min(_CELL_M, _CELLS * expected_within_m)
        # Of a cell's middle: then no corner is astray.
        self._sure_m = expected_within_m - self._cell_m * math.sqrt(3.0) / 2
        self._sure: dict[int, bool] = {}

    def __call__(self, positions: Floats) -> Bools:
        """Whether each of `positions` [n, 3] is unexpected [n]."""
        cells = np.floor((positions + _SHIFT_M) / self._cell_m).astype(np.int64)
        keys, first, which = np.unique(pack_cells(cells), return_index=True, return_inverse=True)
        result: Bools = ~self._sure_of(keys, cells[first])[which.reshape(-1)]
        unsure = np.flatnonzero(result)
        result[unsure] = np.isinf(self._surface.distance(positions[unsure]))
        return result

    def _sure_of(self, keys: Ints, cells: Ints) -> Bools:
        """Whether all of each cell [c, 3], known by its key [c], is expected."""
        names = keys.tolist()
        new = [row for row, key in enumerate(names) if key not in self._sure]
        away = self._surface.distance((cells[new].astype(np.float64) + 0.5) * self._cell_m - _SHIFT_M)
        # No distance at all is that of a zone, as a rule: that may end anywhere.
        sure = (away > 0.0) & (away <= self._sure_m)
        self._sure |= zip((names[row] for row in new), sure.tolist(), strict=True)
        return np.array([self._sure[key] for key in names], dtype=np.bool_)
