"""Algorithm 1, with a simulator simple enough to check it by hand: a dot that walks on a plane with a hole."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from reachtest.explore import Explorer, Replayer
from reachtest.explore.actions import action_stream
from reachtest.explore.goals import sample_goals
from reachtest.explore.graph import UNKNOWN
from reachtest.explore.rollout import roll_out
from reachtest.records import (
    EndReason,
    Exploration,
    ExploreSettings,
    NavMesh,
    Origin,
    RoundRecord,
    StepResult,
    StopReason,
)
from tests.levels import level

SQUARE = np.array(
    [[[-15, -15, 0], [15, -15, 0], [15, 15, 0]], [[-15, -15, 0], [15, 15, 0], [-15, 15, 0]]], float
)
LEVEL = level(
    SQUARE,
    navmesh=SQUARE,
    explore=ExploreSettings(agents=4, episodes_at_once=1, steps=8_000, goal_spacing_m=5.0),
)


class Dot:
    """Walks a metre a step on a plane without end; falls where x > 20."""

    def __init__(self, agents: int) -> None:
        self.agents, self._states = agents, np.zeros((agents, 6))

    step_s = 0.1

    def use(self, agents):
        self._states = np.resize(self._states, (agents, 6))

    def place(self, positions):
        return np.concatenate([positions, np.zeros_like(positions)], axis=1)

    def restore(self, agents, states):
        self._states[agents] = states

    def save(self):
        return self._states.copy()

    def step(self, actions):
        angle = (actions[:, 0] - 1) * np.pi / 4
        moved = np.stack([np.cos(angle), np.sin(angle), np.zeros(len(angle))], axis=1)
        moved[actions[:, 0] == 0] = 0.0
        self._states = np.concatenate([self._states[:, :3] + moved, moved / self.step_s], axis=1)
        positions = self._states[:, :3]
        ended = np.where(positions[:, 0] > 20, EndReason.FELL, EndReason.ALIVE).astype(np.int8)
        stood = np.where((ended == EndReason.ALIVE)[:, None], positions, np.nan)
        return StepResult(positions.copy(), np.ones(len(positions), dtype=bool), stood, ended)


class Plane:
    """The nav-mesh of LEVEL: a square of 30 m."""

    def distance(self, points):
        away = np.linalg.norm(np.maximum(np.abs(points) - [15, 15, 0], 0.0), axis=1)
        return np.where(away <= 3.0, away, np.inf)


class Keep:
    def __init__(self) -> None:
        self.records: list[RoundRecord] = []

    def on_round(self, record: RoundRecord) -> None:
        self.records.append(record)


def explore(seed: int = 0, **changes) -> tuple[Exploration, list[RoundRecord]]:
    keep = Keep()
    changed = replace(LEVEL, explore=replace(LEVEL.explore, **changes))
    return Explorer(changed, Dot(changed.explore.agents), Plane(), seed, [keep]).run(), keep.records


def test_same_seed_same_bytes_and_another_seed_others() -> None:
    one, two, other = explore(1)[0], explore(1)[0], explore(2)[0]
    np.testing.assert_array_equal(one.points.positions, two.points.positions)
    np.testing.assert_array_equal(one.points.parent, two.points.parent)
    np.testing.assert_array_equal(one.goal_step, two.goal_step)
    assert one.falls[0].origin == two.falls[0].origin
    assert not np.array_equal(one.points.positions[:50], other.points.positions[:50])


def test_cached_points_are_those_of_the_algorithm_step_by_step() -> None:
    result, records = explore()
    anywhere: list[np.ndarray] = []  # everybody stands, always
    astray: list[np.ndarray] = []
    cached = []
    for record in records:
        before = np.full_like(record.trajectories[0], np.nan)
        for row in record.trajectories:  # one agent step after the other, all agents in order
            was, before = before, row
            for position, began in zip(row, np.isnan(was[:, 0]), strict=True):
                if np.isnan(position[0]):
                    continue
                off = np.isinf(Plane().distance(position[None])[0]) and not began
                known = [
                    kind for kind in ([anywhere, astray] if off else [anywhere]) if is_far(position, kind)
                ]
                for kind in known:
                    kind.append(position)
                if known:
                    cached.append(position)
    assert len(cached) > len(anywhere), "some were discovered by who was astray alone"
    np.testing.assert_array_equal(result.points.positions, cached)


def is_far(position: np.ndarray, known: list[np.ndarray]) -> bool:
    return not known or np.linalg.norm(np.array(known) - position, axis=1).min() > 1.0


def test_budget_is_kept_and_the_reason_told() -> None:
    result, records = explore(steps=1_000)
    assert 1_000 <= result.agent_steps < 1_000 + LEVEL.explore.agents
    assert result.stop_reason is StopReason.STEPS
    assert records[-1].agent_steps == result.agent_steps


def test_interruption_ends_after_the_round() -> None:
    asked = iter([None, None, StopReason.INTERRUPTED])
    explorer = Explorer(LEVEL, Dot(4), Plane(), 0, (), lambda: next(asked))
    result = explorer.run()
    assert result.stop_reason is StopReason.INTERRUPTED
    assert result.agent_steps == 2 * 4 * LEVEL.explore.reset_interval


def test_falls_carry_footing_and_exit() -> None:
    result, _ = explore()
    assert result.falls
    for fall in result.falls:
        assert fall.position[0] > 20
        assert 19 < fall.footing[0] <= 20
        assert 2 < Plane().distance(fall.exit_point[None])[0] <= 3  # a step before it is unexpected
    assert result.episodes > len(result.falls)
    assert (result.points.positions[:, 0] <= 20).all()


def test_unexpected_points_know_where_their_path_left_the_navmesh() -> None:
    points = explore()[0].points
    off = ~points.expected
    assert off.any()
    np.testing.assert_array_equal(points.exit_point[~off], points.positions[~off])
    inside = np.abs(points.exit_point[off]) - [15, 15, 0]
    assert (np.linalg.norm(np.maximum(inside, 0), axis=1) <= 3 + 1e-9).all()
    assert (
        Plane().distance(points.exit_point[off] * 1.0001 + 0) > 1.0
    ).mean() > 0.9  # at the rim, not anywhere


def test_an_agent_whose_episode_ends_goes_on_from_its_next_start() -> None:
    starts = np.zeros((2, 1, 6))
    starts[0, 0, :3], starts[1, 0, :3] = [19.5, 0, 0], [-3, 7, 0]
    east = np.ones((4, 1, 2), dtype=np.int8)
    rolled = roll_out(Dot(1), starts, east)
    assert rolled.ended[:, 0].tolist() == [EndReason.FELL, 0, 0, 0]
    assert np.isnan(rolled.positions[0, 0]).all()
    np.testing.assert_allclose(rolled.positions[1:, 0, 0], [-2, -1, 0])
    assert rolled.which[:, 0].tolist() == [0, 1, 1, 1]
    assert rolled.start[:, 0].tolist() == [0, 1, 1, 1]


def test_every_point_and_fall_is_replayed_bit_for_bit() -> None:
    result, _ = explore()
    replayer = Replayer(LEVEL, Dot(4), result.points, 0, result.headings)
    replayer.check()
    for index in (0, len(result.points) // 2, len(result.points) - 1):
        path = replayer.path_to_point(index)
        assert path.succeeded == 1
        np.testing.assert_array_equal(path.positions[-1], result.points.positions[index])
    fall = replayer.path_to_fall(result.falls[-1])
    assert fall.succeeded == 1
    assert fall.duration_s == pytest.approx(len(fall.positions) * 0.1)


def test_who_got_to_a_place_is_kept_as_it_was_there_bit_for_bit() -> None:
    explorer = Explorer(LEVEL, Dot(4), Plane(), 0)
    result = explorer.run()
    graph = explorer._ledger.transitions.graph()
    known = np.flatnonzero(graph.origins[:, 0] != UNKNOWN)
    origins = [Origin(*row) for row in graph.origins[known].tolist()]
    moved = np.array([origin.step > origin.start for origin in origins])
    assert 100 < moved.sum() < len(moved)
    replayer = Replayer(LEVEL, Dot(4), result.points, 0, result.headings)
    again, kept = replayer.states_at(origins), graph.states[known]
    np.testing.assert_array_equal(kept[moved], again[moved])
    assert np.isnan(kept[~moved]).all()


def test_a_simulator_that_does_not_restore_is_an_internal_error() -> None:
    from reachtest.errors import InternalError

    class Forgetful(Dot):
        def restore(self, agents, states):
            super().restore(agents, states + 1e-12)

    result, _ = explore()
    with pytest.raises(InternalError, match="bit for bit"):
        Replayer(LEVEL, Forgetful(4), result.points, 0, result.headings).check()


def test_action_streams_are_their_own() -> None:
    one = action_stream(7, 3, 5, 128)
    np.testing.assert_array_equal(one, action_stream(7, 3, 5, 128))
    assert any(
        not np.array_equal(one, action_stream(*other, 128)) for other in [(8, 3, 5), (7, 4, 5), (7, 3, 6)]
    )
    many = np.concatenate([action_stream(0, r, a, 128) for r in range(20) for a in range(4)])
    assert set(many[:, 0]) == set(range(9))
    assert set(many[:, 1]) == {0, 1}


def test_goals_are_spaced_and_leave_no_gap() -> None:
    navmesh = NavMesh("", SQUARE.reshape(-1, 3), np.arange(6).reshape(2, 3))
    goals = sample_goals(navmesh, 4.0)
    away = np.linalg.norm(goals[:, None] - goals[None], axis=2) + np.eye(len(goals)) * 99
    assert away.min() >= 4.0
    grid = np.stack(np.meshgrid(np.arange(-15, 15.1), np.arange(-15, 15.1)), axis=2).reshape(-1, 2)
    nearest = np.linalg.norm(grid[:, None] - goals[None, :, :2], axis=2).min(axis=1)
    assert nearest.max() < 1.5 * 4.0
    np.testing.assert_array_equal(goals, sample_goals(navmesh, 4.0))
