"""Leaps that are worked out: where they take off, and how many of them arrive."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from reachtest.explore.actions import LEAPS, LEAPS_AIMED, action_stream
from reachtest.explore.aimed import AIMED_LEAPS, aimed_leap
from reachtest.explore.directed.gaps import Gaps, places_to_push
from reachtest.explore.directed.leap_table import LeapTable
from reachtest.explore.directed.leaps import Leaps
from reachtest.levels import PRESETS
from reachtest.navmesh.islands import Islands
from reachtest.records import Bools, Character, ExploreSettings, Level
from reachtest.world import MujocoSimulator
from tests.levels import FLOOR, UNREAL, box, level

SETTINGS = ExploreSettings()
LANES = 64
HERE = (-4.0, -4.0, 4.0, 4.0)
STEPS = 24  # until every leap has landed


def top(block: Sequence[float], z: float) -> list[list[list[float]]]:
    """The nav-mesh on a block: it keeps a radius from the edges."""
    x0, y0, x1, y1 = np.array(block) + UNREAL.radius_m * np.array([1, 1, -1, -1])
    a, b, c, d = ([x, y, z] for x, y in ((x0, y0), (x1, y0), (x1, y1), (x0, y1)))
    return [[a, b, c], [a, c, d]]


def two_blocks(gap_m: float, rise_m: float = 0.0, aside_m: float = 0.0) -> Level:
    x = HERE[2] + gap_m
    there = (x, aside_m - 2, x + 4, aside_m + 2)
    blocks = [box([*b[:2], -6], [*b[2:], z]) for b, z in ((HERE, 0.0), (there, rise_m))]
    return level(*blocks, navmesh=np.array(top(HERE, 0.0) + top(there, rise_m)), kill_z_m=-5)


def gaps_of(where: Level) -> Gaps:
    islands = Islands(where.navmesh)
    return places_to_push(islands, np.arange(islands.count) == 0, where.character)[1]


def standing(where: Level) -> tuple[MujocoSimulator, np.ndarray]:
    """A simulator, and states of characters on the first block, a metre apart: three of four run some way."""
    simulator = MujocoSimulator(where, LANES, 2)
    x, y = np.meshgrid(np.arange(-3.5, 4, 1.0), np.arange(-3.5, 4, 1.0))
    states = simulator.place(np.column_stack([x.ravel(), y.ravel(), np.full(x.size, 0.02)]))
    states[:, 3:5] = UNREAL.walk_speed_mps * np.tile([[1, 0], [0, -1], [-0.7, 0.7], [0, 0]], (x.size // 4, 1))
    states[:, 6] = 1.0
    return simulator, states


def arrive(simulator: MujocoSimulator, starts: np.ndarray, headings: Sequence[int]) -> Bools:
    """Which of the leaps `headings` [LANES] from states `starts` [LANES, S] end on the other block."""
    streams = [action_stream(0, 0, lane, STEPS, heading) for lane, heading in enumerate(headings)]
    simulator.restore(np.arange(LANES), starts)
    across = np.zeros(LANES, dtype=np.bool_)
    for actions in np.stack(streams, axis=1):
        result = simulator.step(actions)
        across |= result.grounded & (
            result.positions[:, 0] > HERE[2] + 1
        )  # below there is nothing to stand on
    return across


def worked_out(where: Level, count: int) -> list[tuple[int, int]]:
    gaps = gaps_of(where)
    leaps = Leaps(gaps, where.character, SETTINGS)
    _, states = standing(where)
    everyone = np.arange(len(states))
    leaps.note(states[:, :3], states[:, 3:6], everyone, 0 * everyone)
    rng = np.random.default_rng(0)
    here = np.flatnonzero(gaps.places.island == 0)
    drawn = [leaps.draw(rng, int(here[number % len(here)])) for number in range(count)]
    return [leap for leap in drawn if leap is not None]


@pytest.mark.parametrize(
    ("gap_m", "rise_m", "aside_m"),
    [(3.0, 0.0, 0.0), (4.2, 0.0, 0.0), (3.0, 0.0, 5.0), (2.0, 0.6, 1.0), (4.5, -2.0, 2.0), (7.0, -4.0, 0.0)],
)
def test_most_leaps_that_were_worked_out_arrive_and_few_by_chance(
    gap_m: float, rise_m: float, aside_m: float
) -> None:
    where = two_blocks(gap_m, rise_m, aside_m)
    simulator, states = standing(where)
    leaps = worked_out(where, LANES)
    starts, headings = zip(*leaps, strict=True)
    assert len(leaps) == LANES
    hits = arrive(simulator, states[list(starts)], headings).sum()
    by_chance = arrive(simulator, states[list(starts)], [LEAPS + 1] * LANES).sum()
    assert hits >= 0.75 * LANES  # 56 to 61 of 64
    assert by_chance <= 0.25 * LANES  # 2 to 12


def test_no_leap_is_drawn_twice() -> None:
    leaps = worked_out(two_blocks(3.0), 400)
    assert len(set(leaps)) == len(leaps) == 400


def test_too_far_is_not_tried() -> None:
    assert not len(gaps_of(two_blocks(7.0)).outwards)
    assert not len(gaps_of(two_blocks(3.0, aside_m=30.0)).outwards)


@pytest.mark.parametrize("preset", ["unreal", "unity", "quake3"])
def test_leaps_take_off_where_the_character_does(preset: str) -> None:
    """To 3 cm and 0.1 m/s: the rule they are worked out with is the one that it moves by."""
    who: Character = PRESETS[preset]
    where = level(FLOOR, character=who)
    simulator = MujocoSimulator(where, LANES, 2)
    leaps = LeapTable(who, SETTINGS).take_offs
    numbers = np.random.default_rng(0).choice(AIMED_LEAPS, LANES, replace=False)
    start = simulator.place(np.array([[0.0, 0.0, 0.02]]))
    simulator.restore(np.arange(LANES), np.repeat(start, LANES, axis=0))
    streams = [action_stream(0, 0, 0, 32, LEAPS_AIMED + 1 + int(number)) for number in numbers]
    take_off = np.array([aimed_leap(int(number))[:, 1].argmax() for number in numbers])
    for step, actions in enumerate(np.stack(streams, axis=1)):
        now = take_off == step
        before = simulator.save()[now]
        simulator.step(actions)
        np.testing.assert_allclose(before[:, :2], leaps.places[numbers[now]], atol=0.03)
        if who.air_control == 0:
            np.testing.assert_allclose(simulator.save()[now, 3:5], leaps.velocities[numbers[now]], atol=0.1)
