"""Goals: points on the nav-mesh that the exploration should come within a metre of.

Shape legend: G goals, P cached points.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial import cKDTree

from reachtest.geometry import triangle_normals
from reachtest.records import Floats, Ints, NavMesh, Required

_SAMPLES_PER_GOAL = 12  # candidates a goal: enough that hardly a place farther than the spacing is left
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
    grid: dict[tuple[int, int, int], list[int]] = {}
    cells = np.floor(candidates / spacing_m).astype(int).tolist()
    around = [(i, j, k) for i in (-1, 0, 1) for j in (-1, 0, 1) for k in (-1, 0, 1)]
    kept: list[int] = []
    for index, (x, y, z) in enumerate(cells):
        rivals = [r for i, j, k in around for r in grid.get((x + i, y + j, z + k), ())]
        if rivals:
            away = candidates[rivals] - candidates[index]
            if (away * away).sum(axis=1).min() < spacing_m**2:
                continue
        grid.setdefault((x, y, z), []).append(index)
        kept.append(index)
    return candidates[kept]


class GoalSet:
    """Which goals are still open, and how far every cached point is from the nearest of them."""

    def __init__(self, goals: Floats, radius_m: float) -> None:
        self.goals = goals
        self.reached_step: Ints = np.full(len(goals), -1, dtype=np.int64)
        self._radius = radius_m
        self._nearest: Ints = np.empty(0, dtype=np.int64)  # [P] open goal nearest to each point
        self._distance: Floats = np.empty(0)  # [P]
        self._rebuild()

    @property
    def reached(self) -> int:
        """How many goals have been reached."""
        return int((self.reached_step >= 0).sum())

    def drain(self, positions: Floats, steps: Ints) -> None:
        """Close every goal within the radius of one of `positions` [n, 3], visited at `steps` [n] (ascending)."""
        while len(self._open):
            near, place = self._tree.query(positions, distance_upper_bound=self._radius)
            hits = np.flatnonzero(np.isfinite(near))
            if not len(hits):
                return
            goals, first = np.unique(self._open[place[hits]], return_index=True)
            # The first position nearest to a goal need not be the first within the radius of it.
            away = np.linalg.norm(positions[:, None, :] - self.goals[goals][None], axis=2) <= self._radius
            self.reached_step[goals] = steps[away.argmax(axis=0)]
            self._rebuild()

    def distances(self, points: Floats) -> Floats:
        """Distance [P] of every cached point to its nearest open goal [m]; infinite when none is open.

        Goals only ever close, so a point's distance changes only when its nearest goal does.
        """
        known = len(self._nearest)
        fresh = np.arange(known, len(points))
        self._nearest = np.append(self._nearest, np.full(len(fresh), -1))
        self._distance = np.append(self._distance, np.full(len(fresh), np.inf))
        stale = np.flatnonzero((self._nearest < 0) | (self.reached_step[self._nearest] >= 0))
        if not len(self._open):
            self._distance[:] = np.inf
        elif len(stale):
            near, place = self._tree.query(points[stale])
            self._nearest[stale], self._distance[stale] = self._open[place], near
        return self._distance

    def _rebuild(self) -> None:
        self._open: Ints = np.flatnonzero(self.reached_step < 0)
        self._tree = cKDTree(self.goals[self._open]) if len(self._open) else None




def note_first_visits(visited: Ints, required: Sequence[Required], positions: Floats, steps: Ints) -> None:
    """Enter in `visited` [R] (-1: not yet) the step at which a position [n, 3] first came near enough."""
    for index in np.flatnonzero(visited < 0):
        place = required[index]
        near = np.linalg.norm(positions - place.position, axis=1) <= place.within_m
        if near.any():
            visited[index] = steps[near.argmax()]
