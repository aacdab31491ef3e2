"""A world simple enough to work out by hand: a walker that hops on a plane with a hole and falls for a while."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from reachtest.explore import Explorer, Replayer
from reachtest.records import (
    Bools,
    EndReason,
    Exploration,
    ExploreSettings,
    Floats,
    Ints,
    Level,
    RoundRecord,
    StepResult,
)
from tests.levels import level

STRIDE_M, JUMP_M, FALL_M, KILL_Z_M = 0.7, 1.2, 1.5, -9.0
HOLE = (6.0, 10.0)  # [m] in x and in y
HAZE_M = -14.0  # [m] west of here the simulation diverges
FENCE_M = 17.0  # [m] from the middle; beyond 15 is unexpected
SQUARE = np.array(
    [[[-12, -12, 0], [12, -12, 0], [12, 12, 0]], [[-12, -12, 0], [12, 12, 0], [-12, 12, 0]]], float
)
LEVEL = level(
    SQUARE,
    navmesh=SQUARE,
    explore=ExploreSettings(
        agents=5, episodes_at_once=1, reset_interval=128, steps=12_000, goal_spacing_m=4.0
    ),
    kill_z_m=KILL_Z_M,
    spawn=[0.0, 0.0, 0.0],
)


class Walker:
    """Meets `interfaces.Simulator`: a state is position [3], no velocity [3], steps taken [1]."""

    def __init__(self, agents: int) -> None:
        self.agents, self._states = agents, np.zeros((agents, 7))

    def use(self, agents: int) -> None:
        """Who was not in use before has to be restored."""
        self._states = np.resize(self._states, (agents, 7))

    @property
    def step_s(self) -> float:
        return 0.25

    def place(self, positions: Floats) -> Floats:
        return np.concatenate([positions, np.zeros((len(positions), 4))], axis=1)

    def restore(self, agents: Ints, states: Floats) -> None:
        self._states[agents] = states

    def save(self) -> Floats:
        return self._states.copy()

    def step(self, actions: NDArray[np.int8]) -> StepResult:
        """Walk or drift a stride; a hop is up for one step; over the hole it goes down and never up again."""
        x, y, z, *_, steps = self._states.T
        falling = (z < 0) | ((z == 0) & over_hole(x, y))
        angle = (actions[:, 0] - 1) * np.pi / 4
        moves = (actions[:, 0] > 0) & ~falling
        x += moves * np.cos(angle) * STRIDE_M
        y += moves * np.sin(angle) * STRIDE_M
        np.clip(self._states[:, :2], -FENCE_M, FENCE_M, out=self._states[:, :2])
        hops = (z == 0) & ~falling & (actions[:, 1] > 0)
        z[:] = np.where(falling, z - FALL_M, np.where(hops, JUMP_M, 0.0))
        steps += 1
        ended = np.where(z < KILL_Z_M, EndReason.FELL, EndReason.ALIVE)
        diverged = x < HAZE_M
        x[diverged] = np.nan
        ended = np.where(diverged, EndReason.DIVERGED, ended)
        positions, grounded = self._states[:, :3].copy(), stands(self._states)
        stood = np.where(grounded[:, None], positions, np.nan)
        return StepResult(positions, grounded, stood, ended.astype(np.int8))


def over_hole(x: Floats, y: Floats) -> Bools:
    """Whether there is no ground at (x, y)."""
    return (x > HOLE[0]) & (x < HOLE[1]) & (y > HOLE[0]) & (y < HOLE[1])


def stands(positions: Floats) -> Bools:
    """Which walkers at `positions` [n, 3 or more] have ground under their feet."""
    return (positions[:, 2] == 0) & ~over_hole(positions[:, 0], positions[:, 1])


class Plane:
    """Meets `interfaces.Surface`: the square of LEVEL."""

    def distance(self, points: Floats) -> Floats:
        away = np.linalg.norm(np.maximum(np.abs(points) - [12, 12, 0], 0.0), axis=-1)
        return np.where(away <= 3.0, away, np.inf)


class Run:
    """An exploration by walkers with all it told on the way."""

    def __init__(self, seed: int = 0, where: Level = LEVEL, simulator: Any = None, **changes: Any) -> None:
        self.level = replace(where, explore=replace(where.explore, **changes))
        self.seed = seed
        self.simulator = simulator or Walker(self.level.explore.agents)
        self.records: list[RoundRecord] = []
        self.explorer = Explorer(self.level, self.simulator, Plane(), seed, [self])
        self.result: Exploration = self.explorer.run()

    def on_round(self, record: RoundRecord) -> None:
        self.records.append(record)

    @property
    def trajectories(self) -> Floats:
        """[T, B, 3] of the whole run; NaN where an agent step ended its episode."""
        return np.concatenate([record.trajectories for record in self.records])

    @property
    def episodes(self) -> Ints:
        """Number [T, B] of the episode each agent step belongs to, over the whole run."""
        numbers, first = [], 0
        for record in self.records:
            ended = np.isnan(record.trajectories[:, :, 0])
            within = np.cumsum(ended, axis=0) - ended  # the step that ends an episode is its own
            per_agent = within[-1] + 1
            numbers.append(within + first + np.cumsum(per_agent) - per_agent)
            first += int(per_agent.sum())
        return np.concatenate(numbers)

    def replayer(self) -> Replayer:
        points, headings = self.result.points, self.result.headings
        return Replayer(self.level, Walker(self.level.explore.agents), points, self.seed, headings)
