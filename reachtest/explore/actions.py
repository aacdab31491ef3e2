"""Random actions, like a gamepad's: a stick direction held for a while, and the jump button.

Every (round, agent) has a stream of its own, so any episode can be re-simulated alone.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from reachtest.explore.aimed import (
    AIMED_LEAPS,
    HEADINGS,
    RUN_UPS,
    WALK_STEPS,
    aimed_leap,
    aimed_walk,
    leap,
)
from reachtest.records import Floats, Ints

HOLD_STEPS = 6.0  # mean of the geometric time a direction is held: carries further than fresh noise
PUSH_JUMP_SHARE = 0.6  # of the holds of those: over a low wall it takes a jump right before it, and another
LEAPS = 2 * HEADINGS  # headings above this begin with a leap: a run-up, one jump, and a stop
STRAIGHTS = 3 * HEADINGS  # headings above this begin straight on
LEAPS_AIMED = 4 * HEADINGS  # headings above this begin with a leap that was worked out, `aimed_leap`
WALKS_AIMED = (
    LEAPS_AIMED + AIMED_LEAPS
)  # headings above this begin with a walk that was worked out, `aimed_walk`
LEAP_ASIDE = (0, 0, 1, -1)  # eighths of a turn: between two headings there is a third
JUMP_SHARE = 0.25  # of the holds are made jumping
CENTRED_SHARE = 0.05  # of the holds stand still: enough for what only waiting finds
HEADING_SHARE = (
    0.7  # of a directed stream's holds push its way, give or take 45 degrees; the rest gets around corners
)


def action_stream(
    seed: int, round_: int, agent: int, steps: int, heading: int = 0, jump_share: float = JUMP_SHARE
) -> NDArray[np.int8]:
    """The actions [steps, 2] (stick 0 to 8, jump 0 or 1) of one agent in one round.

    With a `heading` most of them push that way: 1 to 8, 9 to 16 to jump more, 17 to 24 to leap first, 25 to 32 to walk
    straight on first, above these to leap or to walk first as was worked out. 0 is for no way in particular.
    """
    jump_share = PUSH_JUMP_SHARE if heading > HEADINGS else jump_share
    rng = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(round_, agent)))
    change = rng.random(steps) < 1.0 / HOLD_STEPS
    change[0] = True
    hold = np.cumsum(change) - 1
    stick = np.where(rng.random(steps) < CENTRED_SHARE, 0, rng.integers(1, 9, steps))
    jump = rng.random(steps) < jump_share
    if heading:
        towards = (heading - 1 + rng.integers(-1, 2, steps)) % 8 + 1
        stick = np.where(rng.random(steps) < HEADING_SHARE, towards, stick)
    actions = np.stack([stick[hold], jump[hold]], axis=1).astype(np.int8)
    first = _first(rng, heading)[:steps]
    actions[: len(first)] = first
    return actions


def _first(rng: np.random.Generator, heading: int) -> NDArray[np.int8]:
    """What an episode with that `heading` begins with: actions [n, 2]."""
    way = (heading - 1) % 8
    if heading > WALKS_AIMED:
        return aimed_walk(heading - WALKS_AIMED - 1)
    if heading > LEAPS_AIMED:
        return aimed_leap(heading - LEAPS_AIMED - 1)
    if heading > STRAIGHTS:
        return np.tile(np.array([way + 1, 0], dtype=np.int8), (WALK_STEPS, 1))
    if heading > LEAPS:
        aside, run = rng.choice(LEAP_ASIDE), rng.integers(0, RUN_UPS)
        return leap((way + int(aside)) % 8, int(run))
    return np.empty((0, 2), dtype=np.int8)


def heading_of(away: Floats) -> Ints:
    """The headings [n], 1 to 8, that lead most nearly along `away` [n, 2 or 3]."""
    return np.rint(np.arctan2(away[:, 1], away[:, 0]) / (np.pi / 4)).astype(np.int64) % 8 + 1


def start_generator(seed: int, round_: int) -> np.random.Generator:
    """The generator that draws the starts of a round; apart from every agent's stream."""
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(round_,)))
