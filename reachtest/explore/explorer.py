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
from numpy.typing import NDArray

from reachtest.explore.actions import action_stream
from reachtest.explore.directed import directed
from reachtest.explore.ledger import Ledger
from reachtest.explore.probe import Probed, Prober
from reachtest.explore.replay import Replayer
from reachtest.explore.restarts import Restarts
from reachtest.explore.risk import is_done
from reachtest.explore.rollout import Trajectories, roll_out
from reachtest.interfaces import Observer, Simulator, Surface, Teller
from reachtest.navmesh.coverage import GoalIslands, goal_islands
from reachtest.navmesh.islands import Islands
from reachtest.records import Bools, Exploration, Ints, Level, Points, RoundRecord, StopReason


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
        islands: Islands | None = None,
        tell: Teller = lambda what, number, total: None,
    ) -> None:
        """`surface` tells expected from unexpected positions; `interrupted` is asked after every round.

        `islands` are those of the level's nav-mesh, where they were worked out before. `tell` hears of the probes.
        """
        self._level, self._settings, self._seed = level, level.explore, seed
        self._simulator = simulator
        self._observers, self._interrupted, self._tell_of_probes = observers, interrupted, tell
        spawns = simulator.place(np.array([spawn.position for spawn in level.spawns]))
        self._ledger = Ledger(level, surface, spawns)
        self._islands = islands or Islands(level.navmesh)
        starts = np.array([spawn.position for spawn in level.spawns])
        on = goal_islands(self._islands, starts, self._ledger.goals.goals)
        self._wanted, self._required_connected = self._worth(on)
        self._directed = directed(
            level, self._ledger.columns, self._ledger.goals, self._wanted, self._islands, on
        )
        self._restarts = Restarts(level, self._directed, seed)
        self._headings: list[NDArray[np.int16]] = []
        self._began, self._physics_s = time.monotonic(), 0.0

    def run(self) -> Exploration:
        """Explore until a budget ends or the run is interrupted; then look for pockets, unless somebody waits."""
        while (stop := self._should_stop()) is None:
            self._one_round()
        explored = time.monotonic()
        points, probed = self._ledger.archive.points(), Probed((), 0, 0)
        if stop not in (StopReason.INTERRUPTED, StopReason.TERMINATED):
            probed = self._probe(points)
            stop = self._interrupted() or stop
        wall, probe = explored - self._began, time.monotonic() - explored
        physics, cache = self._physics_s, self._ledger.cache_s
        timing = {
            "wall_s": wall,  # of the exploration: probes are not counted in its steps either
            "physics_s": physics,
            "cache_s": cache,
            "rest_s": wall - physics - cache,
            "probe_s": probe,
        }
        return self._exploration(points, probed, stop, timing)

    def _exploration(
        self, points: Points, probed: Probed, stop: StopReason, timing: dict[str, float]
    ) -> Exploration:
        ledger, aims = self._ledger, self._directed.aims
        count = len(ledger.on_navmesh)
        once, twice, cells = ledger.visits.incidence()
        border, pushes = self._directed.borders.effort()
        return Exploration(
            points=points,
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
            headings=self._round_headings(),
            goal_attempts=aims.attempts()[:count],
            goal_border_m=aims.border_m[:count],
            required_attempts=aims.attempts_at_parts()[count:],
            required_connected=self._required_connected,
            trespasses=ledger.trespasses.found,
            pockets=probed.pockets,
            probe_episodes=probed.episodes,
            probe_steps=probed.steps,
            risk_curve=ledger.risk.samples,
            border=border,
            border_pushes=pushes,
            timing=timing,
        )

    def _round_headings(self) -> NDArray[np.int16]:
        """The headings of all lanes in all rounds [rounds, lanes]."""
        return np.array(self._headings, dtype=np.int16).reshape(-1, self._settings.lanes)

    def _probe(self, points: Points) -> Probed:
        """Look for pockets."""
        replayer = Replayer(self._level, self._simulator, points, self._seed, self._round_headings())
        known, number = self._ledger.transitions, self._ledger.rounds
        prober = Prober(self._level, self._simulator, known, replayer, self._seed, number)
        return prober.run(points, self._islands, self._is_interrupted, self._tell_of_probes)

    def _is_interrupted(self) -> bool:
        return self._interrupted() is not None

    @property
    def bytes_per_point(self) -> float:
        """What a cached point takes outside the tree."""
        return self._ledger.archive.bytes_per_point

    def _worth(self, on: GoalIslands) -> tuple[Bools, Bools]:
        """The goals [G] that somebody should be able to get to: not those on the roofs, but all required points;
        and which required points [R] the nav-mesh connects to a spawn."""
        count = len(self._ledger.on_navmesh)
        worth = on.goals_count
        worth[count:] = True
        island = on.goal_island[count:]
        return worth, (island >= 0) & on.connected[island]

    def _should_stop(self) -> StopReason | None:
        s = self._settings
        if self._ledger.steps >= s.steps:
            return StopReason.STEPS
        if s.time_budget_s is not None and time.monotonic() - self._began >= s.time_budget_s:
            return StopReason.TIME
        reached, latest = self._ledger.goals.reached_step, self._ledger.risk.latest
        if s.stop_when_done and is_done(self._level.gate, reached, self._wanted, latest):
            return StopReason.DONE
        return self._interrupted()

    def _one_round(self) -> None:
        s = self._settings
        number = self._ledger.rounds
        length = min(s.reset_interval, -(-(s.steps - self._ledger.steps) // s.lanes))
        parents, headings = self._restarts.draw(self._ledger)
        self._headings.append(headings)
        streams = [
            action_stream(self._seed, number, lane, s.reset_interval, heading)[:length]
            for lane, heading in enumerate(headings.tolist())
        ]
        actions = np.stack(streams, axis=1)
        began = time.monotonic()
        rolled = roll_out(self._simulator, self._ledger.states_of(parents), actions)
        self._physics_s += time.monotonic() - began
        new = self._ledger.record(rolled, parents)
        self._directed.borders.note(rolled.positions, actions[:, :, 0])
        self._tell(rolled, new)

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
            discovery_share=ledger.risk.latest.recent_share,
        )
        for observer in self._observers:
            observer.on_round(record)
