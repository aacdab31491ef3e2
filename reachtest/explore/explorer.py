"""Go-Explore for reachability (Algorithm 1 of Lu, Georgescu & Verwey), a round at a time.

All agents restart at the same step and the cache influences only the choice at a restart, so a whole round is
simulated first and its positions are inserted afterwards in (step, agent) order: the same result as inserting
step by step.

Shape legend: B agents, T agent steps of a round, M starts an agent, P cached points, n new points.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from reachtest.explore.actions import action_stream, start_generator
from reachtest.explore.archive import Archive
from reachtest.explore.cache import PositionCache
from reachtest.explore.goals import GoalSet, sample_goals
from reachtest.explore.heuristics import mixture
from reachtest.explore.rollout import Trajectories, roll_out
from reachtest.explore.visits import VisitCounts
from reachtest.geometry import ColumnIndex
from reachtest.interfaces import Observer, Simulator, Surface
from reachtest.records import (
    Bools,
    Candidates,
    EndReason,
    Exploration,
    Fall,
    Floats,
    Ints,
    Level,
    Origin,
    RoundRecord,
    StopReason,
)

STARTS_PER_AGENT = 16  # drawn beforehand: at a metre a step a fall takes eight steps at the least
NO_POINT = np.full(3, np.nan)


@dataclass
class _Clock:
    began: float
    physics_s: float = 0.0
    cache_s: float = 0.0


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
        self._simulator, self._surface = simulator, surface
        self._observers, self._interrupted = observers, interrupted
        s = self._settings
        self._spawns = simulator.place(np.array([spawn.position for spawn in level.spawns]))
        self._cache = PositionCache(s.threshold_m)
        self._archive = Archive(self._spawns.shape[1])
        self._visits = VisitCounts(s.threshold_m)
        self._on_navmesh = sample_goals(level.navmesh, s.goal_spacing_m)
        self._goals = self._all_goals()
        self._eta = mixture(s.heuristics, s.power)
        self._columns = ColumnIndex(level.collision)
        self._falls: list[Fall] = []
        self._steps = self._episodes = self._diverged = self._round = 0
        self._clock = _Clock(time.monotonic())

    def run(self) -> Exploration:
        """Explore until a budget ends or the run is interrupted."""
        while (stop := self._should_stop()) is None:
            self._one_round()
        wall = time.monotonic() - self._clock.began
        physics, cache = self._clock.physics_s, self._clock.cache_s
        once, twice, cells = self._visits.incidence()
        goal_step = self._goals.reached_step
        return Exploration(
            points=self._archive.points(),
            visits=self._visits.of(self._archive.cells),
            goals=self._on_navmesh,
            goal_step=goal_step[: len(self._on_navmesh)],
            required_step=goal_step[len(self._on_navmesh) :],
            falls=tuple(self._falls),
            agent_steps=self._steps,
            episodes=self._episodes,
            diverged_episodes=self._diverged,
            cells_once=once,
            cells_twice=twice,
            cells_total=cells,
            stop_reason=stop,
            seed=self._seed,
            settings=self._settings,
            timing={"wall_s": wall, "physics_s": physics, "cache_s": cache, "rest_s": wall - physics - cache},
        )

    def _all_goals(self) -> GoalSet:
        """Goals on the nav-mesh, then the level's required points: both are worth exploring towards."""
        required = self._level.required
        places = np.array([place.position for place in required]).reshape(-1, 3)
        radii = np.array([place.within_m for place in required])
        on_mesh = np.full(len(self._on_navmesh), self._settings.goal_radius_m)
        return GoalSet(np.concatenate([self._on_navmesh, places]), np.concatenate([on_mesh, radii]))

    def _should_stop(self) -> StopReason | None:
        s = self._settings
        if self._steps >= s.steps:
            return StopReason.STEPS
        if s.time_budget_s is not None and time.monotonic() - self._clock.began >= s.time_budget_s:
            return StopReason.TIME
        return self._interrupted()

    def _one_round(self) -> None:
        s = self._settings
        length = min(s.reset_interval, -(-(s.steps - self._steps) // s.agents))
        streams = [
            action_stream(self._seed, self._round, agent, s.reset_interval)[:length]
            for agent in range(s.agents)
        ]
        parents = self._draw_starts()
        began = time.monotonic()
        rolled = roll_out(self._simulator, self._states_of(parents), np.stack(streams, axis=1))
        simulated = time.monotonic()
        new = self._record(rolled, parents)
        self._clock.physics_s += simulated - began
        self._clock.cache_s += time.monotonic() - simulated
        self._steps += length * s.agents
        self._round += 1
        self._tell(rolled, new)

    # --- starts -----------------------------------------------------------------------------------

    def _draw_starts(self) -> Ints:
        """What each agent starts from [M, B]: cached points, or -1 - i for spawn i."""
        agents, shape = self._settings.agents, (STARTS_PER_AGENT, self._settings.agents)
        spawns = len(self._spawns)
        if not len(self._archive) or self._round * agents < spawns:  # every spawn is used at least once
            return -1 - (self._round * agents + np.arange(shape[0] * agents).reshape(shape)) % spawns
        weight = self._eta(
            Candidates(
                visits=self._visits.of(self._archive.cells),
                goal_distance=self._goals.distances(self._cache.positions),
                off_mesh_m=self._archive.off_mesh_m,
                expected_within_m=self._settings.expected_within_m,
                grounded=self._archive.grounded,
            )
        )
        weight = np.where(self._archive.hopeless, 0.0, weight)
        if not weight.any():
            weight[:] = 1.0
        total = np.cumsum(weight)
        draws = start_generator(self._seed, self._round).random(shape) * total[-1]
        return np.minimum(np.searchsorted(total, draws, side="right"), len(weight) - 1)

    def _hopeless(self, positions: Floats, grounded: Bools) -> Bools:
        """Who [n] flies over nothing: the edge that was left is the better start, and is cached too."""
        below, _ = self._columns.highest(positions, np.inf, 0.0)
        return np.isnan(below) & ~grounded

    def _states_of(self, parents: Ints) -> Floats:
        spawned = parents < 0
        states = np.empty((*parents.shape, self._spawns.shape[1]))
        states[spawned] = self._spawns[-1 - parents[spawned]]
        states[~spawned] = self._archive.states[parents[~spawned]]
        return states

    # --- insertion --------------------------------------------------------------------------------

    def _record(self, rolled: Trajectories, parents: Ints) -> Ints:
        """Insert the round's positions in (step, agent) order; the indices [n, 2] (step, agent) of new points."""
        steps, agents = rolled.ended.shape
        episode = rolled.start.astype(np.int64) * agents + np.arange(agents)
        valid = np.flatnonzero(np.isfinite(rolled.positions[:, :, 0]).ravel())
        flat = rolled.positions.reshape(-1, 3)[valid]
        self._visits.add(flat, episode.ravel()[valid])
        order = valid[self._cache.insert(flat)]
        new = np.stack(np.unravel_index(order, (steps, agents)), axis=1)
        off_mesh_m = self._off_mesh(rolled, new)
        on_mesh = np.isfinite(off_mesh_m)
        self._archive_points(rolled, parents, new, off_mesh_m)
        self._goals.drain(flat, self._steps + valid + 1)
        self._note_ends(rolled, parents, on_mesh)
        return new

    def _off_mesh(self, rolled: Trajectories, new: Ints) -> Floats:
        """Distances [T, B] to the nav-mesh, infinite where unexpected; of agents that somebody will ask about.

        That is agents with new points, and agents that fell.
        """
        off_mesh_m = np.full(rolled.ended.shape, np.inf)
        fell = np.flatnonzero((rolled.ended == EndReason.FELL).any(axis=0))
        columns = np.union1d(new[:, 1], fell)
        asked = rolled.positions[:, columns].reshape(-1, 3)
        off_mesh_m[:, columns] = self._surface.distance(asked).reshape(len(off_mesh_m), len(columns))
        return off_mesh_m

    def _archive_points(self, rolled: Trajectories, parents: Ints, new: Ints, off_mesh_m: Floats) -> None:
        t, b = new[:, 0], new[:, 1]
        positions = rolled.positions[t, b]
        stood = rolled.grounded & np.isfinite(rolled.positions[:, :, 0])
        on_mesh = stood & np.isfinite(off_mesh_m)
        known = self._archive.footings, self._archive.exit_points
        pairs = new.tolist()
        footings = np.array([self._last(rolled, parents, stood, known[0], *pair) for pair in pairs])
        exits = np.array([self._last(rolled, parents, on_mesh, known[1], *pair) for pair in pairs])
        self._archive.append(
            positions=positions,
            states=rolled.states[t, b],
            grounded=rolled.grounded[t, b],
            parent=parents[rolled.which[t, b], b],
            round=np.full(len(new), self._round),
            agent=b,
            start=rolled.start[t, b],
            step=t + 1,
            off_mesh_m=off_mesh_m[t, b],
            footing=footings.reshape(-1, 3),
            exit_point=exits.reshape(-1, 3),
            cell=self._visits.cells(positions),
            hopeless=self._hopeless(positions, rolled.grounded[t, b]),
        )

    def _last(
        self, rolled: Trajectories, parents: Ints, where: Bools, archived: Floats, t: int, b: int
    ) -> Floats:
        """The last position up to (t, b) on its way for which `where` [T, B] holds.

        If there is none in its episode, what its parent has in `archived` [P, 3]; unknown at a spawn.
        """
        begin = int(rolled.start[t, b])
        hits = np.flatnonzero(where[begin : t + 1, b])
        if len(hits):
            return rolled.positions[begin + hits[-1], b]
        parent = int(parents[rolled.which[t, b], b])
        return archived[parent] if parent >= 0 else NO_POINT

    def _note_ends(self, rolled: Trajectories, parents: Ints, on_mesh: Bools) -> None:
        """Count the round's episodes and remember its falls."""
        self._episodes += rolled.ended.shape[1] + int((rolled.ended[:-1] != EndReason.ALIVE).sum())
        self._diverged += int((rolled.ended == EndReason.DIVERGED).sum())
        stood = rolled.grounded & np.isfinite(rolled.positions[:, :, 0])
        for t, b in np.argwhere(rolled.ended == EndReason.FELL).tolist():
            parent = int(parents[rolled.which[t, b], b])
            origin = Origin(parent, self._round, b, int(rolled.start[t, b]), t + 1)
            footing = self._last(rolled, parents, stood, self._archive.footings, t, b)
            if np.isnan(footing).any():  # fell before it ever stood
                footing = self._states_of(np.array([parent]))[0, :3]
            exit_point = self._last(rolled, parents, stood & on_mesh, self._archive.exit_points, t, b)
            self._falls.append(Fall(origin, rolled.last[t, b], footing, exit_point))

    def _tell(self, rolled: Trajectories, new: Ints) -> None:
        record = RoundRecord(
            round=self._round - 1,
            agent_steps=self._steps,
            sim_time_s=self._steps / self._settings.agents * self._simulator.step_s,
            trajectories=rolled.positions,
            new_points=rolled.positions[new[:, 0], new[:, 1]],
            new_expected=np.isfinite(self._archive.off_mesh_m[len(self._archive) - len(new) :]),
            points=len(self._archive),
            goals_reached=int((self._goals.reached_step[: len(self._on_navmesh)] >= 0).sum()),
            goals_total=len(self._on_navmesh),
            falls=len(self._falls),
        )
        for observer in self._observers:
            observer.on_round(record)
