"""Short simulations from given states, side by side: scripts of actions, or characters that follow a route.

Shape legend: n lanes, t agent steps so far, S state size.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from reachtest.explore.pursuit import Pursuers, Pursuit
from reachtest.interfaces import Simulator
from reachtest.records import Bools, EndReason, Floats

Actions = NDArray[np.int8]  # [t, 2]
Plan = Actions | Pursuit


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


class TrialBatch:
    """As many lanes as the simulator has agents, at most; advanced a few steps at a time."""

    def __init__(self, simulator: Simulator, lanes: Sequence[Lane]) -> None:
        self._simulator, self._lanes, n = simulator, lanes, len(lanes)
        simulator.restore(np.arange(n), np.array([lane.state for lane in lanes]))
        most, size = max(lane.steps for lane in lanes), len(lanes[0].state)
        self._most, self._now = most, 0
        self._scripts = np.zeros((most, simulator.agents, 2), dtype=np.int8)
        self._chasing = [i for i, lane in enumerate(lanes) if isinstance(lane.plan, Pursuit)]
        self._pursuers = Pursuers([lane.plan for lane in lanes if isinstance(lane.plan, Pursuit)], most)
        for i, lane in enumerate(lanes):
            if not isinstance(lane.plan, Pursuit):
                count = min(len(lane.plan), lane.steps)
                self._scripts[:count, i] = lane.plan[:count]
        self._states = np.empty((most, n, size))
        self._stood = np.empty((most, n, 3))
        self._here = np.array([lane.state for lane in lanes])
        self._length = np.zeros(n, dtype=np.int64)
        self._ended = np.zeros(n, dtype=np.int8)

    @property
    def over(self) -> bool:
        """Whether no lane has anything left to do."""
        return self._now >= self._most or not self._active().any()

    def advance(self, steps: int) -> None:
        """Go on for `steps` agent steps, or until all is over."""
        for _ in range(steps):
            if self.over:
                return
            self._one_step()

    def trial(self, lane: int) -> Trial:
        """What became of a lane so far."""
        t = int(self._length[lane])
        return Trial(
            self._lanes[lane].state,
            self._scripts[:t, lane].copy(),
            self._states[:t, lane].copy(),
            self._stood[:t, lane].copy(),
            bool(self._ended[lane] == EndReason.FELL),
        )

    def _active(self) -> Bools:
        steps = np.array([lane.steps for lane in self._lanes])
        return np.asarray((self._ended == EndReason.ALIVE) & (self._length < steps), dtype=np.bool_)

    def _one_step(self) -> None:
        t, n, active = self._now, len(self._lanes), self._active()
        if self._chasing:
            self._scripts[t, self._chasing] = self._pursuers.actions(self._here[self._chasing, :3], t)
        outcome = self._simulator.step(self._scripts[t])
        self._here = self._states[t] = self._simulator.save()[:n]
        self._stood[t] = outcome.stood[:n]
        self._ended[active] = outcome.ended[:n][active]
        self._length[active] += 1
        self._now += 1


def run_lanes(simulator: Simulator, lanes: Sequence[Lane]) -> list[Trial]:
    """All of `lanes` to their ends, as many at once as the simulator has agents."""
    order = sorted(range(len(lanes)), key=lambda i: lanes[i].steps)  # of a length together
    trials: dict[int, Trial] = {}
    for begin in range(0, len(order), simulator.agents):
        some = order[begin : begin + simulator.agents]
        batch = TrialBatch(simulator, [lanes[i] for i in some])
        batch.advance(max(lanes[i].steps for i in some))
        trials |= {i: batch.trial(row) for row, i in enumerate(some)}
    return [trials[i] for i in range(len(lanes))]
