"""The position cache S_disc of the paper: exact insertion in order of discovery, a batch at a time.

What somebody stood at is discovered apart from what was flown through: jumps over a crate pass within K of all of its
top, so that nobody would ever go on from there. So is what one stood at where nobody is expected: who was on the
expected half of a ledge first would hide the other, and whether a run told of it were a matter of luck.

Shape legend: n positions of a batch, P cached points.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from reachtest.explore.forest import Forest, Run
from reachtest.explore.rows import Rows
from reachtest.records import Bools, Floats, Ints

_WIDER = 1.0 + 1e-6  # the trees are asked a little farther than K, so that rounding decides nothing
_NEARER = 1.0 - 1e-6


class PositionCache:
    """Points pairwise more than `threshold_m` apart, and those that were stood at, or stood at and unexpected, and are
    so far from others such."""

    def __init__(self, threshold_m: float) -> None:
        self._anywhere, self._stood_at, self._astray = (Spaced(threshold_m) for _ in range(3))
        self._positions = Rows(3)

    def __len__(self) -> int:
        return len(self._positions)

    @property
    def positions(self) -> Floats:
        """[P, 3] in order of discovery."""
        return np.asarray(self._positions.values, dtype=np.float64)

    def insert(self, positions: Floats, stands: Bools | None = None, astray: Bools | None = None) -> Ints:
        """Offer `positions` [n, 3] one after the other, of which one `stands` [n] at some, and there is `astray` [n]
        at some of these; the indices of those that were inserted.

        A position is inserted if d(S_disc, s) > K at its turn, or if one stands there and that is so of the positions
        one stood at, or astray and of the positions one was astray at.
        """
        new = self._anywhere.insert(positions)
        for some, apart in ((stands, self._stood_at), (astray, self._astray)):
            if some is not None:
                rows = np.flatnonzero(some)
                new = np.union1d(new, rows[apart.insert(positions[rows])])
        self._positions.append(positions[new])
        return new


class Spaced:
    """Points pairwise more than `threshold_m` apart."""

    def __init__(self, threshold_m: float) -> None:
        self.threshold_m = threshold_m
        self._points = Forest()

    def insert(self, positions: Floats) -> Ints:
        """Offer `positions` [n, 3] one after the other; the indices of those that were inserted.

        A position is inserted when there is none yet, or all are farther than K at its turn.
        """
        open_ = np.arange(len(positions))
        for run in self._points.runs:
            open_ = open_[~self._known(run, positions[open_])]
        new = open_[self._thin(positions[open_])]
        if len(new):
            self._points.append(positions[new])
        return new

    def _known(self, run: Run, positions: Floats) -> Bools:
        """Which positions [n] lie within K of one of the run's points."""
        near, _ = run.tree.query(positions, distance_upper_bound=self.threshold_m * _WIDER)
        known = np.asarray(near <= self.threshold_m * _NEARER, dtype=np.bool_)
        for i in np.flatnonzero(np.isfinite(near) & ~known).tolist():  # at K to within rounding
            rivals = run.begin + np.array(run.tree.query_ball_point(positions[i], self.threshold_m * _WIDER))
            known[i] = _distance(self._points.positions[rivals], positions[i]).min() <= self.threshold_m
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


def _distance(a: Floats, b: Floats) -> Floats:
    away = a - b
    return np.asarray(np.sqrt((away * away).sum(axis=-1)), dtype=np.float64)
