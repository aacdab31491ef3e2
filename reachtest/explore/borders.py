"""Trying every wall: places along the nav-mesh's border, and beside it, to push outwards from.

Who leaves the nav-mesh does so over its border, or from a crate or a ledge next to it. Both are tried in turn, the
least tried first, so that a run can say how much of the border somebody pushed at.

Shape legend: n border places, m new cached points, R rows of the table (border places first), B lanes, T agent steps.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from reachtest.explore.actions import HEADINGS, heading_of
from reachtest.explore.aim import Aim
from reachtest.explore.cache import PositionCache
from reachtest.navmesh.edges import border
from reachtest.navmesh.islands import CLIMB_M
from reachtest.records import Bools, Candidates, Floats, Ints, NavMesh

SPACING_M = 2.0  # between places: who pushes at one comes by both sides of it
PIECE_M = 1.0  # of the border: places are chosen among these, evenly to within one
NEAR_M = 2.0  # a start is no farther than that from its place: it is pushed at, not walked to
PUSHED_M = 1.25  # from a place: half the spacing aside, or up in a jump
OUTERMOST_M = 8.0  # what goes on behind the border that far may be an alley along the world's end
BESIDE_M = 0.7  # off the nav-mesh: erosion at a wall is less, a crate that takes a jump is more
JUMPING_SHARE = 0.5  # of the pushes: gaps are walked through, low walls and crates are jumped onto
OUTER, INNER, BESIDE = range(3)  # kinds of rows
# Whose turn it is, lane after lane: most ways out are at the world's end.
TURNS = (OUTER, BESIDE, OUTER, INNER)
_ALL_WAYS = np.arange(1, HEADINGS + 1)


class Borders:
    """The table of places to push from, each with a heading and with how often that was tried."""

    def __init__(self, navmesh: NavMesh, worth: Bools) -> None:
        """`worth` [F] are the faces that one should be able to get to."""
        self.places, outwards = border_places(navmesh, worth)
        n = len(self.places)
        self._tree = cKDTree(self.places.reshape(-1, 3))
        self._away = np.full(n, np.inf)  # [n] from the place to its start
        self._heading = heading_of(outwards)  # [R]
        self._kind = np.where(outermost(self.places, self._heading), OUTER, INNER)  # [R]
        self._start: Ints = np.full(n, -1, dtype=np.int64)  # [R] cached point; -1: none near yet
        self._tried: Ints = np.zeros(n, dtype=np.int64)  # [R] lanes that were sent
        self._pushes: Ints = np.zeros(n, dtype=np.int64)  # [R] episodes that pushed at a border place
        self._seen = 0  # cached points that were looked at

    @property
    def pushes(self) -> Ints:
        """Episodes that pushed at each border place [n], directed or not."""
        return self._pushes[: len(self.places)]

    def draw(
        self, rng: np.random.Generator, lanes: int, cache: PositionCache, candidates: Candidates
    ) -> Aim | None:
        """Rows for `lanes` lanes, the kinds in their turns and of each the least tried; None while there is none."""
        self._look_at_new(cache.positions, candidates)
        startable = self._start >= 0
        kinds = [np.flatnonzero(startable & (self._kind == kind)) for kind in (OUTER, INNER, BESIDE)]
        turns = [kind for kind in TURNS if len(kinds[kind])]
        if not turns or not lanes:
            return None
        turn = np.roll(np.resize(turns, lanes + len(turns)), rng.integers(len(turns)))[:lanes]
        rows = np.concatenate(
            [self._least_tried(rng, rows, int((turn == kind).sum())) for kind, rows in enumerate(kinds)]
        )
        np.add.at(self._tried, rows, 1)
        jumping = rng.random(len(rows)) < JUMPING_SHARE
        return Aim(self._start[rows], self._heading[rows] + HEADINGS * jumping, rows)

    def note(self, positions: Floats, sticks: NDArray[np.int8]) -> None:
        """Count who pushed at what, whatever for: `positions` [T, B, 3] after steps with `sticks` [T, B]."""
        t, lane = np.nonzero(np.isfinite(positions[:, :, 0]) & (sticks > 0))
        found = self._tree.query(positions[t, lane], k=[1, 2], distance_upper_bound=PUSHED_M)
        away, place = np.asarray(found[0]), np.asarray(found[1])
        step, column = np.nonzero(np.isfinite(away))
        place, t, lane = place[step, column], t[step], lane[step]
        outwards = (sticks[t, lane] - self._heading[place] + 1) % 8 <= 2  # give or take 45 degrees
        lanes = sticks.shape[1]
        once = np.unique(place[outwards] * lanes + lane[outwards])
        self._pushes += np.bincount(once // lanes, minlength=len(self._pushes))

    def _least_tried(self, rng: np.random.Generator, rows: Ints, lanes: int) -> Ints:
        """The [lanes] of `rows` that were tried least; over again where they are fewer.

        Of those tried as often the ones come first that nobody pushed at by chance.
        """
        if not lanes:
            return rows[:0]
        by_chance = 1.0 - 1.0 / (1.0 + self._pushes[rows])
        tries = self._tried[rows] + by_chance + 1e-6 * rng.random(len(rows))
        least = np.argpartition(tries, min(lanes, len(rows)) - 1)[:lanes]
        return np.resize(rows[least[np.argsort(tries[least])]], lanes)

    def _look_at_new(self, positions: Floats, candidates: Candidates) -> None:
        """Take in cached points that are new: nearer starts, and more rows for those beside the nav-mesh."""
        new = self._seen + np.flatnonzero(candidates.grounded[self._seen :])
        self._seen = len(positions)
        self._bring_nearer(positions[new], new)
        off = candidates.off_mesh_m[new]
        beside = new[(off > BESIDE_M) & np.isfinite(off)]
        count = len(beside) * len(_ALL_WAYS)
        self._start = np.append(self._start, np.repeat(beside, len(_ALL_WAYS)))
        self._heading = np.append(self._heading, np.tile(_ALL_WAYS, len(beside)))
        self._kind = np.append(self._kind, np.full(count, BESIDE))
        self._tried = np.append(self._tried, np.zeros(count, dtype=np.int64))
        self._pushes = np.append(self._pushes, np.zeros(count, dtype=np.int64))

    def _bring_nearer(self, positions: Floats, who: Ints) -> None:
        """Let places start from cached points `who` [m] at `positions` [m, 3] where those are nearer than before."""
        if not len(who) or not len(self.places):
            return
        pairs = cKDTree(positions).sparse_distance_matrix(self._tree, NEAR_M, output_type="ndarray")
        pairs = pairs[np.lexsort((pairs["i"], pairs["v"], pairs["j"]))]
        pairs = pairs[np.append(True, pairs["j"][1:] != pairs["j"][:-1])[: len(pairs)]]  # the nearest of each
        pairs = pairs[pairs["v"] < self._away[pairs["j"]]]
        self._start[pairs["j"]], self._away[pairs["j"]] = who[pairs["i"]], pairs["v"]


def border_places(navmesh: NavMesh, worth: Bools) -> tuple[Floats, Floats]:
    """Places [n, 3] along the border of the faces that are `worth` [F] it, and the unit vectors [n, 2] outwards."""
    climb = CLIMB_M if navmesh.agent.climb_m is None else navmesh.agent.climb_m
    middles, outwards, face = border(navmesh, PIECE_M, climb)
    middles, outwards = middles[worth[face]], outwards[worth[face]]
    # One of each cell and heading: the two sides of a corner look different ways, and are two places.
    cell = np.rint(middles / SPACING_M).astype(np.int64)
    key = np.column_stack([cell, heading_of(outwards)])
    order = np.argsort(np.linalg.norm(middles / SPACING_M - cell, axis=1), kind="stable")
    _, first = np.unique(key[order], axis=0, return_index=True)
    kept = order[first]
    return middles[kept], outwards[kept]


def outermost(places: Floats, headings: Ints) -> Bools:
    """Which border places [n, 3] look out of the world: farther on that way there is no more border, so no nav-mesh."""
    result = np.zeros(len(places), dtype=np.bool_)
    for heading in np.unique(headings).tolist():
        angle = (heading - 1) * np.pi / 4
        ahead = places[:, :2] @ np.array([np.cos(angle), np.sin(angle)])
        across = places[:, :2] @ np.array([-np.sin(angle), np.cos(angle)])
        _, strip = np.unique(np.rint(across / SPACING_M), return_inverse=True)
        farthest = np.full(strip.max() + 1, -np.inf)
        np.maximum.at(farthest, strip, ahead)
        result |= (headings == heading) & (ahead >= farthest[strip] - OUTERMOST_M)
    return result
