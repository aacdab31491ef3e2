"""The edges of walls and gaps: who jumps at one, falls onto two, or rests between them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from reachtest.levels import PRESETS
from reachtest.records import Character, ExploreSettings, Floats, Level
from reachtest.world import MujocoSimulator
from tests.levels import EAST, FLOOR, NORTH_EAST, box, level, slope


def rummage(simulator: MujocoSimulator, begin: np.ndarray, steps: int, eastwards: float) -> np.ndarray:
    """Where [N, 3] somebody stood who ran about from `begin` [n, 3] with jumps."""
    n, rng, stood = len(begin), np.random.default_rng(0), []
    simulator.restore(np.arange(n), simulator.place(begin))
    for _ in range(steps):
        stick = np.where(rng.random(n) < eastwards, EAST, rng.integers(0, 9, n))
        result = simulator.step(np.stack([stick, rng.random(n) < 0.25], axis=1).astype(np.int8))
        stood.append(result.stood)
    places = np.concatenate(stood)
    return places[np.isfinite(places[:, 0])]


@pytest.mark.parametrize("who", PRESETS)
@pytest.mark.parametrize("higher", [-0.04, 0.02, 0.04])
def test_a_wall_is_climbed_as_high_as_the_round_end_gets(who: str, higher: float) -> None:
    """At a run a capsule is 10 cm in the wall's edge before it is stopped, and seemed to stand on it."""
    c, n = PRESETS[who], 128
    apex = c.jump_speed_mps**2 / (2 * c.gravity_mps2)
    top = apex + c.radius_m * (1 - np.cos(np.radians(c.slope_limit_deg))) + higher
    rng = np.random.default_rng(1)
    begin = np.column_stack([rng.uniform(-6, -1, n), rng.uniform(-30, 30, n), np.full(n, 0.02)])
    simulator = MujocoSimulator(level(FLOOR, box([0, -55, 0], [3, 55, top]), character=c), n)
    on_it = rummage(simulator, begin, 60, 0.8)[:, 2] > top - 0.2
    assert on_it.any() if higher < 0 else not on_it.any()


def bars(c: Character, gap: float) -> Level:
    """A grate over nothing."""
    pitch = gap + 0.2
    pieces = [box([k * pitch, -60, -0.2], [k * pitch + 0.2, 60, 0]) for k in range(-60, 60)]
    return level(*pieces, character=c, kill_z_m=-60)


@pytest.mark.parametrize("who", PRESETS)
@pytest.mark.parametrize("wider", [-0.1, -0.05, 0.05])
def test_nobody_falls_through_a_grate_that_is_too_narrow(who: str, wider: float) -> None:
    """Where the edges of a gap push up as well as together they gave way to a fall."""
    c, n, rng = PRESETS[who], 128, np.random.default_rng(1)
    simulator = MujocoSimulator(bars(c, 2 * c.radius_m + wider), n)
    begin = np.column_stack([rng.uniform(-4, 4, n), rng.uniform(-20, 20, n), np.full(n, 0.1)])
    rummage(simulator, begin, 40, 0.0)
    fell = simulator.save()[:, 2] < -c.height_m
    assert fell.mean() > 0.5 if wider > 0 else not fell.any()


@pytest.mark.parametrize("who", PRESETS)
def test_who_rests_in_a_gap_stands_and_can_jump_out(who: str) -> None:
    c, n = PRESETS[who], 16
    gap = 2 * c.radius_m - 0.08
    sides = box([-30, -60, -3], [0, 60, 0]), box([gap, -60, -3], [30, 60, 0])
    simulator = MujocoSimulator(level(*sides, character=c, kill_z_m=-60), n)
    begin = np.column_stack([np.full(n, gap / 2), np.arange(n), np.full(n, 0.3)])
    simulator.restore(np.arange(n), simulator.place(begin))
    for _ in range(10):
        result = simulator.step(np.zeros((n, 2), dtype=np.int8))
    assert result.grounded.all()
    assert (result.positions[:, 2] < -0.05).all()
    rummage(simulator, result.positions, 40, 0.6)
    out = np.abs(simulator.save()[:, 0]) > c.radius_m + gap
    assert out.mean() > 0.5


