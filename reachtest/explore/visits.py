"""Visitation counts n(s): how many episodes visited each cell of a grid with the cache's granularity K."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from reachtest.records import Floats, Ints

_OFFSET = 1 << 20  # cells are counted from -2^20: 1,000 km each way at K = 1 m


class VisitCounts:
    """Counts once per (episode, cell), as Go-Explore's authors do; also the incidence data of the risk estimate."""

    def __init__(self, cell_m: float) -> None:
        self._cell = cell_m
        self._index: dict[int, int] = {}
        self._counts = np.zeros(1024, dtype=np.int64)

    def add(self, positions: Floats, episodes: Ints) -> None:
        """Count the visits of `positions` [n, 3] made in `episodes` [n]."""
        keys = self._keys(positions)
        order = np.lexsort((keys, episodes))
        k, e = keys[order], episodes[order]
        first = np.ones(len(k), dtype=np.bool_)
        first[1:] = (k[1:] != k[:-1]) | (e[1:] != e[:-1])
        ids = self._ids(k[first])  # may grow the table of counts
        np.add.at(self._counts, ids, 1)

    def cells(self, positions: Floats) -> Ints:
        """Cell ids [n] of `positions` [n, 3], for `of`."""
        return self._ids(self._keys(positions))

    def of(self, cells: NDArray[np.integer]) -> Ints:
        """Episodes that visited each of `cells` [n]."""
        return self._counts[cells]

    def incidence(self) -> tuple[int, int, int]:
        """Cells visited by exactly one episode, by exactly two, and by any."""
        seen = self._counts[: len(self._index)]
        return int((seen == 1).sum()), int((seen == 2).sum()), int((seen > 0).sum())

    def _keys(self, positions: Floats) -> Ints:
        cell = np.floor(positions / self._cell).astype(np.int64) + _OFFSET
        return (cell[:, 0] << 42) | (cell[:, 1] << 21) | cell[:, 2]

    def _ids(self, keys: Ints) -> Ints:
        table = self._index
        ids = np.array([table.setdefault(key, len(table)) for key in keys.tolist()], dtype=np.int64)
        while len(table) > len(self._counts):
            self._counts = np.concatenate([self._counts, np.zeros_like(self._counts)])
        return ids
