"""The simulator keeps its promises: a restored state is the state, threads change nothing, ends are told."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from reachtest.levels import PRESETS
from reachtest.records import EndReason, ExploreSettings
from reachtest.world import MujocoSimulator
from tests.levels import EAST, FLOOR, NORTH_EAST, SOUTH_EAST, box, level, slope

COURSE = level(
    FLOOR,
    box([3, -4, 0], [5, 4, 0.4]),
    box([-6, 2, 0], [-2, 6, 1.0]),
    box([8, -20, 0], [9, 20, 4]),
    slope(30, 6.0, x=-20),
    explore=ExploreSettings(agents=8, episodes_at_once=1),
    kill_z_m=-5,
)


def actions(rng: np.random.Generator, steps: int, agents: int) -> np.ndarray:
    return np.stack([rng.integers(0, 9, (steps, agents)), rng.random((steps, agents)) < 0.3], axis=2).astype(
        np.int8
    )


def starts(agents: int) -> np.ndarray:
    return np.array([[0.3 * i - 1, 0.2 * i, 0.02] for i in range(agents)])


def test_a_restored_state_goes_on_bit_for_bit_in_any_agent() -> None:
    stream = actions(np.random.default_rng(3), 60, 8)
    whole = MujocoSimulator(COURSE, 8, 1)
    whole.restore(np.arange(8), whole.place(starts(8)))
    saved = []
    for step in stream:
        saved.append(whole.save())
        whole.step(step)
    fresh = MujocoSimulator(COURSE, 8, 1)
    fresh.restore(np.arange(8), fresh.place(starts(8)))
    for step in stream[:7]:  # a past of its own that must not matter
        fresh.step(step)
    for cut in (1, 13, 30, 59):
        order = np.random.default_rng(cut).permutation(8)
        fresh.restore(np.arange(8), saved[cut][order])
        for step in stream[cut:]:
            fresh.step(step[order])
        np.testing.assert_array_equal(fresh.save(), whole.save()[order])


def test_threads_change_nothing() -> None:
    stream = actions(np.random.default_rng(4), 60, 8)
    ends = []
    for threads in (1, 2):
        simulator = MujocoSimulator(COURSE, 8, threads)
        simulator.restore(np.arange(8), simulator.place(starts(8)))
        for step in stream:
            simulator.step(step)
        ends.append(simulator.save())
    np.testing.assert_array_equal(ends[0], ends[1])


def test_agents_cannot_touch_each_other() -> None:
    simulator = MujocoSimulator(COURSE, 4, 1)
    simulator.restore(np.arange(4), simulator.place(np.tile([0.0, 0.0, 0.02], (4, 1))))
    for _ in range(10):
        result = simulator.step(np.array([[1, 0]] * 4, dtype=np.int8))
    np.testing.assert_array_equal(result.positions, np.tile(result.positions[0], (4, 1)))


def test_divergence_is_told_and_the_others_go_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    simulator = MujocoSimulator(COURSE, 3, 1)
    states = simulator.place(starts(3))
    states[1, 3:6] = np.nan
    simulator.restore(np.arange(3), states)
    result = simulator.step(np.zeros((3, 2), dtype=np.int8))
    assert result.ended.tolist() == [EndReason.ALIVE, EndReason.DIVERGED, EndReason.ALIVE]
    simulator.restore(np.array([1]), simulator.place(starts(1)))
    assert simulator.step(np.zeros((3, 2), dtype=np.int8)).ended.tolist() == [EndReason.ALIVE] * 3
    assert capfd.readouterr() == ("", "")  # stdout is for the report,
    assert not list(tmp_path.iterdir())  # and the working directory somebody's checkout


def test_falling_out_is_told() -> None:
    simulator = MujocoSimulator(COURSE, 2, 1)
    simulator.restore(np.arange(2), simulator.place(np.array([[0, 0, 0.02], [70, 0, 0.02]])))
    ended = [simulator.step(np.zeros((2, 2), dtype=np.int8)).ended.copy() for _ in range(12)]
    assert all(e[0] == EndReason.ALIVE for e in ended)
    assert [int(e[1]) for e in ended].count(EndReason.FELL) > 0


def test_leaving_the_bounds_is_a_fall() -> None:
    simulator = MujocoSimulator(COURSE, 1, 1)
    simulator.restore(np.arange(1), simulator.place(np.array([[0.0, 2000.0, 0.0]])))
    assert simulator.step(np.zeros((1, 2), dtype=np.int8)).ended[0] == EndReason.FELL


def test_precision_does_not_depend_on_the_distance_from_the_origin() -> None:
    """Mesh vertices are float32 in the simulator; geoms are placed in float64."""
    far = np.array([5_000.0, -5_000.0, 100.0])
    ends = []
    for offset in (np.zeros(3), far):
        simulator = MujocoSimulator(level(COURSE.collision + offset, kill_z_m=-500), 4, 1)
        simulator._bounds = (np.full(3, -1e5), np.full(3, 1e5))
        simulator.restore(np.arange(4), simulator.place(starts(4) + offset))
        for step in actions(np.random.default_rng(5), 12, 4):
            simulator.step(step)
        ends.append(simulator.save()[:, :3] - offset)
    np.testing.assert_allclose(ends[0], ends[1], atol=1e-3)


def test_who_is_not_in_use_changes_nothing() -> None:
    where, rng = level(FLOOR, box([2, -9, 0], [2.5, 9, 3])), np.random.default_rng(4)
    few, many = MujocoSimulator(where, 3, 1), MujocoSimulator(where, 8, 2)
    states = few.place(starts(3))
    many.use(3)
    script = actions(rng, 40, 3)
    for simulator in (few, many):
        simulator.restore(np.arange(3), states)
    for step in script:
        one, other = few.step(step), many.step(step)
        np.testing.assert_array_equal(one.stood, other.stood)
        np.testing.assert_array_equal(one.ended, other.ended)
        np.testing.assert_array_equal(few.save(), many.save())
    many.use(8)
    assert len(many.save()) == 8
    np.testing.assert_array_equal(few.save(), many.save()[:3])


@pytest.mark.parametrize(("thick", "drop"), [(0.02, 8.0), (0.2, 18.0)])
def test_who_falls_fast_onto_the_edge_of_a_floor_is_never_in_it(thick: float, drop: float) -> None:
    """At 0.4 m and more a tick the edge is crossed between two looks: then the capsule hung in the plate."""
    plate, ground = box([0, -50, 10 - thick], [79, 50, 10]), box([-80, -80, -1], [80, 80, 0])
    n, rng = 1024, np.random.default_rng(0)
    simulator = MujocoSimulator(level(plate, ground), n)
    height, angle, speed = drop + rng.random(n), rng.uniform(-1.2, 1.2, n), rng.uniform(0.0, 6.0, n)
    flat = speed[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    begin = rng.uniform(-0.5, 0.45, n) - flat[:, 0] * np.sqrt(2 * height / 9.8)  # so as to land at the edge
    states = simulator.place(np.column_stack([begin, rng.uniform(-30, 30, n), 10 + height]))
    states[:, 3:5] = flat
    simulator.restore(np.arange(n), states)
    for _ in range(30):
        simulator.step(np.zeros((n, 2), dtype=np.int8))
    feet = simulator.save()[:, 2]
    assert ((feet > 9.85) | (feet < 0.05)).all()  # at an edge the capsule hangs a little
    assert 0.3 < (feet > 9.85).mean() < 0.7


@pytest.mark.parametrize("who", PRESETS)
@pytest.mark.parametrize("thick", [0.1, 0.6, 2.0])
@pytest.mark.parametrize("wider", [-0.05, -0.02, 0.02])
def test_a_slot_that_is_too_narrow_is_passed_by_nobody(who: str, thick: float, wider: float) -> None:
    """Run at from all sides, with jumps: pushed off one corner, the capsule was in one side only, and then through."""
    c, n, rng = PRESETS[who], 128, np.random.default_rng(0)
    half = c.radius_m + wider / 2
    sides = [box([0, *y, 0], [thick, *end, 4]) for y, end in (([-20], [-half]), ([half], [20]))]
    simulator = MujocoSimulator(level(FLOOR, *sides, character=c), n)
    places = np.column_stack([rng.uniform(-4, -1, n), rng.uniform(-1.5, 1.5, n), np.full(n, 0.02)])
    simulator.restore(np.arange(n), simulator.place(places))
    for _ in range(50):
        y, anyhow = simulator.save()[:, 1], rng.random(n) < 0.2
        towards = np.select([np.abs(y) < 0.1, y > 0], [EAST, SOUTH_EAST], NORTH_EAST)
        stick = np.where(anyhow, rng.integers(0, 9, n), towards)
        simulator.step(np.stack([stick, rng.random(n) < 0.1], axis=1).astype(np.int8))
    through = simulator.save()[:, 0] > thick + c.radius_m / 2
    assert through.mean() > 0.5 if wider > 0 else not through.any()
