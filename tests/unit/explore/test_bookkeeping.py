"""What an exploration tells, worked out again from what its agents did."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from reachtest.explore.archive import Archive
from reachtest.explore.cache import PositionCache
from reachtest.explore.goals import sample_goals
from reachtest.records import Floats, NavMesh, ReplayPath, Required, Spawn, StopReason
from tests.unit.explore.walker import HAZE_M, KILL_Z_M, LEVEL, SQUARE, Plane, Run, Walker, stands

REQUIRED = (
    Required("corner", np.array([11.0, -11.0, 0.0]), 2.0),
    Required("moon", np.array([0, 0, 99.0]), 2.0),
)


@pytest.fixture(scope="module")
def run() -> Run:
    return Run(seed=3, where=replace(LEVEL, required=REQUIRED))


def algorithm_1(run: Run) -> Floats:
    """S_disc of the paper, state by state: agent after agent at every timestep; again for where one stood, and again
    for where one stood off the nav-mesh."""
    known: dict[str, list[Floats]] = {"anywhere": [], "stood": [], "astray": []}
    found = []
    for state, before in _with_the_one_before(run):
        if np.isnan(state[0]):
            continue
        kinds = ["anywhere"]
        if stands(state[None])[0]:
            kinds += ["stood"]
            if np.isinf(Plane().distance(state[None])[0]) and stands(before[None])[0]:
                kinds += ["astray"]
        new = [kind for kind in kinds if _is_far(state, known[kind], run.level.explore.threshold_m)]
        for kind in new:
            known[kind].append(state)
        if new:
            found.append(state)
    return np.array(found)


def _with_the_one_before(run: Run) -> Iterator[tuple[Floats, Floats]]:
    """Every state, and that of the same agent a step before; NaN where an episode begins."""
    for record in run.records:
        before = np.full_like(record.trajectories[0], np.nan)
        for row in record.trajectories:
            yield from zip(row, before, strict=True)
            before = row


def _is_far(state: Floats, known: list[Floats], threshold_m: float) -> bool:
    return not known or bool(np.linalg.norm(np.array(known) - state, axis=1).min() > threshold_m)


def test_whole_rounds_give_what_single_steps_give(run) -> None:
    np.testing.assert_array_equal(run.result.points.positions, algorithm_1(run))


def test_new_points_are_told_in_the_round_that_found_them(run) -> None:
    told = np.concatenate([record.new_points for record in run.records])
    np.testing.assert_array_equal(told, run.result.points.positions)
    expected = np.concatenate([record.new_expected for record in run.records])
    np.testing.assert_array_equal(expected, run.result.points.expected)
    assert [record.points for record in run.records] == np.cumsum(
        [len(r.new_points) for r in run.records]
    ).tolist()
    rounds = np.repeat([record.round for record in run.records], [len(r.new_points) for r in run.records])
    np.testing.assert_array_equal(run.result.points.round, rounds)


def test_origins_name_the_step_that_found_the_point(run) -> None:
    points = run.result.points
    for index in range(len(points)):
        origin = points.origin(index)
        found = run.records[origin.round].trajectories[origin.step - 1, origin.agent]
        np.testing.assert_array_equal(found, points.positions[index])
        assert origin.parent < index


def test_the_distance_to_the_navmesh_is_that_of_the_surface(run) -> None:
    exact = Plane().distance(run.result.points.positions)
    np.testing.assert_array_equal(run.result.points.off_mesh_m, exact.astype(np.float32))  # kept in 4 bytes


PIT = replace(LEVEL, spawns=(Spawn("pit", np.array([8.0, 8.0, 0.0])),))


@pytest.mark.parametrize(
    ("where", "interval"), [(LEVEL, 128), (PIT, 128), (PIT, 32)], ids=["plane", "pit", "short"]
)
def test_visits_and_incidence_count_every_episode_once_a_cell(where, interval) -> None:
    """From the pit an agent falls every seven steps: more often in a round than it had starts drawn."""
    run = Run(seed=1, where=where, steps=2_560, reset_interval=interval)
    episodes = run.episodes
    who: dict[tuple[int, ...], set[int]] = defaultdict(set)
    for position, episode in zip(run.trajectories.reshape(-1, 3), episodes.ravel().tolist(), strict=True):
        if np.isfinite(position[0]):
            who[tuple(np.floor(position).astype(int).tolist())].add(episode)
    cells = [tuple(np.floor(p).astype(int).tolist()) for p in run.result.points.positions]
    assert run.result.visits.tolist() == [len(who[cell]) for cell in cells]
    counts = [len(episodes) for episodes in who.values()]
    told = run.result.cells_once, run.result.cells_twice, run.result.cells_total
    assert told == (counts.count(1), counts.count(2), len(counts))


def test_episodes_ends_and_steps_are_counted(run) -> None:
    result, ended = run.result, np.isnan(run.trajectories[:, :, 0])
    assert result.agent_steps == ended.size
    assert result.diverged_episodes > 0
    assert result.falls
    assert result.diverged_episodes + len(result.falls) == ended.sum()
    # An end at the last step of a round starts no new episode.
    late = sum(int(np.isnan(record.trajectories[-1, :, 0]).sum()) for record in run.records)
    assert result.episodes == len(run.records) * result.settings.agents + ended.sum() - late


def test_goals_and_required_points_are_reached_at_the_first_step_near_them(run) -> None:
    positions = run.trajectories.reshape(-1, 3)
    positions = np.where(np.isnan(positions), np.inf, positions)

    def first(place: Floats, within: float) -> int:
        near = np.linalg.norm(positions - place, axis=1) <= within
        return int(near.argmax()) + 1 if near.any() else -1

    assert run.result.goal_step.tolist() == [first(goal, 1.0) for goal in run.result.goals]
    assert run.result.required_step.tolist() == [first(place.position, place.within_m) for place in REQUIRED]
    assert run.result.required_step[0] > 0
    assert run.records[-1].goals_reached == (run.result.goal_step >= 0).sum()
    assert run.records[-1].goals_total == len(run.result.goals)


def last_stand(path: ReplayPath, on_mesh: bool = False) -> Floats:
    """Where the walker stood last on its whole way from the spawn; on the nav-mesh, if asked. NaN: nowhere."""
    good = stands(path.positions)
    if on_mesh:
        good &= np.isfinite(Plane().distance(path.positions))
    return path.positions[good][-1] if good.any() else np.full(3, np.nan)


def test_the_exit_of_a_point_is_where_the_walker_last_stood_on_the_navmesh(run) -> None:
    """The way may lead through many episodes, and any of them may begin in mid-air: it is re-simulated."""
    points, replayer = run.result.points, run.replayer()
    assert not points.expected[points.parent[~points.expected]].all()  # some were found from unexpected ones
    assert not points.grounded[points.parent].all()  # and some from mid-air
    paths = [replayer.path_to_point(index) for index in range(len(points))]
    assert all(path.succeeded == path.attempts == 1 for path in paths)
    exits = [last_stand(path, on_mesh=True) for path in paths]
    np.testing.assert_allclose(points.exit_point, exits, rtol=1e-6)  # kept in 4 bytes


def test_a_fall_knows_where_the_walker_last_stood_and_where_on_the_navmesh() -> None:
    """Points cached in mid-hop are restarted from, too: who drifts over the hole from there stood further back."""
    rim = replace(LEVEL, spawns=(Spawn("rim", np.array([5.5, 8.0, 0.0])),))
    run = Run(where=rim, reset_interval=16, steps=20_000, heuristics={"uniform": 1.0})
    falls, points, replayer = run.result.falls, run.result.points, run.replayer()
    assert any(fall.origin.parent >= 0 and not points.grounded[fall.origin.parent] for fall in falls)
    paths = [replayer.path_to_fall(fall) for fall in falls]
    assert all(path.succeeded == path.attempts == 1 for path in paths)
    np.testing.assert_array_equal([fall.position for fall in falls], [path.positions[-1] for path in paths])
    assert all(fall.position[2] < KILL_Z_M for fall in falls)
    exits = [last_stand(p, on_mesh=True) for p in paths]
    np.testing.assert_allclose([f.exit_point for f in falls], exits, rtol=1e-6)
    np.testing.assert_allclose([fall.footing for fall in falls], [last_stand(path) for path in paths])


def test_who_never_stood_fell_from_the_spawn() -> None:
    """Also when the fall was cut in two by a restart in mid-air."""
    run = Run(where=PIT, steps=2_000)
    assert any(fall.origin.parent >= 0 for fall in run.result.falls)
    assert {tuple(fall.footing.tolist()) for fall in run.result.falls} == {(8.0, 8.0, 0.0)}


def test_what_diverged_is_never_a_position(run) -> None:
    points = run.result.points
    assert np.isfinite(points.positions).all()
    assert np.isfinite(points.states).all()
    assert (points.positions[:, 0] >= HAZE_M).all()


@pytest.mark.parametrize("steps", [1, 4, 5, 641, 1_283])
def test_the_budget_is_used_up_to_less_than_one_step_an_agent_more(steps) -> None:
    run = Run(steps=steps)
    assert steps <= run.result.agent_steps < steps + 5
    assert run.trajectories.shape[0] * 5 == run.result.agent_steps
    assert run.result.stop_reason is StopReason.STEPS


def test_a_longer_run_begins_as_the_shorter_one() -> None:
    short, long = Run(steps=5 * 128 * 4), Run(steps=5 * 128 * 6)
    np.testing.assert_array_equal(short.trajectories, long.trajectories[: 128 * 4])


def test_a_time_budget_ends_the_run_after_the_round() -> None:
    run = Run(steps=10**9, time_budget_s=1e-6)
    assert run.result.stop_reason is StopReason.TIME
    assert len(run.records) <= 1


def test_every_spawn_is_used_whatever_the_heuristics_say() -> None:
    spawns = tuple(Spawn(f"spawn {i}", np.array([1.8 * i - 10.8, -3.0, 0.0])) for i in range(13))
    run = Run(where=replace(LEVEL, spawns=spawns), steps=5 * 128 * 3, reset_interval=128)
    starts = np.concatenate([record.trajectories[0] for record in run.records])
    for spawn in spawns:
        assert np.linalg.norm((starts - spawn.position)[:, :2], axis=1).min() < 0.71


def test_no_restart_from_free_fall_below_the_level() -> None:
    """Walkers are cached on the way down; restarting there is a wasted episode."""
    run = Run(heuristics={"uniform": 1.0})
    points = run.result.points
    below = ~points.grounded & (points.positions[:, 2] < -LEVEL.character.height_m)
    assert below.any()
    parents = {fall.origin.parent for fall in run.result.falls}
    assert not below[[parent for parent in parents if parent >= 0]].any()


def test_a_level_where_everything_diverges_ends_with_nothing_found() -> None:
    where = replace(LEVEL, spawns=(Spawn("haze", np.array([HAZE_M - 5.0, 0.0, 0.0])),))
    result = Run(where=where, steps=1_280).result
    assert len(result.points) == 0
    assert result.diverged_episodes == result.episodes == 1_280
    assert (result.goal_step == -1).all()
    assert result.stop_reason is StopReason.STEPS


def test_nothing_global_is_used_or_changed() -> None:
    np.random.seed(1)  # noqa: NPY002 - the global state is what this is about
    before = np.random.get_state()[1].copy()  # noqa: NPY002
    one = Run(steps=2_000).result
    np.testing.assert_array_equal(before, np.random.get_state()[1])  # noqa: NPY002
    np.random.seed(2)  # noqa: NPY002
    two = Run(steps=2_000).result
    np.testing.assert_array_equal(one.points.positions, two.points.positions)
    np.testing.assert_array_equal(one.goals, two.goals)


def test_a_simulator_with_another_past_changes_nothing() -> None:
    used = Walker(5)
    used.restore(np.arange(5), np.full((5, 7), 3.0))
    np.testing.assert_array_equal(
        Run(simulator=used, steps=3_000).trajectories, Run(steps=3_000).trajectories
    )


ISLANDS = np.concatenate(
    [
        SQUARE,
        SQUARE * 0.01 + [40.0, 0.0, 0.0],  # an island of a quarter of a metre
        SQUARE * [0.5, 0.5, 0.0] + [0.0, 0.0, 6.0],  # a floor above
        (SQUARE * [1.0, 0.02, 0.0]) + [0.0, 60.0, 2.0],  # a beam 24 m long and half a metre wide
        np.array([[[0.0, -40, 0], [20, -40, 0], [20, -40, 0]]]),  # nothing
    ]
)


@pytest.mark.parametrize("spacing", [1.5, 4.0])
def test_goals_are_spaced_lie_on_the_navmesh_and_leave_no_part_of_it_out(spacing) -> None:
    goals = sample_goals(
        NavMesh("", ISLANDS.reshape(-1, 3), np.arange(3 * len(ISLANDS)).reshape(-1, 3)), spacing
    )
    away = np.linalg.norm(goals[:, None] - goals[None], axis=2)
    np.fill_diagonal(away, np.inf)
    assert away.min() >= spacing
    weights = np.random.default_rng(0).dirichlet([1, 1, 1], (len(ISLANDS) - 1, 400))
    samples = np.einsum("fnk,fkd->fnd", weights, ISLANDS[:-1]).reshape(-1, 3)
    gap = np.linalg.norm(samples[:, None] - goals[None], axis=2).min(axis=1)
    assert gap.max() < 1.5 * spacing
    on_mesh = np.linalg.norm(goals[:, None] - samples[None], axis=2).min(axis=1)
    assert on_mesh.max() < 2.0  # as near as 400 samples a triangle come to any point of it
    assert set(np.round(goals[:, 2], 9)) == {0.0, 2.0, 6.0}


def test_a_cached_point_takes_at_most_100_bytes_outside_the_tree(run) -> None:
    """With the state size of the MuJoCo simulator, half the points in the air, each from a place of its own."""
    rng = np.random.default_rng(0)
    cache = PositionCache(1e-9)
    archive = Archive(cache, 7, lanes=256, interval=32)
    states = rng.normal(size=(4096, 7))
    cache.insert(states[:, :3])
    air = rng.random((4096, 1)) < 0.5
    stood = np.where(air, np.repeat(rng.normal(size=(1024, 3)), 4, axis=0), states[:, :3])
    zeros = {
        name: np.zeros(4096) for name in ("parent", "round", "agent", "start", "step", "off_mesh_m", "cell")
    }
    archive.append(states, stood, states[:, :3], grounded=~air[:, 0], above_m=air[:, 0], **zeros)
    assert archive.bytes_per_point <= 100
    np.testing.assert_array_equal(archive.states_of(np.arange(4096)), states)
    some = np.array([0, 1, 2, 3, 4095])
    np.testing.assert_allclose(archive.footings_of(some), stood[some], rtol=1e-7)
    np.testing.assert_array_equal(archive.exits_of(some), states[some, :3])


@pytest.mark.parametrize(("lanes", "interval"), [(1, 1), (256, 255), (257, 256), (4096 * 64, 32_767)])
def test_where_a_point_came_from_is_kept_for_any_number_of_lanes_and_steps(lanes: int, interval: int) -> None:
    cache = PositionCache(1e-9)
    archive = Archive(cache, 3, lanes, interval)
    states = np.arange(6.0).reshape(2, 3)
    cache.insert(states)
    last = {
        "agent": np.array([0, lanes - 1]),
        "step": np.array([1, interval]),
        "start": np.array([0, interval]),
    }
    other = {name: np.zeros(2) for name in ("parent", "round", "off_mesh_m", "cell", "grounded", "above_m")}
    archive.append(states, states, states, **last, **other)
    points = archive.points()
    for name, values in last.items():
        np.testing.assert_array_equal(getattr(points, name), values)
