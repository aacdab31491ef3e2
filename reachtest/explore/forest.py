"""k-d trees over points that come in batches.

k-d trees cannot grow, so there are several, each over a run of points and several times larger than the next, as in a
log-structured merge tree (O'Neil et al., Acta Informatica 33, 1996).

Shape legend: n queries, P points.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from reachtest.explore.rows import Rows
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
        self._positions = Rows(3)

    def __len__(self) -> int:
        return len(self._positions)

    @property
    def positions(self) -> Floats:
        """[P, 3]"""
        return np.asarray(self._positions.values, dtype=np.float64)

    def append(self, new: Floats) -> None:
        """Add points [n, 3]."""
        if not len(new):
            return
        begin = len(self)
        self._positions.append(new)
        while self.runs and self.runs[-1].end - self.runs[-1].begin < _GROWTH * (len(self) - begin):
            begin = self.runs.pop().begin
        self.runs.append(Run(begin, len(self), cKDTree(self.positions[begin:])))

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
