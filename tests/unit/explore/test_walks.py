"""Walks that are worked out: the lines they keep to, and how many of them get along a beam."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from reachtest.columns import ColumnIndex
from reachtest.explore.actions import STRAIGHTS, WALKS_AIMED, action_stream, heading_of
from reachtest.explore.aimed import AIMED_WALKS, WAIT_STEPS
from reachtest.explore.directed.walks import Walks
from reachtest.levels import PRESETS
from reachtest.records import Character, ExploreSettings, Floats, Level
from reachtest.walking import Walk
from reachtest.world import MujocoSimulator
from tests.levels import FLOOR, UNREAL, box, level

SETTINGS = ExploreSettings()
LANES = 64
BEAM_M = 0.9
STEPS = 18
FLOORS = ColumnIndex(np.array(FLOOR, dtype=float))


@pytest.mark.parametrize("preset", ["unreal", "unity", "godot", "quake3"])
def test_who_walks_is_where_the_walk_says(preset: str) -> None:
    """To 4 cm at every step: the rule they are worked out with is the one that it moves by; also after a run."""
    who: Character = PRESETS[preset]
    simulator = MujocoSimulator(level(FLOOR, character=who), LANES, 2)
    rng = np.random.default_rng(0)
    states = simulator.place(np.tile([0.0, 0.0, 0.02], (LANES, 1)))
    states[:, 3:5] = who.walk_speed_mps * np.tile([[1, 0], [0, -1], [-0.7, 0.7], [0, 0]], (LANES // 4, 1))
    states[:, 6] = 1.0
    numbers = rng.choice(AIMED_WALKS, LANES, replace=False)
    way = walked(simulator, states, [WALKS_AIMED + 1 + int(number) for number in numbers])
    rule = Walk.of(who, 1.0 / SETTINGS.physics_hz)
    rest, still = rule.run_out(states[:, 3:5], WAIT_STEPS * SETTINGS.action_repeat)
    assert still.all()
    sticks = np.stack(
        [action_stream(0, 0, 0, STEPS, WALKS_AIMED + 1 + int(number))[:, 0] for number in numbers]
    )
    planned = rest[:, None] + rule.way(sticks[:, WAIT_STEPS:], SETTINGS.action_repeat)[:, 1:]
    off = np.linalg.norm(way[WAIT_STEPS:, :, :2] - planned.transpose(1, 0, 2), axis=2)
    assert off.max() < 0.04


def test_a_walk_passes_over_its_place_and_none_is_drawn_for_who_would_still_run() -> None:
    walks, rng = Walks(UNREAL, SETTINGS, FLOORS), np.random.default_rng(0)
    away, turn = rng.uniform(5.0, 8.0, LANES), rng.uniform(-np.pi, np.pi, LANES)
    places = np.stack([away * np.cos(turn), away * np.sin(turn), 0.0 * away], axis=1)
    at = np.zeros((1, 3))
    drawn = [walks.draw(rng, place, np.array([lane]), at, at) for lane, place in enumerate(places)]
    headings = [walk[1] for walk in drawn if walk is not None]
    assert len(headings) == LANES
    simulator = MujocoSimulator(level(FLOOR), LANES, 2)
    way = walked(simulator, simulator.place(np.tile([0.0, 0.0, 0.02], (LANES, 1))), headings)
    between = (way[1:] + way[:-1]) / 2
    nearest = np.linalg.norm(np.concatenate([way, between]) - places, axis=2).min(axis=0)
    assert np.quantile(nearest, 0.9) < 0.45
    slippery = replace(UNREAL, braking_mps2=1.0, ground_friction=0.1)
    assert Walks(slippery, SETTINGS, FLOORS).draw(rng, places[0], np.array([0]), at, at + [6.0, 0, 0]) is None


def test_a_walk_needs_a_floor_that_carries() -> None:
    hole = np.concatenate([box([-4, -4, -1], [4, 4, 0]), box([8, -4, -1], [16, 4, 0])])
    steep = np.array(
        [[[4, -4, 0], [8, -4, 24], [8, 4, 24]], [[4, -4, 0], [8, 4, 24], [4, 4, 0]]], dtype=float
    )
    at, rng = np.zeros((1, 3)), np.random.default_rng(0)
    for floors in (hole, np.concatenate([hole, steep])):
        walks = Walks(UNREAL, SETTINGS, ColumnIndex(floors))
        assert walks.draw(rng, np.array([9.0, 0.0, 0.0]), np.array([0]), at, at) is None
        assert walks.draw(rng, np.array([3.5, 0.0, 0.0]), np.array([0]), at, at) is not None


def test_no_walk_is_drawn_twice_and_none_that_leads_elsewhere() -> None:
    walks, rng = Walks(UNREAL, SETTINGS, FLOORS), np.random.default_rng(0)
    at = np.zeros((1, 3))
    drawn = []
    while (walk := walks.draw(rng, np.array([6.0, 1.0, 0.0]), np.array([7]), at, at)) is not None:
        drawn.append(walk)
    assert len(set(drawn)) == len(drawn) > 20
    assert np.iinfo(np.int16).max >= WALKS_AIMED + AIMED_WALKS  # headings are stored so
    assert all(start == 7 and WALKS_AIMED < heading <= WALKS_AIMED + AIMED_WALKS for start, heading in drawn)
    east = [action_stream(0, 0, 0, 32, heading)[4:18, 0] for _, heading in drawn]
    assert all(set(sticks) <= {8, 1, 2, 3} for sticks in east)
    assert (
        walks.draw(rng, np.array([6.0, 1.0, 0.0]), np.empty(0, int), np.empty((0, 3)), np.empty((0, 3)))
        is None
    )


@pytest.mark.parametrize("turn_deg", [0.0, 45.0, 20.0])
def test_most_walks_that_were_worked_out_get_along_a_beam_and_few_straight_ones(turn_deg: float) -> None:
    """A beam of 0.9 m in line with a stick, and one that no stick points along."""
    where = platform_and_beam(turn_deg)
    simulator = MujocoSimulator(where, LANES, 2)
    x, y = np.meshgrid(np.arange(-3.5, 4, 1.0), np.arange(-3.5, 4, 1.0))
    states = simulator.place(np.column_stack([x.ravel(), y.ravel(), np.full(x.size, 0.02)]))
    goal = turned(np.array([[9.0, 0.3, 0.0]]), turn_deg)[0]
    walks, rng = Walks(UNREAL, SETTINGS, ColumnIndex(where.collision)), np.random.default_rng(0)
    drawn = [walks.draw(rng, goal, np.arange(LANES), states[:, :3], states[:, 3:6]) for _ in range(LANES)]
    starts, headings = zip(*(walk for walk in drawn if walk is not None), strict=True)
    assert len(starts) == LANES
    arrived = gets_near(goal, walked(simulator, states[list(starts)], headings))
    straight = [
        STRAIGHTS + int(heading_of(goal[None] - states[lane : lane + 1, :3])[0]) for lane in range(LANES)
    ]
    by_chance = gets_near(goal, walked(simulator, states, straight))
    assert arrived >= 0.7 * LANES  # 56, 49 and 55 of 64
    assert by_chance <= 0.25 * LANES  # 8, 14 and 8


def platform_and_beam(turn_deg: float) -> Level:
    x, half = 3.5, BEAM_M / 2
    beam = np.array(box([x, 0.3 - half, -1], [x + 9, 0.3 + half, 0])).reshape(-1, 3)
    return level(
        box([-4, -4, -1], [4, 4, 0]),
        turned(beam, turn_deg).reshape(-1, 3, 3),
        navmesh=np.empty((0, 3, 3)),
        kill_z_m=-5,
    )


def turned(points: Floats, turn_deg: float) -> Floats:
    c, s = np.cos(np.radians(turn_deg)), np.sin(np.radians(turn_deg))
    return points @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])


def walked(simulator: MujocoSimulator, states: Floats, headings) -> Floats:
    """Where [T, LANES, 3] characters get from `states` [LANES, S]."""
    streams = [action_stream(0, 0, lane, STEPS, heading) for lane, heading in enumerate(headings)]
    simulator.restore(np.arange(LANES), states)
    return np.stack([simulator.step(actions).positions for actions in np.stack(streams, axis=1)])


def gets_near(goal: Floats, way: Floats) -> int:
    return int((np.linalg.norm(way - goal, axis=2) < 1.0).any(axis=0).sum())
