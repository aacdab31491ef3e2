"""k-d trees over points that come in batches.

k-d trees cannot grow, so there are several, each over a run of points and several times larger than the next, as in a
log-structured merge tree (O'Neil et al., Acta Informatica 33, 1996).

Shape legend: n queries, P points.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from reachtest.records import Floats, Ints

_GROWTH = 3  # a tree is merged into the one before when that is not this much larger: few trees, few rebuilds


@dataclass(frozen=True)
class Run:
    """A k-d tree over the points `begin` to `end`."""

    begin: int
    end: int
    tree: cKDTree


class Forest:
    """Points in the order they came in."""

    def __init__(self) -> None:
        self.runs: list[Run] = []
        self._positions = np.empty((1024, 3))
        self._count = 0

    def __len__(self) -> int:
        return self._count

    @property
    def positions(self) -> Floats:
        """[P, 3]"""
        return self._positions[: self._count]

    def append(self, new: Floats) -> None:
        """Add points [n, 3]."""
        if not len(new):
            return
        begin, self._count = self._count, self._count + len(new)
        while self._count > len(self._positions):
            self._positions = np.concatenate([self._positions, np.empty_like(self._positions)])
        self._positions[begin : self._count] = new
        while self.runs and self.runs[-1].end - self.runs[-1].begin < _GROWTH * (self._count - begin):
            begin = self.runs.pop().begin
        self.runs.append(Run(begin, self._count, cKDTree(self._positions[begin : self._count])))

    def nearest(self, places: Floats, count: int) -> tuple[Floats, Ints]:
        """The `count` points nearest to each of `places` [n, 3]: distances and indices [n, count].

        Where there are fewer, the rest is infinitely far and has index -1.
        """
        away = np.full((len(places), count), np.inf)
        who = np.full((len(places), count), -1, dtype=np.int64)
        for run in self.runs:
            near, place = run.tree.query(places, k=np.arange(1, count + 1))
            both = np.concatenate([away, near], axis=1)
            ids = np.concatenate([who, np.where(np.isfinite(near), run.begin + place, -1)], axis=1)
            order = np.argsort(both, axis=1, kind="stable")[:, :count]
            away, who = np.take_along_axis(both, order, axis=1), np.take_along_axis(ids, order, axis=1)
        return away, who
