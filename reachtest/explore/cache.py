"""The position cache S_disc of the paper: exact insertion in order of discovery, a batch at a time.

Shape legend: n positions of a batch, P cached points.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from reachtest.records import Bools, Floats, Ints

_GROWTH = 3  # a tree is merged into the one before when that is not this much larger: few trees, few rebuilds
_WIDER = 1.0 + 1e-6  # the trees are asked a little farther than K, so that rounding decides nothing
_NEARER = 1.0 - 1e-6


@dataclass(frozen=True)
class _Run:
    """A k-d tree over the cached points `begin` to `end`."""

    begin: int
    end: int
    tree: cKDTree


class PositionCache:
    """Points pairwise more than `threshold_m` apart.

    k-d trees cannot grow, so there are several, each over a run of points and several times larger than the
    next, as in a log-structured merge tree (O'Neil et al., Acta Informatica 33, 1996).
    """

    def __init__(self, threshold_m: float) -> None:
        self.threshold_m = threshold_m
        self._positions = np.empty((1024, 3))
        self._count = 0
        self._runs: list[_Run] = []

    def __len__(self) -> int:
        return self._count

    @property
    def positions(self) -> Floats:
        """[P, 3] in order of discovery."""
        return self._positions[: self._count]

    def insert(self, positions: Floats) -> Ints:
        """Offer `positions` [n, 3] one after the other; the indices of those that were inserted.

        A position is inserted when the cache is empty or d(S_disc, s) > K at its turn.
        """
        open_ = np.arange(len(positions))
        for run in self._runs:
            open_ = open_[~self._known(run, positions[open_])]
        new = open_[self._thin(positions[open_])]
        if len(new):
            self._append(positions[new])
        return new

    def nearest(self, places: Floats, count: int) -> tuple[Floats, Ints]:
        """The `count` cached points nearest to each of `places` [n, 3]: distances and indices [n, count].

        Where there are fewer, the rest is infinitely far and has index -1.
        """
        away = np.full((len(places), count), np.inf)
        who = np.full((len(places), count), -1, dtype=np.int64)
        for run in self._runs:
            near, place = run.tree.query(places, k=np.arange(1, count + 1))
            both = np.concatenate([away, near], axis=1)
            ids = np.concatenate([who, np.where(np.isfinite(near), run.begin + place, -1)], axis=1)
            order = np.argsort(both, axis=1, kind="stable")[:, :count]
            away, who = np.take_along_axis(both, order, axis=1), np.take_along_axis(ids, order, axis=1)
        return away, who

    def _known(self, run: _Run, positions: Floats) -> Bools:
        """Which positions [n] lie within K of one of the run's points."""
        near, _ = run.tree.query(positions, distance_upper_bound=self.threshold_m * _WIDER)
        known = np.asarray(near <= self.threshold_m * _NEARER, dtype=np.bool_)
        for i in np.flatnonzero(np.isfinite(near) & ~known).tolist():  # at K to within rounding
            rivals = run.begin + np.array(run.tree.query_ball_point(positions[i], self.threshold_m * _WIDER))
            known[i] = _distance(self._positions[rivals], positions[i]).min() <= self.threshold_m
        return known

    def _thin(self, positions: Floats) -> Bools:
        """Which of positions [n] are farther than K from all that were kept before them."""
        kept = np.ones(len(positions), dtype=np.bool_)
        if len(positions) < 2:
            return kept
        pairs = cKDTree(positions).query_pairs(self.threshold_m * _WIDER, output_type="ndarray")
        pairs = pairs[_distance(positions[pairs[:, 0]], positions[pairs[:, 1]]) <= self.threshold_m]
        pairs = pairs[np.argsort(pairs[:, 0], kind="stable")]  # the first of a pair is the earlier one
        begin = np.searchsorted(pairs[:, 0], np.arange(len(positions) + 1)).tolist()
        for i in np.unique(pairs[:, 0]).tolist():
            if kept[i]:
                kept[pairs[begin[i] : begin[i + 1], 1]] = False
        return kept

    def _append(self, new: Floats) -> None:
        begin, self._count = self._count, self._count + len(new)
        while self._count > len(self._positions):
            self._positions = np.concatenate([self._positions, np.empty_like(self._positions)])
        self._positions[begin : self._count] = new
        while self._runs and self._runs[-1].end - self._runs[-1].begin < _GROWTH * (self._count - begin):
            begin = self._runs.pop().begin
        self._runs.append(_Run(begin, self._count, cKDTree(self._positions[begin : self._count])))


def _distance(a: Floats, b: Floats) -> Floats:
    away = a - b
    return np.asarray(np.sqrt((away * away).sum(axis=-1)), dtype=np.float64)
