"""The ledger of a run: what the rounds brought, entered in (step, agent) order. The one writer of the cache.

Shape legend: B agents, T agent steps of a round, M starts an agent, P cached points, n new points.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from reachtest.explore.archive import Archive
from reachtest.explore.cache import PositionCache
from reachtest.explore.goals import GoalSet, sample_goals
from reachtest.explore.risk import RiskCurve
from reachtest.explore.rollout import Trajectories
from reachtest.explore.transitions import Transitions
from reachtest.explore.visits import VisitCounts
from reachtest.geometry import ColumnIndex
from reachtest.interfaces import Surface
from reachtest.records import Bools, Candidates, EndReason, Fall, Floats, Ints, Level, Origin


@dataclass(frozen=True)
class _Trail:
    """A kind of position to look back for: in the episode under way, else at its parent, else at its spawn."""

    positions: Floats  # [T, B, 3] NaN where there is none
    archived: Callable[[Ints], Floats]  # of cached points [n]: [n, 3]
    spawned: Floats  # [S, 3]

    @cached_property
    def latest(self) -> Ints:
        """The last step [T, B] with a position, up to each step; -1 before the first."""
        steps = np.arange(len(self.positions))[:, None]
        return np.maximum.accumulate(np.where(np.isfinite(self.positions[:, :, 0]), steps, -1), axis=0)

    def at(self, rolled: Trajectories, parents: Ints, t: Ints, b: Ints) -> Floats:
        """The last positions [n, 3] on the way to steps t [n] of lanes b [n], those included."""
        step = self.latest[t, b]
        during = step >= rolled.start[t, b]
        result = np.empty((len(t), 3))
        result[during] = self.positions[step[during], b[during]]
        before = ~during
        result[before] = _of(parents[rolled.which[t, b], b][before], self.archived, self.spawned)
        return result


def _of(parents: Ints, archived: Callable[[Ints], Floats], spawned: Floats) -> Floats:
    """Rows [..., k] of `parents`: of cached points, or of spawn i [S, k] for -1 - i."""
    at_spawn = parents < 0
    result = np.empty((*parents.shape, spawned.shape[1]))
    result[at_spawn] = spawned[-1 - parents[at_spawn]]
    result[~at_spawn] = archived(parents[~at_spawn])
    return result


class Ledger:
    """Cached points with all that belongs to them, visits, goals and falls."""

    def __init__(self, level: Level, surface: Surface, spawns: Floats) -> None:
        """`surface` tells expected from unexpected positions; `spawns` [S, state size] are states."""
        s = level.explore
        self._settings, self._surface, self._spawns = s, surface, spawns
        self._spawn_positions = np.array([spawn.position for spawn in level.spawns])
        self.cache = PositionCache(s.threshold_m)
        self._columns = ColumnIndex(level.collision)
        self.archive = Archive(self.cache, spawns.shape[1], s.lanes, s.reset_interval)
        self.visits = VisitCounts(s.threshold_m)
        self.risk = RiskCurve()
        self.transitions = Transitions(s.threshold_m)
        self.on_navmesh = sample_goals(level.navmesh, s.goal_spacing_m)
        self.goals = self._all_goals(level)  # on the nav-mesh, then required points
        self.falls: list[Fall] = []
        self.cache_s = 0.0  # wall-clock time in the cache
        self.rounds = self.steps = self.episodes = self.diverged = 0

    @property
    def goal_step(self) -> Ints:
        """Agent step at which each nav-mesh goal [G] was reached; -1 where it was not."""
        return self.goals.reached_step[: len(self.on_navmesh)]

    @property
    def required_step(self) -> Ints:
        """Likewise for the level's required points [R]."""
        return self.goals.reached_step[len(self.on_navmesh) :]

    def candidates(self) -> Candidates:
        """What the reset heuristics may know of the cached points."""
        return Candidates(
            visits=self.visits.of(self.archive.cells),
            goal_distance=self.goals.distances(self.cache.positions),
            off_mesh_m=self.archive.off_mesh_m,
            expected_within_m=self._settings.expected_within_m,
            grounded=self.archive.grounded,
        )

    def states_of(self, parents: Ints) -> Floats:
        """The states [..., S] of cached points, or of spawn i for -1 - i."""
        return _of(parents, self.archive.states_of, self._spawns)

    def record(self, rolled: Trajectories, parents: Ints) -> Ints:
        """Insert the round's positions in (step, agent) order; the indices [n, 2] (step, agent) of new points."""
        steps, agents = rolled.ended.shape
        episode = rolled.start.astype(np.int64) * agents + np.arange(agents)
        valid = np.flatnonzero(np.isfinite(rolled.positions[:, :, 0]).ravel())
        flat = rolled.positions.reshape(-1, 3)[valid]
        discovering = self.visits.add(flat, episode.ravel()[valid])
        footings = _of(parents, self.archive.footings_of, self._spawn_positions)
        self.transitions.add(rolled, footings, parents, self.rounds)
        began = time.monotonic()
        order = valid[self.cache.insert(flat)]
        self.cache_s += time.monotonic() - began
        new = np.stack(np.unravel_index(order, (steps, agents)), axis=1)
        trails = self._trails(rolled, new)
        self._append(rolled, parents, new, trails)
        self.goals.drain(flat, self.steps + valid + 1)
        self._note_ends(rolled, parents, trails)
        self.steps += rolled.ended.size
        self.rounds += 1
        goals = int((self.goal_step >= 0).sum())
        self.risk.note(discovering, self.visits, self.steps, self.episodes, goals, len(self.archive))
        return new

    def _distances(self, points: Floats, columns: Ints) -> Floats:
        """Distances [T, B] of points [T, B, 3] to the nav-mesh, infinite where unexpected and in other columns."""
        result = np.full(points.shape[:2], np.inf)
        asked = points[:, columns].reshape(-1, 3)
        result[:, columns] = self._surface.distance(asked).reshape(len(result), len(columns))
        return result

    def _append(self, rolled: Trajectories, parents: Ints, new: Ints, trails: tuple[_Trail, _Trail]) -> None:
        t, b = new[:, 0], new[:, 1]
        positions = rolled.positions[t, b]
        footings, exits = (trail.at(rolled, parents, t, b) for trail in trails)
        self.archive.append(
            states=rolled.states[t, b],
            grounded=rolled.grounded[t, b],
            parent=parents[rolled.which[t, b], b],
            round=np.full(len(new), self.rounds),
            agent=b,
            start=rolled.start[t, b],
            step=t + 1,
            off_mesh_m=self._surface.distance(positions),
            footing=footings,
            exit_point=exits,
            cell=self.visits.cells(positions),
            hopeless=self._hopeless(positions, rolled.grounded[t, b]),
        )

    def _trails(self, rolled: Trajectories, new: Ints) -> tuple[_Trail, _Trail]:
        """Where the characters stood, and where they stood on the nav-mesh; of those with new points or a fall."""
        fell = np.flatnonzero((rolled.ended == EndReason.FELL).any(axis=0))
        on_mesh = np.isfinite(self._distances(rolled.stood, np.union1d(new[:, 1], fell)))
        unknown = np.full_like(self._spawn_positions, np.nan)
        return (
            _Trail(rolled.stood, self.archive.footings_of, self._spawn_positions),
            _Trail(np.where(on_mesh[:, :, None], rolled.stood, np.nan), self.archive.exits_of, unknown),
        )

    def _note_ends(self, rolled: Trajectories, parents: Ints, trails: tuple[_Trail, _Trail]) -> None:
        """Count the round's episodes and remember its falls."""
        self.episodes += rolled.ended.shape[1] + int((rolled.ended[:-1] != EndReason.ALIVE).sum())
        self.diverged += int((rolled.ended == EndReason.DIVERGED).sum())
        when, who = np.nonzero(rolled.ended == EndReason.FELL)
        ways = [trail.at(rolled, parents, when, who) for trail in trails]
        for t, b, stood, left in zip(when.tolist(), who.tolist(), *ways, strict=True):
            parent = int(parents[rolled.which[t, b], b])
            origin = Origin(parent, self.rounds, b, int(rolled.start[t, b]), t + 1)
            self.falls.append(Fall(origin, rolled.last[t, b], stood, left))

    def _hopeless(self, positions: Floats, grounded: Bools) -> Bools:
        """Who [n] flies over nothing: the edge that was left is the better start, and is cached too."""
        below, _ = self._columns.highest(positions, np.inf, 0.0)
        return np.isnan(below) & ~grounded

    def _all_goals(self, level: Level) -> GoalSet:
        """Goals on the nav-mesh, then the level's required points: both are worth exploring towards."""
        required = level.required
        places = np.array([place.position for place in required]).reshape(-1, 3)
        radii = np.array([place.within_m for place in required])
        on_mesh = np.full(len(self.on_navmesh), self._settings.goal_radius_m)
        return GoalSet(np.concatenate([self.on_navmesh, places]), np.concatenate([on_mesh, radii]))
