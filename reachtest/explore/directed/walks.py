"""Walks that are worked out: from where, and which way, somebody walks straight to a place.

A stick has eight directions and cached points are a metre apart, so that few who push towards the far end of a beam
stand in line with it. What is worked out has a floor under it all along; what stands in its way shows when it is tried.

Shape legend: k starts, W walks, T agent steps, c candidates.
"""

from __future__ import annotations

from collections import defaultdict

import numpy as np

from reachtest.columns import ColumnIndex
from reachtest.explore.actions import WALKS_AIMED
from reachtest.explore.aimed import AIMED_WALKS, BETWEEN, WAIT_STEPS, WALK_STEPS, aimed_walk
from reachtest.geometry import indices
from reachtest.records import Bools, Character, ExploreSettings, Floats, Ints
from reachtest.walking import Walk

MOST_BESIDE_M = 0.5  # what passes farther from a place is no walk to it
SPREAD_M = 0.15  # walks that pass by so much farther off are taken e times less: half of a narrow beam
STARTS_AT_ONCE = 8  # of those near a place
CANDIDATES = 64  # whose floor is looked for
FLOOR_M = 1.0  # above or below the straight line: stairs, and the foot of a ramp


class Walks:
    """The walks of a character from rest, and which were taken."""

    def __init__(self, who: Character, settings: ExploreSettings, columns: ColumnIndex) -> None:
        """`columns` tells where there are floors."""
        self._rule = Walk.of(who, 1.0 / settings.physics_hz)
        self._wait_ticks = WAIT_STEPS * settings.action_repeat
        self._columns, self._slope_cos = columns, float(np.cos(np.radians(who.slope_limit_deg)))
        self._paths = _paths(self._rule, settings.action_repeat)
        self._begin, self._ways = _lines(self._paths)
        self._drawn: defaultdict[int, list[int]] = defaultdict(list)  # walks, by cached point

    def draw(
        self, rng: np.random.Generator, place: Floats, points: Ints, positions: Floats, velocities: Floats
    ) -> tuple[int, int] | None:
        """The cached point, of `points` [k] at `positions` [k, 3] on the ground, and the heading of a walk over `place`
        [3], or towards it if it is far; None if none is found among some that were not taken before."""
        some = rng.permutation(len(points))[:STARTS_AT_ONCE]
        run_out, still = self._rule.run_out(velocities[some, :2], self._wait_ticks)
        rest = positions[some]
        rest[:, :2] += run_out
        beside_m = self._beside_m((place - rest)[:, :2])
        beside_m[~still] = np.inf
        for row, point in enumerate(points[some].tolist()):  # the same start and actions end the same way
            beside_m[row, self._drawn[point]] = np.inf
        rows, walks = np.nonzero(beside_m < MOST_BESIDE_M)
        if not len(rows):
            return None
        weight = np.exp(-beside_m[rows, walks] / SPREAD_M)
        drawn = rng.choice(len(rows), min(CANDIDATES, len(rows)), replace=False, p=weight / weight.sum())
        rows, walks = rows[drawn], walks[drawn]
        whole = indices(self._has_floor(rest[rows], self._paths[walks], place))
        if not len(whole):
            return None
        first = int(whole[0])  # they come in the order they were drawn
        start, walk = int(points[some[rows[first]]]), int(walks[first])
        self._drawn[start].append(walk)
        return start, WALKS_AIMED + 1 + walk

    def _beside_m(self, away: Floats) -> Floats:
        """How far beside what is `away` [k, 2] from its start walks pass [k, W]; infinite if that is behind them."""
        off = away[:, None] - self._begin
        along = (off * self._ways).sum(axis=2)
        beside = np.abs(off[:, :, 0] * self._ways[:, 1] - off[:, :, 1] * self._ways[:, 0])
        return np.where(along > 0.0, beside, np.inf)

    def _has_floor(self, rest: Floats, paths: Floats, place: Floats) -> Bools:
        """Under which of `paths` [c, 2 T + 1, 2] from `rest` [c, 3] there is a floor until they are next to `place`
        [3]: one that is not too steep, no farther than FLOOR_M from the straight line."""
        way = rest[:, None, :2] + paths
        to_go = np.linalg.norm(way - place[:2], axis=2)
        there = to_go.argmin(axis=1)
        share = 1.0 - to_go / np.maximum(to_go[:, :1], 1e-9)
        height = rest[:, None, 2] + share * (place[2] - rest[:, None, 2])
        floor, slope = self._columns.highest(np.dstack([way, height]).reshape(-1, 3), FLOOR_M, FLOOR_M)
        carries = (np.isfinite(floor) & (slope >= self._slope_cos)).reshape(height.shape)
        after = np.arange(paths.shape[1]) > there[:, None]
        return np.asarray((carries | after).all(axis=1), dtype=np.bool_)


def _paths(rule: Walk, repeat: int) -> Floats:
    """Where the walks are from rest at (0, 0) on, twice in each agent step [W, 2 T + 1, 2]."""
    walks = [aimed_walk(number)[WAIT_STEPS:, 0] for number in range(AIMED_WALKS)]
    longest = max(map(len, walks))
    sticks = np.array([[*walk, *[walk[-1]] * (longest - len(walk))] for walk in walks], dtype=np.int64)
    steps = rule.way(sticks, repeat)
    paths = np.empty((len(steps), 2 * longest + 1, 2))
    paths[:, ::2], paths[:, 1::2] = steps, (steps[:, 1:] + steps[:, :-1]) / 2
    return paths


def _lines(paths: Floats) -> tuple[Floats, Floats]:
    """The line that each of `paths` [W, 2 T + 1, 2] comes to keep to: a place on it [W, 2] and its unit vector [W, 2].

    Where two sticks are pushed in turns the way is even only in the mean, over BETWEEN steps.
    """
    steps = paths[:, ::2]
    turning = steps.shape[1] - WALK_STEPS + 1  # the longest step aside, and two steps that still turn
    begin, end = (
        steps[:, first : first + BETWEEN].mean(axis=1)
        for first in (turning, turning + WALK_STEPS - BETWEEN - 1)
    )
    ways = end - begin
    return begin, ways / np.linalg.norm(ways, axis=1, keepdims=True)
