"""Beginnings of episodes that were worked out: leaps across a gap, and walks straight to a place.

Each has a number, so that an episode can be simulated again from what the number says alone. All begin by waiting: they
are worked out for who stands by then.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

HEADINGS = 8  # ways to push
LEAP_RUN_STEPS = 7  # at the most: two metres from a standstill at walking speed, and time to spare
RUN_UPS = LEAP_RUN_STEPS + 1
# How a leap turns before it takes off: eighths of a turn, and for how many agent steps. A velocity follows the stick
# within some tenths of a second, so that these lead between the stick's own directions too.
TURNS = ((0, 0), (1, 0), (-1, 0), (1, 1), (-1, 1))
STEPS_ASIDE = 1 + 2 * HEADINGS  # it may begin with a step or two any way: cached points are a metre apart
AIMED_LEAPS = STEPS_ASIDE * len(TURNS) * RUN_UPS * HEADINGS
LEAP_FLIGHT_STEPS = 6  # pushing on in the air, as long as any preset's jump takes
LEAP_STOP_STEPS = 6  # the other side may lie lower, and a pillar is soon run across
WAIT_STEPS = 2  # until one stands
WALK_STEPS = 16  # two seconds, by default
BETWEEN = 8  # ways of a walk for each of the stick's: those between two are kept to by pushing both in turns
AIMED_WALKS = STEPS_ASIDE * BETWEEN * HEADINGS


def aimed_leap(number: int) -> NDArray[np.int8]:
    """One of the AIMED_LEAPS: stand, perhaps step aside, and leap; actions [n, 2]."""
    shape = (STEPS_ASIDE, len(TURNS), RUN_UPS, HEADINGS)
    step, turn, run, way = (int(part) for part in np.unravel_index(number, shape))
    return np.concatenate([_stand_aside(step), leap(way, run, *TURNS[turn])])


def aimed_walk(number: int) -> NDArray[np.int8]:
    """One of the AIMED_WALKS: stand, perhaps step aside, and walk straight on; actions [n, 2]."""
    step, between, way = (int(part) for part in np.unravel_index(number, (STEPS_ASIDE, BETWEEN, HEADINGS)))
    aside = between - BETWEEN // 2
    turned = np.floor(np.arange(WALK_STEPS + 1) * abs(aside) / BETWEEN + 0.5)
    walk = np.zeros((WALK_STEPS, 2), dtype=np.int8)
    walk[:, 0] = (way + np.sign(aside) * np.diff(turned)) % HEADINGS + 1
    return np.concatenate([_stand_aside(step), walk])


def leap(way: int, run: int, aside: int = 0, turning: int = 0) -> NDArray[np.int8]:
    """Run `way` (0 to 7) for `run` agent steps, turn `aside` for `turning` more, jump once, and stop where that leads.

    Returns actions [n, 2].
    """
    before = run + turning
    actions = np.zeros((before + 1 + LEAP_FLIGHT_STEPS + LEAP_STOP_STEPS, 2), dtype=np.int8)
    actions[:run, 0] = way + 1
    actions[run : len(actions) - LEAP_STOP_STEPS, 0] = (way + aside) % HEADINGS + 1
    actions[before, 1] = 1
    return actions


def _stand_aside(step: int) -> NDArray[np.int8]:
    """Wait, and then none, one or two steps one way: one of STEPS_ASIDE; actions [n, 2]."""
    actions = np.zeros((WAIT_STEPS - (-step // HEADINGS), 2), dtype=np.int8)
    actions[WAIT_STEPS:, 0] = (step - 1) % HEADINGS + 1
    return actions
