"""Acting on purpose: which open goals the directed lanes of a round push towards, and from where.

Shape legend: G goals, n goals considered, k cached points near each, B directed lanes, P cached points.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from reachtest.explore.actions import STRAIGHTS, heading_of
from reachtest.explore.cache import PositionCache
from reachtest.explore.directed.parts import Efforts
from reachtest.explore.directed.starts import BY_STOREY, STRAIGHT, Starts
from reachtest.explore.directed.turns import in_turns
from reachtest.explore.directed.walks import Walks
from reachtest.explore.goals import GoalSet
from reachtest.explore.heuristics import NEAREST_M
from reachtest.records import Bools, Candidates, Floats, Ints

BORDER_M = 8.0  # an attempt from farther off says little: two goals' spacing
SPARE_M = 4.0  # starts up to so much farther than the nearest are drawn too: from it all may go wrong
NEARER_M = 1.0  # a border that came this much nearer makes attempts from the old one worthless
CONSIDERED = 1024  # open goals a round looks at: plenty for its lanes, and cheap in a city
STRAIGHT_SHARE = 0.25  # of the attempts at goals: the others find the way around corners, and fall off beams


@dataclass(frozen=True)
class Aim:
    """What directed lanes of a round do."""

    starts: Ints  # [B] cached points
    headings: Ints  # [B] see `action_stream`
    targets: Ints  # [B] what each is counted for: a goal, or a place to push from


class Aims:
    """Chooses goals so that all parts of the nav-mesh that are still open get their share, and counts."""

    def __init__(self, goals: GoalSet, worth: Bools, spacing_m: float, walks: Walks) -> None:
        """`worth` [G] are the goals that one should be able to get to."""
        self._goals, self._promised, self._walks = goals, worth, walks
        self._starts = Starts()
        self._gap_m: Floats = np.full(
            len(goals.goals), np.inf
        )  # [G] how far the nearest of them was, by storey
        self._worth = worth
        self._efforts = Efforts(goals.goals, 2 * spacing_m)
        self.border_m: Floats = np.full(len(goals.goals), np.inf)  # [G] how far that start was

    def wanting(self, effort: int) -> bool:
        """Whether a goal is open that one should be able to get to, and fewer than `effort` attempts were in vain."""
        open_ = (self._goals.reached_step < 0) & self._promised
        return bool((open_ & (self.attempts_at_parts() < effort)).any())

    def attempts(self) -> Ints:
        """Attempts [G] in vain so far, each counted at the goal it pushed to."""
        self._forget()
        return self._efforts.attempts

    def attempts_at_parts(self) -> Ints:
        """Attempts [G] in vain so far at the whole open part that a goal lies in."""
        self._forget()
        return self._efforts.of_parts()

    def add(self, goals: Bools) -> None:
        """Try to get to `goals` [G] as well."""
        self._worth = self._promised | goals

    def draw(
        self, rng: np.random.Generator, lanes: int, cache: PositionCache, candidates: Candidates
    ) -> Aim | None:
        """Goals for `lanes` lanes, the least tried first; None when no goal is open."""
        self._forget()
        self._starts.note(cache.positions, candidates.above_m)
        open_ = np.flatnonzero((self._goals.reached_step < 0) & self._worth)
        if not len(open_) or not lanes or not len(self._starts):
            return None
        if len(open_) > CONSIDERED:
            open_ = np.sort(rng.choice(open_, CONSIDERED, replace=False))
        away, who = self._starts.nearest(self._goals.goals[open_])
        self._note_border(open_, away[BY_STOREY, :, 0], cache.positions[who[BY_STOREY, :, 0]])
        chosen = self._rotate(rng, lanes, open_)
        goals = open_[chosen]
        # Where a way is promised, one comes along it; every other time from straight below or above, if that is nearer.
        way = np.where(self._promised[goals], rng.integers(0, 2, lanes), STRAIGHT)
        away, who = away[way, chosen], who[way, chosen]
        near = away <= np.maximum(away[:, :1] + SPARE_M, BORDER_M)
        starts = _one_each(rng, np.where(near, away, np.inf), who, candidates.visits)
        np.add.at(self._efforts.attempts, goals, 1)
        headings = heading_of(self._goals.goals[goals] - cache.positions[starts])
        for lane in np.flatnonzero(rng.random(lanes) < STRAIGHT_SHARE).tolist():
            stand = who[lane, near[lane]]
            stand = stand[candidates.grounded[stand]]
            goal, velocities = self._goals.goals[goals[lane]], candidates.velocities[stand]
            walk = self._walks.draw(rng, goal, stand, cache.positions[stand], velocities)
            starts[lane], headings[lane] = walk or (starts[lane], headings[lane] + STRAIGHTS)
        return Aim(starts, headings, goals)

    def _forget(self) -> None:
        reached = self._goals.reached_step >= 0
        self._efforts.forget(~reached & self._worth, reached)

    def _note_border(self, goals: Ints, away: Floats, starts: Floats) -> None:
        """Attempts count when they began near the goal, or from about the nearest place that was ever reached.

        `away` [n] is how far the nearest of them, `starts` [n, 3], are from `goals` [n] by storey.
        """
        before = self._gap_m[goals]
        self._efforts.attempts[goals[(away < before - NEARER_M) & (before > BORDER_M)]] = 0
        nearer = away < before
        self._gap_m[goals[nearer]] = away[nearer]
        self.border_m[goals[nearer]] = np.linalg.norm(starts - self._goals.goals[goals], axis=1)[nearer]

    def _rotate(self, rng: np.random.Generator, lanes: int, goals: Ints) -> Ints:
        """Places [lanes] in `goals`: always the part that was tried least, and of it the border goal tried least."""
        part = self._efforts.parts_among(goals)
        attempts = self._efforts.attempts[goals]
        nearest = np.full(part.max() + 1, np.inf)
        np.minimum.at(nearest, part, self._gap_m[goals])
        at_border = self._gap_m[goals] <= np.maximum(nearest[part], BORDER_M)
        tries = np.where(at_border, attempts + rng.random(len(goals)), np.inf)
        total = np.bincount(part, weights=attempts) + rng.random(len(nearest))
        return in_turns(tries, part, total, lanes)


def _one_each(rng: np.random.Generator, away: Floats, who: Ints, visits: Ints) -> Ints:
    """One of the cached points `who` [B, k], `away` [B, k] from its goal, for each lane: near, and seldom visited [P],
    as the frontier is; none that is infinitely far."""
    weight = 1.0 / (np.maximum(visits[who], 1) * np.maximum(away, NEAREST_M) ** 2)
    total = np.cumsum(weight, axis=1)
    draws = rng.random((len(who), 1)) * total[:, -1:]
    place = np.minimum((total <= draws).sum(axis=1), who.shape[1] - 1)
    return who[np.arange(len(who)), place]
