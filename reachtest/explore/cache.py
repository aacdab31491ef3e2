"""The position cache S_disc of the paper: exact insertion in order of discovery, with an R*-tree.

Shape legend: n positions of a batch, P cached points.
"""

from __future__ import annotations

import numpy as np
from rtree import index
from scipy.spatial import cKDTree

from reachtest.records import Bools, Floats, Ints

_REBUILD_GROWTH = 1.2  # the snapshot is rebuilt after this growth: amortised O(log P) a point
_SURELY = 1.0 - 1e-9  # the snapshot only answers where rounding cannot change the answer
_WIDER = 1.0 + 1e-6  # the box asked in the tree must not lose a rival at exactly K to rounding


class PositionCache:
    """Points pairwise more than `threshold_m` apart.

    A k-d tree over a snapshot of the points proves d(S_disc, s) <= K for nearly every position at once; what it
    cannot prove (new ground, or near a point added since) is decided one by one in the R*-tree.
    """

    def __init__(self, threshold_m: float) -> None:
        self.threshold_m = threshold_m
        self._positions = np.empty((1024, 3))
        self._count = 0
        self._snapshot: cKDTree | None = None
        self._tree = index.Index(properties=index.Property(dimension=3, variant=index.RT_Star))

    def __len__(self) -> int:
        return self._count

    @property
    def positions(self) -> Floats:
        """The cached points [P, 3], in order of discovery."""
        return self._positions[: self._count]

    def insert(self, positions: Floats) -> Ints:
        """Offer `positions` [n, 3] one after the other; the indices of those that were inserted.

        A position is inserted when the cache is empty or d(S_disc, s) > K at its turn.
        """
        unproven = np.flatnonzero(~self._surely_known(positions))
        new = [int(i) for i in unproven if self._offer(positions[i])]
        if self._snapshot is None or self._count > _REBUILD_GROWTH * self._snapshot.n:
            self._snapshot = cKDTree(self.positions) if self._count else None
        return np.array(new, dtype=np.int64)

    def _surely_known(self, positions: Floats) -> Bools:
        if self._snapshot is None or not len(positions):
            return np.zeros(len(positions), dtype=np.bool_)
        near, _ = self._snapshot.query(positions, distance_upper_bound=self.threshold_m * _SURELY)
        return np.asarray(np.isfinite(near), dtype=np.bool_)

    def _offer(self, position: Floats) -> bool:
        reach = self.threshold_m * _WIDER
        low, high = position - reach, position + reach
        rivals = list(self._tree.intersection((*low, *high)))
        if rivals:
            away = self._positions[rivals] - position
            if np.sqrt((away * away).sum(axis=1).min()) <= self.threshold_m:
                return False
        self._append(position)
        return True

    def _append(self, position: Floats) -> None:
        if self._count == len(self._positions):
            self._positions = np.concatenate([self._positions, np.empty_like(self._positions)])
        self._positions[self._count] = position
        self._tree.insert(self._count, (*position, *position))
        self._count += 1