def test_nobody_hovers_beside_a_wall() -> None:
    """Who slid along a wall, some millimetres in it, was held up by an edge beside it for half a second."""
    c, n = PRESETS["godot"], 256
    apex = c.jump_speed_mps**2 / (2 * c.gravity_mps2)
    blocks = [box([k * 2.0, -0.6, 0], [k * 2.0 + 1, 0, apex - 0.1 - 0.1 * (k % 3)]) for k in range(-12, 12)]
    explore = ExploreSettings(action_repeat=1)
    where = level(FLOOR, *blocks, box([-40, 0, 0], [40, 1, 8]), character=c, explore=explore)
    simulator, rng = MujocoSimulator(where, n), np.random.default_rng(1)
    begin = np.column_stack([rng.uniform(-20, 20, n), rng.uniform(-3, -1, n), np.full(n, 0.02)])
    simulator.restore(np.arange(n), simulator.place(begin))
    held = longest = np.zeros(n)
    before = simulator.save()
    for tick in range(200):
        if tick % 4 == 0:
            stick = np.where(rng.random(n) < 0.5, NORTH_EAST, rng.integers(0, 9, n))
            actions = np.stack([stick, rng.random(n) < 0.3], axis=1).astype(np.int8)
        simulator.step(actions)
        after = simulator.save()
        speed = np.linalg.norm(after[:, 3:6], axis=1)
        moved = np.linalg.norm(after[:, :3] - before[:, :3], axis=1) * where.explore.physics_hz
        hovers = (after[:, 6] == 0) & (before[:, 6] == 0) & (speed > 1.5) & (moved < speed / 5)
        held = np.where(hovers, held + 1, 0)
        longest, before = np.maximum(longest, held), after
    assert longest.max() <= 2


def test_who_lands_in_a_rising_gully_slides_down_it() -> None:
    """Two sides too steep to stand on carry only in a level groove."""
    n, rise = 16, np.tan(np.radians(20))
    a, b = [0, -30, 0], [0, 30, 60 * rise]
    sides = [[[x, y, z + 20] for x, (_, y, z) in ((x, a), (x, b))] for x in (-11.5, 11.5)]
    gully = np.array([[a, b, sides[0][1]], [a, sides[0][1], sides[0][0]], [a, sides[1][1], b]], dtype=float)
    gully = np.concatenate([gully, np.array([[a, sides[1][0], sides[1][1]]], dtype=float)])
    simulator = MujocoSimulator(level(gully, kill_z_m=-60), n)
    y = np.linspace(0, 20, n)
    begin = np.column_stack([np.zeros(n), y, (y + 30) * rise + 0.7])
    simulator.restore(np.arange(n), simulator.place(begin))
    for _ in range(40):
        simulator.step(np.zeros((n, 2), dtype=np.int8))
    assert (simulator.save()[:, 1] < y - 5).all()


def beside_a_wall(gap: float, height: float, yaw: float = 0.3, finer: int = 1) -> tuple[Level, Floats]:
    """A wall, and a low box as far from it as `gap`: a slot that is too narrow for the capsule, at any angle."""
    c, s = np.cos(yaw), np.sin(yaw)
    turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    pieces = [
        box([-5, -5, -1], [5, 5, 0]),
        box([-1, 0, 0], [1, 1, 1.0]),
        box([-1, -gap - 1, 0], [1, -gap, height]),
    ]
    explore = ExploreSettings(physics_hz=30 * finer, action_repeat=4 * finer)
    return level(*[piece @ turn.T for piece in pieces], spawn=(-3, -3, 0.02), explore=explore), turn


@pytest.mark.parametrize("deep", [0.09, 0.12])
@pytest.mark.parametrize(("gap", "height", "z"), [(0.60, 0.2, 0.1), (0.60, 0.3, 0.2), (0.64, 0.2, 0.1)])
def test_who_got_deep_into_a_wall_over_a_slot_is_not_held_there(
    gap: float, height: float, z: float, deep: float
) -> None:
    """What pushes it out leads into the slot, where it does not fit: it was put back, tick after tick, for good."""
    where, turn = beside_a_wall(gap, height)
    simulator = MujocoSimulator(where, 1)
    feet = np.array([[0.2, deep - where.character.radius_m, z]]) @ turn.T
    simulator.restore(np.array([0]), simulator.place(feet))
    for _ in range(15):
        simulator.step(np.zeros((1, 2), dtype=np.int8))
    assert simulator._batch.deepest()[0] > -0.02


@pytest.mark.parametrize(("yaw", "finer"), [(0.0, 1), (0.3, 1), (0.7, 1), (0.3, 2)])
@pytest.mark.parametrize(("gap", "height"), [(0.60, 0.45), (0.62, 0.45), (0.64, 0.3), (0.655, 0.45)])
def test_who_is_jammed_between_a_wall_and_a_crate_may_jump_out(
    gap: float, height: float, yaw: float, finer: int
) -> None:
    """Held off the floor by the crate's edge on one side and the wall on the other: nothing moves, one has landed."""
    where, turn = beside_a_wall(gap, height, yaw, finer)
    simulator = MujocoSimulator(where, 16)
    feet = np.column_stack([np.linspace(-0.5, 0.5, 16), np.full(16, -0.3), np.full(16, 0.6)]) @ turn.T
    simulator.restore(np.arange(16), simulator.place(feet))
    for _ in range(10):
        simulator.step(np.zeros((16, 2), dtype=np.int8))
    rests = simulator.save()[:, 2]
    assert ((rests > 0.04) & (rests < height)).all(), "off the floor, and in the slot"
    highest = rests
    for _ in range(8):
        simulator.step(np.tile(np.array([0, 1], dtype=np.int8), (16, 1)))
        highest = np.maximum(highest, simulator.save()[:, 2])
    assert (highest > rests + 0.8).all()


