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

CELL_M = 1.0


class Astray:
    """Tells unexpected positions from expected ones."""

    def __init__(self, surface: Surface, expected_within_m: float) -> None:
        """`surface` tells distances up to `expected_within_m`."""
        self._surface = surface
        self._sure_m = (
            expected_within_m - CELL_M * math.sqrt(3.0) / 2
        )  # of a cell's middle, and no corner is astray
        self._sure: dict[int, bool] = {}

    def __call__(self, positions: Floats) -> Bools:
        """Whether each of `positions` [n, 3] is unexpected [n]."""
        cells = np.floor(positions / CELL_M).astype(np.int64)
        keys, first, which = np.unique(pack_cells(cells), return_index=True, return_inverse=True)
        result: Bools = ~self._sure_of(keys, cells[first])[which.reshape(-1)]
        unsure = np.flatnonzero(result)
        result[unsure] = np.isinf(self._surface.distance(positions[unsure]))
        return result

    def _sure_of(self, keys: Ints, cells: Ints) -> Bools:
        """Whether all of each cell [c, 3], known by its key [c], is expected."""
        names = keys.tolist()
        new = [row for row, key in enumerate(names) if key not in self._sure]
        away = self._surface.distance((cells[new].astype(np.float64) + 0.5) * CELL_M)
        # Nowhere off is the nav-mesh itself, or a zone: that may end anywhere.
        sure = (away > 0.0) & (away <= self._sure_m)
        self._sure |= zip((names[row] for row in new), sure.tolist(), strict=True)
        return np.array([self._sure[key] for key in names], dtype=np.bool_)
