"""Parts of the nav-mesh that are still open, and the attempts in vain to get into each.

An attempt is in vain as long as nobody gets to any goal of the part: then its border is another one, and there they
count anew. What a round looks at may be a sample of a large part; its attempts count for the whole of it.

Shape legend: G goals, n chosen goals, E pairs of neighbours.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from reachtest.connected import inner_pairs, part_labels
from reachtest.records import Bools, Floats, Ints


class Efforts:
    """Counts attempts at goals, part by part of those that are open."""

    def __init__(self, goals: Floats, link_m: float) -> None:
        """`goals` [G, 3]; two of them nearer than `link_m` are in one part while both are open."""
        self.attempts: Ints = np.zeros(len(goals), dtype=np.int64)  # [G] in vain, from the border
        pairs = cKDTree(goals).query_pairs(link_m, output_type="ndarray")
        self._pairs: Ints = np.asarray(pairs, dtype=np.int64).reshape(-1, 2)
        self._open: Bools = np.zeros(len(goals), dtype=np.bool_)
        self._part: Ints = np.full(len(goals), -1, dtype=np.int64)  # [G] of those open last time

    def forget(self, open_: Bools, reached: Bools) -> None:
        """Count anew at every part of which somebody `reached` [G] a goal since; `open_` [G] are open now."""
        if (open_ == self._open).all():
            return
        went_on = np.unique(self._part[self._open & reached])
        self.attempts[self._open & np.isin(self._part, went_on)] = 0
        rows = np.flatnonzero(open_)
        self._open = open_.copy()
        self._part[rows] = self.parts_among(rows)

    def parts_among(self, goals: Ints) -> Ints:
        """Which connected part each of `goals` [n] belongs to [n], as if there were no others."""
        return part_labels(len(goals), inner_pairs(self._pairs, goals, len(self.attempts)))

    def of_parts(self) -> Ints:
        """Attempts [G] at the whole open part that a goal lies in; what is deep in it is never aimed at."""
        result, part = self.attempts.copy(), self._part[self._open]
        if len(part):
            result[self._open] = np.bincount(part, weights=result[self._open])[part]
        return result
