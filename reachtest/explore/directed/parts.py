"""Parts of the nav-mesh that are still open, and the attempts in vain to get into each.

An attempt is in vain as long as nobody gets to any goal of the part: then its border is another one, and there they
count anew. What a round looks at may be a sample of a large part; its attempts count for the whole of it.

Shape legend: G goals, n chosen goals, E pairs of neighbours.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from reachtest.records import Bools, Floats, Ints


class Efforts:
    """Counts attempts at goals, part by part of those that are open."""

    def __init__(self, goals: Floats, link_m: float) -> None:
        """`goals` [G, 3]; two of them nearer than `link_m` are in one part while both are open."""
        self.attempts: Ints = np.zeros(len(goals), dtype=np.int64)  # [G] in vain, from the border
        self._pairs = _neighbours(goals, link_m)  # [E, 2]
        self._open: Bools = np.zeros(len(goals), dtype=np.bool_)
        self._part: Ints = np.arange(len(goals))  # [G] each goal's part, among those open last time

    def forget(self, open_: Bools, reached: Bools) -> None:
        """Count anew at every part of which somebody `reached` [G] a goal since; `open_` [G] are open now."""
        if (open_ == self._open).all():
            return
        went_on = np.unique(self._part[self._open & reached])
        self.attempts[self._open & np.isin(self._part, went_on)] = 0
        pairs = self._pairs[open_[self._pairs].all(axis=1)]
        self._open, self._part = open_.copy(), _components(pairs, len(open_))

    def of_parts(self) -> Ints:
        """Attempts [G] at the whole open part that a goal lies in; what is deep in it is never aimed at."""
        total = np.bincount(self._part, weights=self.attempts * self._open, minlength=len(self._part))
        return np.where(self._open, total[self._part], self.attempts).astype(np.int64)


def parts_among(places: Floats, link_m: float) -> Ints:
    """Which connected part each of `places` [n, 3] belongs to [n]."""
    return _components(_neighbours(places, link_m), len(places))


def _neighbours(places: Floats, link_m: float) -> Ints:
    return np.asarray(cKDTree(places).query_pairs(link_m, output_type="ndarray"), dtype=np.int64).reshape(
        -1, 2
    )


def _components(pairs: Ints, count: int) -> Ints:
    graph = coo_matrix((np.ones(len(pairs), dtype=np.int8), (pairs[:, 0], pairs[:, 1])), shape=(count, count))
    return np.asarray(connected_components(graph, directed=False)[1], dtype=np.int64)