@pytest.mark.parametrize("width", [0.69, 0.70, 0.72])
@pytest.mark.parametrize("ledge", [0.02, 0.05])
def test_nobody_climbs_a_slot_by_the_ledges_in_it(width: float, ledge: float) -> None:
    """A jump and a jam, again and again: from outside nobody gets in between ledges where the capsule jams."""
    n, rng = 64, np.random.default_rng(0)
    pieces = [
        box([-6, -6, -1], [6, 6, 0]),
        box([-3, 0, 0], [3, 1, 12]),
        box([-3, -width - 1, 0], [3, -width, 12]),
    ]
    pieces += [box([-3, -width - 0.5, z], [3, ledge - width, z + 0.05]) for z in np.arange(0.4, 9, 0.5)]
    simulator = MujocoSimulator(level(*pieces, spawn=(-4, -width / 2, 0.02)), n)
    feet = np.column_stack([rng.uniform(-5, -3.5, n), np.full(n, -width / 2), np.full(n, 0.02)])
    simulator.restore(np.arange(n), simulator.place(feet))
    highest = np.zeros(n)
    for _ in range(300):
        stick = np.where(rng.random(n) < 0.5, EAST, rng.integers(0, 9, n))
        simulator.step(np.stack([stick, rng.random(n) < 0.7], axis=1).astype(np.int8))
        at = simulator.save()
        highest = np.maximum(highest, np.where(np.abs(at[:, 0]) < 3, at[:, 2], 0.0))
    assert highest.max() < 0.95


def funnel(degrees: list[float]) -> Level:
    """An inverted pyramid: a side at each slope."""
    up, planes = 4.0, []
    ways = np.radians(np.arange(len(degrees)) * 360 / len(degrees) + 17)
    for way, steep in zip(ways, np.radians(degrees), strict=True):
        out, along = np.array([np.cos(way), np.sin(way), 0]), np.array([-np.sin(way), np.cos(way), 0])
        top = out * up / np.tan(steep) + [0, 0, up]
        planes.append([np.zeros(3), top - along * 12, top + along * 12])
    return level(np.array(planes), kill_z_m=-60)


@pytest.mark.parametrize("degrees", [[60, 60, 60], [55, 65, 75], [60, 75, 75], [50, 50, 50, 50, 50]], ids=str)
@pytest.mark.parametrize("finer", [1, 2])
def test_who_is_held_by_steep_sides_may_jump(degrees: list[float], finer: int) -> None:
    """The foot of three rocks, the corner of a house and a rock: not a groove, and one lies still in it."""
    explore = ExploreSettings(physics_hz=30 * finer, action_repeat=4 * finer)
    simulator = MujocoSimulator(replace(funnel(degrees), explore=explore), 8)
    simulator.restore(np.arange(8), simulator.place(np.tile([0.05, 0.0, 1.5], (8, 1))))
    for _ in range(40):
        simulator.step(np.zeros((8, 2), dtype=np.int8))
    rests, highest = simulator.save()[:, 2], simulator.save()[:, 2]
    assert (simulator.save()[:, 6] > 0).all()
    for _ in range(8):
        simulator.step(np.tile(np.array([0, 1], dtype=np.int8), (8, 1)))
        highest = np.maximum(highest, simulator.save()[:, 2])
    assert (highest > rests + 0.4).all()


@pytest.mark.parametrize("who", PRESETS)
@pytest.mark.parametrize("degrees", [52, 58, 64, 70])
def test_nobody_falls_through_a_steep_slope(who: str, degrees: float) -> None:
    """It rises more within a tick of flight than the round end is high above its middle: one came out behind it."""
    c, n, rng = PRESETS[who], 256, np.random.default_rng(1)
    where = level(slope(degrees, 60, 200), box([-200, -100, -1], [0, 100, 0]), character=c, kill_z_m=-60)
    simulator = MujocoSimulator(where, n)
    states = simulator.place(
        np.column_stack([rng.uniform(-8, -1, n), rng.uniform(-50, 50, n), rng.uniform(8, 40, n)])
    )
    states[:, 3], states[:, 5] = rng.uniform(0.7, 1.0, n) * c.walk_speed_mps, -rng.uniform(0, 25, n)
    simulator.restore(np.arange(n), states)
    for _ in range(40):
        simulator.step(np.tile(np.array([EAST, 0], dtype=np.int8), (n, 1)))
        assert (simulator.save()[:, 2] > -0.5).all()
