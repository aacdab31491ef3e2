"""Visitation counts n(s): how many episodes visited each cell of a grid with the cache's granularity K."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from reachtest.geometry import pack_cells
from reachtest.records import Floats, Ints


class VisitCounts:
    """Counts once per (episode, cell), as Go-Explore's authors do; also the incidence data of the risk estimate."""

    def __init__(self, cell_m: float) -> None:
        self._cell = cell_m
        self._index: dict[int, int] = {}
        self._counts = np.zeros(1024, dtype=np.int64)
        self._once = self._twice = self._seen = 0  # cells visited by exactly one episode, two, any

    def add(self, positions: Floats, episodes: Ints) -> int:
        """Count the visits of `positions` [n, 3] made in `episodes` [n].

        Returns how many of these episodes found a cell that none before them, in order of number, had been to.
        """
        keys = self._keys(positions)
        order = np.lexsort((keys, episodes))
        k, e = keys[order], episodes[order]
        first = np.ones(len(k), dtype=np.bool_)
        first[1:] = (k[1:] != k[:-1]) | (e[1:] != e[:-1])
        ids = self._ids(k[first])  # may grow the table of counts
        cells, earliest, visits = np.unique(ids, return_index=True, return_counts=True)
        before = self._counts[cells]
        after = before + visits
        self._counts[cells] = after
        self._once += int((after == 1).sum()) - int((before == 1).sum())
        self._twice += int((after == 2).sum()) - int((before == 2).sum())
        self._seen += int((before == 0).sum())
        return len(np.unique(e[first][earliest[before == 0]]))

    def cells(self, positions: Floats) -> Ints:
        """Cell ids [n] of `positions` [n, 3], for `of`."""
        return self._ids(self._keys(positions))

    def of(self, cells: NDArray[np.integer]) -> Ints:
        """Episodes that visited each of `cells` [n]."""
        return self._counts[cells]

    def incidence(self) -> tuple[int, int, int]:
        """Cells visited by exactly one episode, by exactly two, and by any."""
        return self._once, self._twice, self._seen

    def _keys(self, positions: Floats) -> Ints:
        return pack_cells(np.floor(positions / self._cell).astype(np.int64))

    def _ids(self, keys: Ints) -> Ints:
        table = self._index
        known, first, which = np.unique(keys, return_index=True, return_inverse=True)
        order = np.argsort(first)  # ids in the order of the first visit
        ids = np.empty(len(known), dtype=np.int64)
        ids[order] = [table.setdefault(key, len(table)) for key in known[order].tolist()]
        while len(table) > len(self._counts):
            self._counts = np.concatenate([self._counts, np.zeros_like(self._counts)])
        return ids[which]
