"""Followers get where their route leads, also around corners."""

from __future__ import annotations

import numpy as np

from reachtest.confirm.pursuit import Pursuit, Route, route_of
from reachtest.confirm.trials import Lane, run_lanes
from reachtest.world import MujocoSimulator
from tests.levels import FLOOR, box, level

STEPS = 80


def test_a_route_leaves_out_the_loops() -> None:
    there = np.array([[1.0, 0, 0], [2, 0, 0], [3, 0, 0], [2, 0.1, 0], [1, 0.1, 0], [1, 1, 0], [1, 2, 0]])
    actions = np.zeros((len(there), 2), dtype=np.int8)
    route = route_of(np.zeros(3), there, actions)
    assert route.points[0].tolist() == [0, 0, 0]
    assert route.points[-1].tolist() == [1, 2, 0]
    assert route.points[:, 0].max() < 2.5


def test_followers_go_around_a_wall() -> None:
    where = level(FLOOR, box([4, -8, 0], [4.5, 8, 3]))
    simulator = MujocoSimulator(where, 8, 1)
    points = np.concatenate(
        [np.linspace([0, 0, 0], [2, 9.5, 0], 12), np.linspace([6, 9.5, 0], [9, 0, 0], 12)]
    )
    route = Route(points, np.zeros(len(points), dtype=np.bool_))
    rng = np.random.default_rng(0)
    start = simulator.place(np.array([[0.0, 0, 0.02]]))[0]
    lanes = [
        Lane(start, Pursuit(route, ahead, False, rng.random((STEPS, 3))), STEPS)
        for ahead in (0.8, 0.8, 1.5, 1.5, 2.5, 2.5)
    ]
    for trial in run_lanes(simulator, lanes):
        assert np.linalg.norm(trial.positions - points[-1], axis=1).min() < 0.6
        assert not trial.fell


def test_lanes_beyond_the_simulator_run_one_batch_after_the_other() -> None:
    simulator = MujocoSimulator(level(FLOOR), 2, 1)
    start = simulator.place(np.array([[0.0, 0, 0.02]]))[0]
    scripts = [np.tile(np.array([[1 + i, 0]], dtype=np.int8), (4 + i, 1)) for i in range(5)]
    trials = run_lanes(simulator, [Lane(start, script, len(script)) for script in scripts])
    assert [len(trial) for trial in trials] == [4, 5, 6, 7, 8]
    for i, trial in enumerate(trials):  # stick 1 + i points 45 i degrees
        towards = np.array([np.cos(i * np.pi / 4), np.sin(i * np.pi / 4)])
        assert trial.positions[-1, :2] @ towards > 0.95 * np.linalg.norm(trial.positions[-1, :2]) > 1
