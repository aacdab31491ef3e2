"""Go-Explore for reachability (Algorithm 1 of Lu, Georgescu & Verwey), a round at a time.

All agents restart at the same step and the cache influences only the choice at a restart, so a whole round is
simulated first and its positions are inserted afterwards in (step, agent) order: the same result as inserting
step by step. An agent draws the starts of its next few episodes at once; those do not depend on each other
either, so they are simulated side by side, a lane each.

Shape legend: B lanes (episodes under way), T agent steps of a round, M starts an agent, P cached points, n new points.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence

import numpy as np

from reachtest.explore.actions import action_stream, start_generator
from reachtest.explore.heuristics import mixture
from reachtest.explore.ledger import Ledger
from reachtest.explore.rollout import Trajectories, roll_out
from reachtest.interfaces import Observer, Simulator, Surface
from reachtest.records import Exploration, Ints, Level, RoundRecord, StopReason

STARTS_PER_AGENT = 16  # drawn beforehand: at a metre a step a fall takes eight steps at the least


class Explorer:
    """One exploration of one level."""

    def __init__(
        self,
        level: Level,
        simulator: Simulator,
        surface: Surface,
        seed: int,
        observers: Sequence[Observer] = (),
        interrupted: Callable[[], StopReason | None] = lambda: None,
    ) -> None:
        """`surface` tells expected from unexpected positions; `interrupted` is asked after every round."""
        self._level, self._settings, self._seed = level, level.explore, seed
        self._simulator = simulator
        self._observers, self._interrupted = observers, interrupted
        spawns = simulator.place(np.array([spawn.position for spawn in level.spawns]))
        self._ledger = Ledger(level, surface, spawns)
        self._eta = mixture(level.explore.heuristics, level.explore.power)
        self._began, self._physics_s = time.monotonic(), 0.0

    def run(self) -> Exploration:
        """Explore until a budget ends or the run is interrupted."""
        while (stop := self._should_stop()) is None:
            self._one_round()
        wall = time.monotonic() - self._began
        ledger = self._ledger
        physics, cache = self._physics_s, ledger.cache_s
        once, twice, cells = ledger.visits.incidence()
        return Exploration(
            points=ledger.archive.points(),
            visits=ledger.visits.of(ledger.archive.cells),
            goals=ledger.on_navmesh,
            goal_step=ledger.goal_step,
            required_step=ledger.required_step,
            falls=tuple(ledger.falls),
            agent_steps=ledger.steps,
            episodes=ledger.episodes,
            diverged_episodes=ledger.diverged,
            cells_once=once,
            cells_twice=twice,
            cells_total=cells,
            stop_reason=stop,
            seed=self._seed,
            settings=self._settings,
            timing={"wall_s": wall, "physics_s": physics, "cache_s": cache, "rest_s": wall - physics - cache},
        )

    @property
    def bytes_per_point(self) -> float:
        """What a cached point takes outside the tree."""
        return self._ledger.archive.bytes_per_point

    def _should_stop(self) -> StopReason | None:
        s = self._settings
        if self._ledger.steps >= s.steps:
            return StopReason.STEPS
        if s.time_budget_s is not None and time.monotonic() - self._began >= s.time_budget_s:
            return StopReason.TIME
        return self._interrupted()

    def _one_round(self) -> None:
        s = self._settings
        number = self._ledger.rounds
        length = min(s.reset_interval, -(-(s.steps - self._ledger.steps) // s.lanes))
        streams = [
            action_stream(self._seed, number, agent, s.reset_interval)[:length] for agent in range(s.lanes)
        ]
        parents = self._draw_starts()
        began = time.monotonic()
        rolled = roll_out(self._simulator, self._ledger.states_of(parents), np.stack(streams, axis=1))
        self._physics_s += time.monotonic() - began
        new = self._ledger.record(rolled, parents)
        self._tell(rolled, new)

    def _draw_starts(self) -> Ints:
        """What each agent starts from [M, B]: cached points, or -1 - i for spawn i."""
        agents, number, archive = self._settings.lanes, self._ledger.rounds, self._ledger.archive
        shape, spawns = (STARTS_PER_AGENT, agents), len(self._level.spawns)
        if not len(archive) or number * agents < spawns:  # every spawn is used at least once
            return -1 - (number * agents + np.arange(shape[0] * agents).reshape(shape)) % spawns
        weight = np.where(archive.hopeless, 0.0, self._eta(self._ledger.candidates()))
        if not weight.any():
            weight[:] = 1.0
        total = np.cumsum(weight)
        draws = start_generator(self._seed, number).random(shape) * total[-1]
        return np.minimum(np.searchsorted(total, draws, side="right"), len(weight) - 1)

    def _tell(self, rolled: Trajectories, new: Ints) -> None:
        ledger = self._ledger
        off_mesh_m = ledger.archive.off_mesh_m
        record = RoundRecord(
            round=ledger.rounds - 1,
            agent_steps=ledger.steps,
            sim_time_s=ledger.steps / self._settings.lanes * self._simulator.step_s,
            trajectories=rolled.positions,
            new_points=rolled.positions[new[:, 0], new[:, 1]],
            new_expected=np.isfinite(off_mesh_m[len(off_mesh_m) - len(new) :]),
            points=len(ledger.archive),
            goals_reached=int((ledger.goal_step >= 0).sum()),
            goals_total=len(ledger.on_navmesh),
            falls=len(ledger.falls),
        )
        for observer in self._observers:
            observer.on_round(record)
