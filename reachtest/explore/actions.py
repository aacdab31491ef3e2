"""Random actions, like a gamepad's: a stick direction held for a while, and the jump button.

Every (round, agent) has a stream of its own, so any episode can be re-simulated alone.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from reachtest.records import Floats, Ints

HOLD_STEPS = 6.0  # mean of the geometric time a direction is held: carries further than fresh noise
HEADINGS = 8  # ways to push; as many again push that way mostly jumping
PUSH_JUMP_SHARE = 0.6  # of the holds of those: over a low wall it takes a jump right before it, and another
LEAPS = 2 * HEADINGS  # headings above this begin with a leap: a run-up, one jump, and a stop
STRAIGHTS = (
    3 * HEADINGS
)  # headings above this begin straight on: along a beam there is no room for anything else
AIMED = 4 * HEADINGS  # headings above this begin with a leap that was worked out: see `aimed`
STRAIGHT_STEPS = 16  # two seconds
LEAP_RUN_STEPS = 7  # at the most: two metres from a standstill at walking speed, and time to spare
RUN_UPS = LEAP_RUN_STEPS + 1
# How a leap that was worked out turns before it takes off: eighths of a turn, and for how many agent steps. A velocity
# follows the stick within some tenths of a second, so that these lead between the stick's own directions too.
TURNS = ((0, 0), (1, 0), (-1, 0), (1, 1), (-1, 1))
STEPS_ASIDE = 1 + 2 * HEADINGS  # and it may begin with a step or two any way: cached points are a metre apart
AIMED_LEAPS = STEPS_ASIDE * len(TURNS) * RUN_UPS * HEADINGS
LEAP_FLIGHT_STEPS = 6  # pushing on in the air, as long as any preset's jump takes
LEAP_STOP_STEPS = 6  # the other side may lie lower, and a pillar is soon run across
LEAP_WAIT_STEPS = 2  # before a leap that was worked out: whichever way one was running, one then stands
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
    straight on first, above AIMED to leap first as `aimed` says. 0 is for no way in particular.
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
    if heading > AIMED:
        return aimed(heading - AIMED - 1)
    if heading > STRAIGHTS:
        return np.tile(np.array([way + 1, 0], dtype=np.int8), (STRAIGHT_STEPS, 1))
    if heading > LEAPS:
        aside, run = rng.choice(LEAP_ASIDE), rng.integers(0, RUN_UPS)
        return _leap((way + int(aside)) % 8, int(run))
    return np.empty((0, 2), dtype=np.int8)


def _leap(way: int, run: int, aside: int = 0, turning: int = 0) -> NDArray[np.int8]:
    """Run `way` (0 to 7) for `run` agent steps, turn `aside` for `turning` more, jump once, and stop where that leads.

    Returns actions [n, 2].
    """
    before = run + turning
    actions = np.zeros((before + 1 + LEAP_FLIGHT_STEPS + LEAP_STOP_STEPS, 2), dtype=np.int8)
    actions[:run, 0] = way + 1
    actions[run : len(actions) - LEAP_STOP_STEPS, 0] = (way + aside) % HEADINGS + 1
    actions[before, 1] = 1
    return actions


def aimed(number: int) -> NDArray[np.int8]:
    """One of the AIMED_LEAPS: stand, perhaps step aside, and leap; actions [n, 2]."""
    shape = (STEPS_ASIDE, len(TURNS), RUN_UPS, HEADINGS)
    step, turn, run, way = (int(part) for part in np.unravel_index(number, shape))
    stand = np.zeros((LEAP_WAIT_STEPS, 2), dtype=np.int8)
    aside = np.zeros((-(-step // HEADINGS), 2), dtype=np.int8)
    aside[:, 0] = (step - 1) % HEADINGS + 1
    return np.concatenate([stand, aside, _leap(way, run, *TURNS[turn])])


def heading_of(away: Floats) -> Ints:
    """The headings [n], 1 to 8, that lead most nearly along `away` [n, 2 or 3]."""
    return np.rint(np.arctan2(away[:, 1], away[:, 0]) / (np.pi / 4)).astype(np.int64) % 8 + 1


def start_generator(seed: int, round_: int) -> np.random.Generator:
    """The generator that draws the starts of a round; apart from every agent's stream."""
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(round_,)))
