"""One round: every agent's episode from its start, as pure simulation. Nothing of the cache is touched.

Shape legend: B agents, T agent steps of a round, M starts drawn for each agent, S state size.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from reachtest.interfaces import Simulator
from reachtest.records import Bools, EndReason, Floats


@dataclass(frozen=True)
class Trajectories:
    """What one round of all agents gave."""

    positions: Floats  # [T, B, 3]; NaN where the agent step ended the episode
    states: Floats  # [T, B, S]
    grounded: Bools  # [T, B] at the end of the step
    stood: Floats  # [T, B, 3] where the agent stood last during the step; NaN if it did not
    start: NDArray[np.int16]  # [T, B] step at which the episode under way started
    which: NDArray[np.int16]  # [T, B] which of the agent's M starts it came from
    ended: NDArray[np.int8]  # [T, B] EndReason
    last: Floats  # [T, B, 3] position after the step, also where it ended the episode

    @property
    def stays(self) -> Bools:
        """Who stood at the end of the step before, too [T, B]: who just comes down is in the floor, and lower."""
        result = np.zeros_like(self.grounded)
        result[1:] = self.grounded[1:] & self.grounded[:-1] & (self.start[1:] == self.start[:-1])
        return result


def roll_out(simulator: Simulator, starts: Floats, actions: NDArray[np.int8]) -> Trajectories:
    """Simulate `actions` [T, B, 2] from the first of `starts` [M, B, S].

    An agent whose episode ends early goes on from the next of its starts, so nothing depends on timing.
    """
    steps, agents = actions.shape[:2]
    everyone = np.arange(agents)
    simulator.restore(everyone, starts[0])
    which = np.zeros(agents, dtype=np.int16)
    start = np.zeros(agents, dtype=np.int16)
    result = Trajectories(
        np.full((steps, agents, 3), np.nan),
        np.zeros((steps, agents, starts.shape[2])),
        np.zeros((steps, agents), dtype=np.bool_),
        np.full((steps, agents, 3), np.nan),
        np.zeros((steps, agents), dtype=np.int16),
        np.zeros((steps, agents), dtype=np.int16),
        np.zeros((steps, agents), dtype=np.int8),
        np.zeros((steps, agents, 3)),
    )
    for t in range(steps):
        outcome = simulator.step(actions[t])
        alive = outcome.ended == EndReason.ALIVE
        result.positions[t, alive] = outcome.positions[alive]
        result.last[t] = outcome.positions
        result.states[t] = simulator.save()
        result.grounded[t], result.stood[t] = outcome.grounded, outcome.stood
        result.start[t], result.which[t], result.ended[t] = start, which, outcome.ended
        over = everyone[~alive]
        if len(over):
            which[over] = (which[over] + 1) % len(starts)
            start[over] = t + 1
            simulator.restore(over, starts[which[over], over])
    return result
