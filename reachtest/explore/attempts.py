"""Attempts to get away from somewhere: episodes on purpose, entered into the transitions, with what each came by.

Shape legend: B lanes, T agent steps of an episode, n lanes that are used.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from reachtest.explore.actions import action_stream
from reachtest.explore.rollout import Trajectories, roll_out
from reachtest.explore.stays import Stays, stays_of
from reachtest.explore.transitions import Transitions
from reachtest.geometry import pack_cells
from reachtest.interfaces import Simulator
from reachtest.records import EndReason, ExploreSettings, Floats, Ints


@dataclass(frozen=True)
class Attempt:
    """The evidence of one episode."""

    cells: Ints  # packed cells of side K that it passed through
    reach_m: float


@dataclass(frozen=True)
class Front:
    """Where the lanes are: states, and where they stood or lay last."""

    states: Floats  # [n, S]
    stays: Stays  # [n]
    keys: Ints  # [n] of the cells they stood or lay in last

    @property
    def footings(self) -> Floats:
        """[n, 3]"""
        return self.stays.places


class Attempts:
    """Makes them, and keeps the evidence."""

    def __init__(
        self,
        settings: ExploreSettings,
        simulator: Simulator,
        transitions: Transitions,
        seed: int,
        first_round: int,
    ) -> None:
        self._settings, self._simulator, self._transitions = settings, simulator, transitions
        self._seed, self.round = seed, first_round
        self.episodes = self.steps = 0
        self._attempts: list[Attempt] = []
        self._began: list[int] = []  # key of the cell where each attempt began

    def run(self, front: Front, headings: Ints, jumps: Floats) -> Front:
        """One episode of each lane; where they are then."""
        count, steps = len(front.states), self._settings.reset_interval
        streams = np.zeros((steps, count, 2), dtype=np.int8)
        for lane, way in enumerate(zip(headings.tolist(), jumps.tolist(), strict=True)):
            streams[:, lane] = action_stream(self._seed, self.round, lane, steps, *way)
        self._simulator.use(count)
        rolled = roll_out(self._simulator, front.states[None], streams)
        self._simulator.use(self._simulator.agents)
        self._transitions.add(rolled, Stays(front.stays.places[None], front.stays.lying[None]))
        self.round += 1
        self.episodes += count
        self.steps += count * steps
        self._began += front.keys.tolist()
        self._attempts += [
            self._note(rolled.positions[:, lane], front.footings[lane]) for lane in range(count)
        ]
        return self._after(rolled, front)

    def of(self, keys: Ints) -> list[Attempt]:
        """Those that began in cells `keys`."""
        return [self._attempts[number] for number in np.flatnonzero(np.isin(self._began, keys))]

    def _after(self, rolled: Trajectories, front: Front) -> Front:
        """Where the lanes are at the end of an episode; who fell is where it began."""
        alive = rolled.ended[-1] == EndReason.ALIVE
        states = np.where(alive[:, None], rolled.states[-1], front.states)
        last = _last_stays(rolled, front.stays)
        footings = np.where(alive[:, None], last.places, front.footings)
        lying = np.where(alive, last.lying, front.stays.lying)
        same = (footings == front.footings).all(axis=1)
        keys = np.where(same, front.keys, self._transitions.cells(footings, lying))
        return Front(states, Stays(footings, lying), keys)

    def _note(self, positions: Floats, start: Floats) -> Attempt:
        passed = positions[np.isfinite(positions[:, 0])]
        away = np.linalg.norm(passed - start, axis=1)
        cells = np.unique(pack_cells(np.floor(passed / self._settings.threshold_m).astype(np.int64)))
        return Attempt(cells, float(away.max(initial=0.0)))


def _last_stays(rolled: Trajectories, before: Stays) -> Stays:
    """Where each lane [B] stood or lay last in the episode under way, else where it began."""
    places, lying, stays = before.places.copy(), before.lying.copy(), stays_of(rolled)
    for lane in range(len(places)):
        first = int(rolled.start[-1, lane])
        held = first + np.flatnonzero(np.isfinite(stays.places[first:, lane, 0]))
        if len(held):
            places[lane], lying[lane] = stays.places[held[-1], lane], stays.lying[held[-1], lane]
    return Stays(places, lying)
