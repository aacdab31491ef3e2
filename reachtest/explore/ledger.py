"""The ledger of a run: what the rounds brought, entered in (step, agent) order. The one writer of the cache.

Shape legend: B agents, T agent steps of a round, M starts an agent, P cached points, n new points.
"""

from __future__ import annotations

import time

import numpy as np

from reachtest.columns import ColumnIndex
from reachtest.explore.archive import Archive
from reachtest.explore.astray import Astray
from reachtest.explore.cache import PositionCache
from reachtest.explore.goals import GoalSet, sample_goals
from reachtest.explore.retrace import Retrace
from reachtest.explore.risk import RiskCurve
from reachtest.explore.rollout import Trajectories
from reachtest.explore.stays import Stays
from reachtest.explore.trails import Trails, of_parents
from reachtest.explore.transitions import Transitions
from reachtest.explore.trespass import Trespasses
from reachtest.explore.visits import VisitCounts
from reachtest.interfaces import Surface
from reachtest.records import Bools, Candidates, EndReason, Fall, Floats, Ints, Level, Origin

RADII_A_PLACE = (
    1.4  # side of the cells of transitions: at the two sides of a wall, however thin, one is in two
)


class Ledger:
    """Cached points with all that belongs to them, visits, goals and falls."""

    def __init__(self, level: Level, surface: Surface, spawns: Floats) -> None:
        """`surface` tells expected from unexpected positions; `spawns` [S, state size] are states."""
        s = level.explore
        self._settings, self._surface, self._spawns = s, surface, spawns
        self._spawn_positions = np.array([spawn.position for spawn in level.spawns])
        self.cache, self._astray = PositionCache(s.threshold_m), Astray(surface, s.expected_within_m)
        self.columns = ColumnIndex(level.collision)
        self.archive = Archive(self.cache, spawns.shape[1], s.lanes, s.reset_interval)
        self.visits = VisitCounts(s.threshold_m)
        self.risk = RiskCurve()
        place_m = min(s.threshold_m, RADII_A_PLACE * level.character.radius_m)
        self.transitions = Transitions(place_m, spawns.shape[1], Retrace.of(level.character))
        self.on_navmesh = sample_goals(level.navmesh, s.goal_spacing_m)
        self.goals = self._all_goals(level)  # on the nav-mesh, then required points
        self.falls: list[Fall] = []
        self.trespasses = Trespasses(level)
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
            above_m=self.archive.above_m,
            velocities=self.archive.velocities,
        )

    def states_of(self, parents: Ints) -> Floats:
        """The states [..., S] of cached points, or of spawn i for -1 - i."""
        return of_parents(parents, self.archive.states_of, self._spawns)

    def record(self, rolled: Trajectories, parents: Ints) -> Ints:
        """Insert the round's positions in (step, agent) order; the indices [n, 2] (step, agent) of new points."""
        steps, agents = rolled.ended.shape
        episode = rolled.start.astype(np.int64) * agents + np.arange(agents)
        valid = np.flatnonzero(np.isfinite(rolled.positions[:, :, 0]).ravel())
        flat = rolled.positions.reshape(-1, 3)[valid]
        discovering = self.visits.add(flat, episode.ravel()[valid])
        footings = of_parents(parents, self.archive.footings_of, self._spawn_positions)
        stays = Stays(footings, np.zeros(parents.shape, dtype=np.bool_))
        self.transitions.add(rolled, stays, parents, self.rounds, self.archive.stood_at(parents))
        stands, astray = rolled.grounded.ravel()[valid], rolled.stays.ravel()[valid]
        astray[astray] = self._astray(flat[astray])
        began = time.monotonic()
        order = valid[self.cache.insert(flat, stands, astray)]
        self.cache_s += time.monotonic() - began
        new = np.stack(np.unravel_index(order, (steps, agents)), axis=1)
        trails = Trails(rolled, parents, self._surface, self._spawn_positions)
        self._append(rolled, parents, new, trails)
        self.goals.drain(flat, self.steps + valid + 1)
        self._note_ends(rolled, parents, trails)
        self.trespasses.note(rolled, parents, self.rounds)
        self.steps += rolled.ended.size
        self.rounds += 1
        goals = int((self.goal_step >= 0).sum())
        self.risk.note(discovering, self.visits, self.steps, self.episodes, goals, len(self.archive))
        return new

    def _append(self, rolled: Trajectories, parents: Ints, new: Ints, trails: Trails) -> None:
        t, b = new[:, 0], new[:, 1]
        positions = rolled.positions[t, b]
        self.archive.append(
            states=rolled.states[t, b],
            grounded=rolled.grounded[t, b],
            parent=parents[rolled.which[t, b], b],
            round=np.full(len(new), self.rounds),
            agent=b,
            start=rolled.start[t, b],
            step=t + 1,
            off_mesh_m=self._surface.distance(positions),
            footing=trails.footings(t, b, self.archive.footings_of),
            exit_point=trails.exits(t, b, self.archive.exits_of),
            cell=self.visits.cells(positions),
            above_m=self._above(positions, rolled.grounded[t, b]),
        )

    def _note_ends(self, rolled: Trajectories, parents: Ints, trails: Trails) -> None:
        """Count the round's episodes and remember its falls."""
        self.episodes += rolled.ended.shape[1] + int((rolled.ended[:-1] != EndReason.ALIVE).sum())
        self.diverged += int((rolled.ended == EndReason.DIVERGED).sum())
        when, who = np.nonzero(rolled.ended == EndReason.FELL)
        stood_at = trails.footings(when, who, self.archive.footings_of)
        left_at = trails.exits(when, who, self.archive.exits_of)
        for t, b, stood, left in zip(when.tolist(), who.tolist(), stood_at, left_at, strict=True):
            parent = int(parents[rolled.which[t, b], b])
            origin = Origin(parent, self.rounds, b, int(rolled.start[t, b]), t + 1)
            self.falls.append(Fall(origin, rolled.last[t, b], stood, left))

    def _above(self, positions: Floats, grounded: Bools) -> Floats:
        """How high [n] above the floor below; infinite over nothing."""
        below, _ = self.columns.highest(positions, np.inf, 0.0)
        return np.where(grounded, 0.0, np.where(np.isnan(below), np.inf, positions[:, 2] - below))

    def _all_goals(self, level: Level) -> GoalSet:
        """Goals on the nav-mesh, then the level's required points: both are worth exploring towards."""
        required = level.required
        places = np.array([place.position for place in required]).reshape(-1, 3)
        radii = np.array([place.within_m for place in required])
        on_mesh = np.full(len(self.on_navmesh), self._settings.goal_radius_m)
        return GoalSet(np.concatenate([self.on_navmesh, places]), np.concatenate([on_mesh, radii]))
