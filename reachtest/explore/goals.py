"""Goals: points on the nav-mesh that the exploration should come within a metre of.

Shape legend: G goals, P cached points.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from reachtest.geometry import triangle_normals
from reachtest.records import Bools, Floats, Ints, NavMesh

_SAMPLES_PER_GOAL = 12  # candidates a goal: enough that hardly a place farther than the spacing is left
_LEAST_BLOCK = 500  # candidates: a tree for fewer costs more than it saves
_COARSE_M = 8.0  # an episode's positions share few cells of this size
_GOAL_SEED = 0x60A1  # goals belong to the level, not to the run: the same for every seed


def sample_goals(navmesh: NavMesh, spacing_m: float) -> Floats:
    """Points [G, 3] on the surface, at least `spacing_m` apart and hardly farther than that from any of it.

    Random candidates by area plus every triangle's centre, thinned greedily in random order (Poisson disk).
    """
    triangles = navmesh.triangles
    _, area = triangle_normals(triangles)
    rng = np.random.default_rng(_GOAL_SEED)
    count = int(np.ceil(_SAMPLES_PER_GOAL * area.sum() / spacing_m**2))
    chosen = rng.choice(len(triangles), size=count, p=area / area.sum())
    u, v = np.sqrt(rng.random(count)), rng.random(count)
    weights = np.stack([1 - u, u * (1 - v), u * v], axis=1)
    candidates = np.einsum("nk,nkd->nd", weights, triangles[chosen])
    candidates = np.concatenate([candidates, triangles[area > 0].mean(axis=1)])
    return _thin(candidates, spacing_m)


def _thin(candidates: Floats, spacing_m: float) -> Floats:
    """The candidates [n, k] that have none of those kept before them within the spacing, in their order.

    A block at a time, as long as there are goals: most of a block lies near one of these and is gone at once.
    """
    kept = candidates[:0]
    begin = 0
    while begin < len(candidates):
        block = candidates[begin : begin + max(_LEAST_BLOCK, len(kept))]
        begin += len(block)
        if len(kept):
            _, nearest = cKDTree(kept).query(block, distance_upper_bound=_reach(spacing_m))
            nearest = np.asarray(nearest)
            beside = np.flatnonzero(nearest < len(kept))
            crowded = _closer(block[beside], kept[nearest[beside]], spacing_m)
            block = np.delete(block, beside[crowded], axis=0)
        kept = np.concatenate([kept, _greedy(block, spacing_m)])
    return kept


def _greedy(points: Floats, spacing_m: float) -> Floats:
    """The same among points [n, 3] that are few."""
    pairs = cKDTree(points).query_pairs(_reach(spacing_m), output_type="ndarray")
    pairs = pairs[_closer(points[pairs[:, 0]], points[pairs[:, 1]], spacing_m)]
    keep = np.ones(len(points), dtype=np.bool_).tolist()
    for first, second in sorted(map(tuple, pairs.tolist())):  # all that could drop `first` came before
        if keep[first]:
            keep[second] = False
    return points[keep]


def _closer(one: Floats, other: Floats, spacing_m: float) -> Bools:
    away = one - other
    return np.asarray((away * away).sum(axis=1) < spacing_m**2)


def _reach(spacing_m: float) -> float:
    return spacing_m * (1 + 1e-9)  # the tree's rounding; `_closer` decides


class GoalSet:
    """Which goals are still open, and how far every cached point is from the nearest of them."""

    def __init__(self, goals: Floats, radius_m: Floats) -> None:
        """`goals` [G, 3], each closed by the first position within its own radius [G]."""
        self.goals = goals
        self.reached_step: Ints = np.full(len(goals), -1, dtype=np.int64)
        self._radius = radius_m
        self._nearest: Ints = np.empty(0, dtype=np.int64)  # [P] open goal nearest to each point
        self._distance: Floats = np.empty(0)  # [P]
        self._rebuild()

    def drain(self, positions: Floats, steps: Ints) -> None:
        """Close every goal within its radius of one of `positions` [n, 3], visited at `steps` [n] (ascending)."""
        if self._tree is None or not len(positions):
            return
        near = self._near(positions)
        if not len(near):
            return
        visitors = cKDTree(positions).query_ball_point(self.goals[near], self._radius[near])
        for goal, who in zip(near.tolist(), visitors, strict=True):
            if who:
                self.reached_step[goal] = steps[min(who)]
        self._rebuild()

    def distances(self, points: Floats) -> Floats:
        """Distance [P] of every cached point to its nearest open goal [m]; infinite when none is open.

        Goals only ever close, so a point's distance changes only when its nearest goal does.
        """
        fresh = len(points) - len(self._nearest)
        self._nearest = np.append(self._nearest, np.full(fresh, -1))
        self._distance = np.append(self._distance, np.full(fresh, np.inf))
        if self._tree is None:
            self._distance[:] = np.inf
            return self._distance
        stale = np.flatnonzero((self._nearest < 0) | (self.reached_step[self._nearest] >= 0))
        if len(stale):
            near, place = self._tree.query(points[stale])
            self._nearest[stale], self._distance[stale] = self._open[place], near
        return self._distance

    def _near(self, positions: Floats) -> Ints:
        """Open goals that one of the positions can be within the radius of: those near a coarse cell of theirs."""
        assert self._tree is not None
        cells = np.unique(np.floor(positions / _COARSE_M), axis=0)
        reach = _COARSE_M * np.sqrt(3) / 2 + self._radius.max()
        found = self._tree.query_ball_point((cells + 0.5) * _COARSE_M, reach)
        return self._open[np.unique(np.concatenate([np.array(f, dtype=np.int64) for f in found]))]

    def _rebuild(self) -> None:
        self._open: Ints = np.flatnonzero(self.reached_step < 0)
        self._tree: cKDTree | None = cKDTree(self.goals[self._open]) if len(self._open) else None
