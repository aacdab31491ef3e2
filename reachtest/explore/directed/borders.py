"""Trying every wall and every gap: places along the nav-mesh's border, and beside it, to push outwards from.

Who leaves the nav-mesh does so over its border, or from a crate or a ledge next to it; and islands that no way leads
to may be a jump apart. All are tried in turn, the least tried first, so that a run can say how much of the border
somebody pushed at.

Shape legend: n border places, m new cached points, I islands, B lanes, T agent steps,
R rows of the table: border places, then gaps, then what lies beside.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from reachtest.explore.actions import LEAPS
from reachtest.explore.aimed import HEADINGS
from reachtest.explore.cache import PositionCache
from reachtest.explore.directed.aim import Aim
from reachtest.explore.directed.footholds import Footholds
from reachtest.explore.directed.gaps import Gaps
from reachtest.explore.directed.leaps import Leaps
from reachtest.explore.directed.places import NOWHERE, Places, outermost
from reachtest.explore.directed.pushes import Pushes
from reachtest.explore.directed.turns import in_turns, least_tried
from reachtest.records import Bools, Candidates, Character, ExploreSettings, Floats, Ints

NEAR_M = 2.0  # a start is no farther than that from its place: it is pushed at, not walked to
BESIDE_M = 0.7  # off the nav-mesh: erosion at a wall is less, a crate that takes a jump is more
JUMPING_SHARE = 0.5  # of the pushes: gaps are walked through, low walls and crates are jumped onto
AIMED_SHARE = 0.75  # of the leaps over gaps
OUTER, INNER, BESIDE, GAP, FLOOR = KINDS = range(5)  # of rows; a FLOOR is a gap to what the nav-mesh lacks
# Whose turn it is, lane after lane: most ways out are at the world's end.
TURNS = (OUTER, GAP, BESIDE, OUTER, GAP, INNER, FLOOR)
_ALL_WAYS = np.arange(1, HEADINGS + 1)


class Borders:
    """The table of places to push from, each with a heading and with how often that was tried."""

    def __init__(
        self, along: Places, gaps: Gaps, footholds: Footholds, who: Character, settings: ExploreSettings
    ) -> None:
        """Places `along` the border, and at `gaps` that are of interest until somebody stands on the other side."""
        self._along, self._footholds, self._leaps = along, footholds, Leaps(gaps, who, settings)
        before, n = gaps.places, len(along.positions)
        rows = n + len(before.positions)
        self._tree = cKDTree(along.positions.reshape(-1, 3))
        self._away = np.full(n, np.inf)  # from the place to its start
        self._heading = np.concatenate([along.headings, before.headings])  # [R]
        self._target = np.concatenate([along.target, before.target])  # [R]
        outer = np.where(outermost(along.positions, along.headings), OUTER, INNER)
        leaps = np.where(before.target < gaps.own, GAP, FLOOR)
        self._kind = np.concatenate([outer, leaps])  # [R]
        self._start: Ints = np.full(rows, -1, dtype=np.int64)  # [R] cached point; -1: none near, or a gap
        self._tried: Ints = np.zeros(rows, dtype=np.int64)  # [R] lanes that were sent
        self._pushes = Pushes(along)
        self._seen = 0  # cached points that were looked at

    def effort(self) -> tuple[Floats, Ints]:
        """Border places [n, 3] of islands that somebody can be on or was on, and the episodes that pushed there [n],
        directed or not."""
        kept = self._footholds.stood[self._along.island]
        return self._along.positions[kept], self._pushes.counts[kept]

    def draw(
        self, rng: np.random.Generator, lanes: int, cache: PositionCache, candidates: Candidates
    ) -> Aim | None:
        """Rows for `lanes` lanes, the kinds in their turns and of each the least tried; None while there is none."""
        self._look_at_new(cache.positions, candidates)
        crossed = (self._target != NOWHERE) & self._footholds.stood[self._target]
        startable = self._start >= 0
        startable[self._is_gap] = self._leaps.has_start
        startable &= ~crossed
        kinds = [np.flatnonzero(startable & (self._kind == kind)) for kind in KINDS]
        turns = [kind for kind in TURNS if len(kinds[kind])]
        if not turns or not lanes:
            return None
        turn = np.roll(np.resize(turns, lanes + len(turns)), rng.integers(len(turns)))[:lanes]
        rows = np.concatenate(
            [self._next(rng, rows, kind, int((turn == kind).sum())) for kind, rows in enumerate(kinds)]
        )
        np.add.at(self._tried, rows, 1)
        how = np.where(rng.random(len(rows)) < JUMPING_SHARE, HEADINGS, 0)
        how[self._is_gap[rows]] = LEAPS
        starts, headings = self._start[rows], self._heading[rows] + how
        self._leap(rng, rows, starts, headings)
        return Aim(starts, headings, rows)

    def _leap(self, rng: np.random.Generator, rows: Ints, starts: Ints, headings: Ints) -> None:
        """Over the gaps among `rows` [B], in place. Most of the leaps are aimed; the others find what flights over
        nothing do not."""
        aimed = rng.random(len(rows)) < AIMED_SHARE
        for lane in np.flatnonzero(self._is_gap[rows]).tolist():
            gap = int(rows[lane]) - len(self._along.positions)
            leap = self._leaps.draw(rng, gap) if aimed[lane] else None
            starts[lane], headings[lane] = leap or (self._leaps.any_start(rng, gap), headings[lane])

    def note(self, positions: Floats, sticks: NDArray[np.int8]) -> None:
        """Count who pushed at what, whatever for: `positions` [T, B, 3] after steps with `sticks` [T, B]."""
        self._pushes.note(positions, sticks)

    def _next(self, rng: np.random.Generator, rows: Ints, kind: int, lanes: int) -> Ints:
        """The [lanes] of `rows`, all of a `kind`, whose turn it is.

        Of those tried as often the ones come first that nobody pushed at by chance.
        """
        if not lanes:
            return rows[:0]
        pushes = np.append(self._pushes.counts, 0)[np.minimum(rows, len(self._pushes.counts))]
        tries, chance = self._tried[rows], 1e-6 * rng.random(len(rows))
        rank = tries + (1.0 - 1.0 / (1.0 + pushes)) + chance
        if kind in (GAP, FLOOR):
            _, target = np.unique(self._target[rows], return_inverse=True)
            return rows[in_turns(rank, target, np.bincount(target, weights=tries), lanes)]
        return rows[least_tried(rank, lanes)]

    def _look_at_new(self, positions: Floats, candidates: Candidates) -> None:
        """Take in cached points that are new: nearer starts, and more rows for those beside the nav-mesh."""
        new = self._seen + np.flatnonzero(candidates.grounded[self._seen :])
        self._seen = len(positions)
        self._footholds.note(positions, candidates.grounded)
        self._bring_nearer(positions[new], new)
        self._leaps.note(positions[new], candidates.velocities[new], new, self._footholds.island[new])
        off = candidates.off_mesh_m[new]
        beside = new[(off > BESIDE_M) & np.isfinite(off)]
        count = len(beside) * len(_ALL_WAYS)
        self._start = np.append(self._start, np.repeat(beside, len(_ALL_WAYS)))
        self._heading = np.append(self._heading, np.tile(_ALL_WAYS, len(beside)))
        self._kind = np.append(self._kind, np.full(count, BESIDE))
        self._target = np.append(self._target, np.full(count, NOWHERE))
        self._tried = np.append(self._tried, np.zeros(count, dtype=np.int64))

    @property
    def _is_gap(self) -> Bools:
        return self._kind >= GAP

    def _bring_nearer(self, positions: Floats, who: Ints) -> None:
        """Let places start from cached points `who` [m] at `positions` [m, 3] where those are nearer than before."""
        if not len(who) or not self._tree.n:
            return
        pairs = cKDTree(positions).sparse_distance_matrix(self._tree, NEAR_M, output_type="ndarray")
        pairs = pairs[np.lexsort((pairs["i"], pairs["v"], pairs["j"]))]
        pairs = pairs[np.append(True, pairs["j"][1:] != pairs["j"][:-1])[: len(pairs)]]  # the nearest of each
        pairs = pairs[pairs["v"] < self._away[pairs["j"]]]
        self._start[pairs["j"]], self._away[pairs["j"]] = who[pairs["i"]], pairs["v"]
