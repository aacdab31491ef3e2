"""Short simulations from given states, side by side: scripts of actions, or characters that follow a route.

Shape legend: n lanes, k of them under way, t agent steps so far, S state size.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from reachtest.confirm.pursuit import Pursuers, Pursuit
from reachtest.interfaces import Simulator
from reachtest.records import Bools, EndReason, Floats, Ints

Actions = NDArray[np.int8]  # [t, 2]
Plan = Actions | Pursuit
LOOK_STEPS = 8  # between two looks at what has come of lanes: looking costs as much as a step


@dataclass(frozen=True)
class Lane:
    """One simulation to be made."""

    state: Floats  # [S] where it starts
    plan: Plan
    steps: int  # at most


@dataclass(frozen=True)
class Trial:
    """One simulation as far as it got: until it left the world or its steps were used up."""

    start: Floats  # [S]
    actions: Actions  # [t, 2]
    states: Floats  # [t, S] after every step
    stood: Floats  # [t, 3] where it stood last during the step; NaN if it did not
    fell: bool  # in the last step

    @property
    def positions(self) -> Floats:
        """[t, 3]"""
        return self.states[:, :3]

    def __len__(self) -> int:
        return len(self.actions)


class Trials:
    """Lanes on one simulator: as some end, others begin in their places; an empty place costs nothing.

    The longest begin first, so that in the end few are alone. What becomes of a lane does not depend on the others.
    """

    def __init__(self, simulator: Simulator, lanes: Sequence[Lane]) -> None:
        self._simulator, self._lanes, n = simulator, lanes, len(lanes)
        steps = np.array([lane.steps for lane in lanes], dtype=np.int64)
        self._limit, self._length = steps.copy(), np.zeros(n, dtype=np.int64)
        self._ended = np.zeros(n, dtype=np.int8)
        self._running = np.zeros(0, dtype=np.int64)  # [k] the lane of each agent in use
        self._waiting = sorted(range(n), key=lambda i: -lanes[i].steps)
        # One row for every step of every lane, a lane's after each other.
        self._row = np.concatenate([[0], np.cumsum(steps)])
        self._here = np.array([lane.state for lane in lanes])
        self._actions = np.zeros((self._row[-1], 2), dtype=np.int8)
        self._states = np.empty((self._row[-1], self._here.shape[-1]))
        self._stood = np.empty((self._row[-1], 3))
        self._follows = np.array([isinstance(lane.plan, Pursuit) for lane in lanes], dtype=np.bool_)
        self._pursuer = np.cumsum(self._follows) - 1
        self._pursuers = Pursuers([lane.plan for lane in lanes if isinstance(lane.plan, Pursuit)])
        for i, lane in enumerate(lanes):
            if not isinstance(lane.plan, Pursuit):
                script = lane.plan[: lane.steps]
                self._actions[self._row[i] : self._row[i] + len(script)] = script

    def advance(self, steps: int) -> bool:
        """Go on for `steps` agent steps; False once nothing is left to do."""
        for _ in range(steps):
            self._seat()
            if not len(self._running):
                self._simulator.use(self._simulator.agents)
                return False
            self._one_step()
        return True

    def limit(self, lane: int, steps: int) -> None:
        """End a lane after `steps` at most."""
        self._limit[lane] = min(int(self._limit[lane]), steps)

    def length(self, lane: int) -> int:
        """The steps t that a lane has gone."""
        return int(self._length[lane])

    def trial(self, lane: int) -> Trial:
        """What became of a lane so far."""
        begin = int(self._row[lane])
        rows = slice(begin, begin + self.length(lane))
        return Trial(
            self._lanes[lane].state,
            self._actions[rows].copy(),
            self._states[rows].copy(),
            self._stood[rows].copy(),
            bool(self._ended[lane] == EndReason.FELL),
        )

    def _goes_on(self, lanes: Ints) -> Bools:
        alive = self._ended[lanes] == EndReason.ALIVE
        return np.asarray(alive & (self._length[lanes] < self._limit[lanes]), dtype=np.bool_)

    def _seat(self) -> None:
        """Fill the places of lanes that ended: with those that wait, then with those on the last places."""
        stays = self._goes_on(self._running)
        self._waiting = [lane for lane in self._waiting if self._limit[lane] > 0]
        seats = min(int(stays.sum()) + len(self._waiting), self._simulator.agents)
        if stays.all() and seats == len(self._running):
            return
        seated = np.full(seats, -1, dtype=np.int64)
        kept = np.flatnonzero(stays[:seats])
        seated[kept] = self._running[kept]
        free = np.flatnonzero(seated < 0)
        movers = self._running[seats:][stays[seats:]].tolist()
        more = len(free) - len(movers)
        seated[free] = movers + self._waiting[:more]
        self._running, self._waiting = seated, self._waiting[more:]
        if seats:
            self._simulator.use(seats)
            if len(free):
                self._simulator.restore(free, self._here[seated[free]])

    def _one_step(self) -> None:
        lanes = self._running
        now = self._length[lanes]
        rows = self._row[lanes] + now
        chasing = np.flatnonzero(self._follows[lanes])
        if len(chasing):
            which = lanes[chasing]
            self._actions[rows[chasing]] = self._pursuers.actions(
                self._pursuer[which], self._here[which, :3], now[chasing]
            )
        outcome = self._simulator.step(self._actions[rows])
        self._here[lanes] = self._states[rows] = self._simulator.save()
        self._stood[rows], self._ended[lanes] = outcome.stood, outcome.ended
        self._length[lanes] += 1


def run_lanes(
    simulator: Simulator, lanes: Sequence[Lane], pause: Callable[[], None] = lambda: None
) -> list[Trial]:
    """All of `lanes` to their ends, as many at once as the simulator has agents; `pause` is called now and then."""
    trials = Trials(simulator, lanes)
    while trials.advance(LOOK_STEPS):
        pause()
    return [trials.trial(i) for i in range(len(lanes))]
