"""Re-simulation: any episode from its start state, round and agent; any point through the episodes that led to it.

Shape legend: B agents, n agent steps of an episode, S state size.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from reachtest.errors import InternalError
from reachtest.explore.actions import action_stream
from reachtest.interfaces import Simulator
from reachtest.records import Fall, Floats, Level, Origin, Points, ReplayPath

CHECKED_POINTS = 32  # of every run are re-simulated: enough to notice a simulator that does not restore


@dataclass(frozen=True)
class Episode:
    """One re-simulated episode."""

    states: Floats  # [n, S] after every step
    stood: Floats  # [n, 3]

    @property
    def state(self) -> Floats:
        """At its end [S]."""
        return self.states[-1]


class Replayer:
    """Meets `interfaces.Replayer` for the points of one exploration."""

    def __init__(
        self,
        level: Level,
        simulator: Simulator,
        points: Points,
        seed: int,
        headings: NDArray[np.int16] | None = None,
    ) -> None:
        """`headings` [rounds, lanes] of the directed lanes; None: there were none."""
        self._simulator, self._points, self._seed, self._headings = simulator, points, seed, headings
        self._spawns = simulator.place(np.array([spawn.position for spawn in level.spawns]))
        self._interval = level.explore.reset_interval
        self._done: dict[Origin, Episode] = {}

    def path_to_point(self, index: int) -> ReplayPath:
        """The way from a spawn to cached point `index`; succeeded if its state came out bit for bit."""
        return self._path(self._points.origin(index), self._points.states[index])

    def path_to_fall(self, fall: Fall) -> ReplayPath:
        """The way from a spawn out of the world; succeeded if it fell at the same place, bit for bit."""
        return self._path(fall.origin, fall.position)

    def flights(self, falls: Sequence[Fall]) -> list[Floats]:
        """Where each of `falls` [m] went [n, 3] from where it stood last, as far as its last episode tells."""
        flights = []
        for fall, episode in zip(falls, self.simulate([fall.origin for fall in falls]), strict=True):
            stood = np.flatnonzero(np.isfinite(episode.stood[:, 0]))
            since = int(stood[-1]) + 1 if len(stood) else 0
            flights.append(np.concatenate([fall.footing[None], episode.states[since:, :3]]))
        return flights

    def check(self) -> None:
        """Re-simulate a sample of the cached points.

        Raises InternalError when a restored state did not lead to what the cache claims.
        """
        count = len(self._points)
        sample = np.unique(np.linspace(0, count - 1, min(CHECKED_POINTS, count)).astype(int)).tolist()
        episodes = self.simulate([self._points.origin(i) for i in sample])
        wrong = [i for i, e in zip(sample, episodes, strict=True) if not _same(e, self._points.states[i])]
        if wrong:
            raise InternalError(
                f"{len(wrong)} of {len(sample)} re-simulated points did not come out bit for bit (first: point"
                f" {wrong[0]} at {self._points.positions[wrong[0]].round(2).tolist()}); the simulator does not"
                " restore its states"
            )

    def actions_of(self, origin: Origin) -> NDArray[np.int8]:
        """The actions [n, 2] of the episode that led to `origin`."""
        heading = 0 if self._headings is None else int(self._headings[origin.round, origin.agent])
        stream = action_stream(self._seed, origin.round, origin.agent, self._interval, heading)
        return stream[origin.start : origin.step]

    def states_at(self, origins: Sequence[Origin]) -> Floats:
        """The states [n, S] that `origins` [n] led to, their starts where nothing was done yet."""
        moved = [origin for origin in origins if origin.step > origin.start]
        ends = dict(zip(moved, self.simulate(moved), strict=True))
        return np.array([ends[o].state if o in ends else self._start_state(o.parent) for o in origins])

    def simulate(self, origins: Sequence[Origin]) -> list[Episode]:
        """Run the episodes, as many at once as the simulator has agents."""
        todo = [origin for origin in dict.fromkeys(origins) if origin not in self._done]
        todo.sort(key=lambda origin: origin.step - origin.start)  # episodes of a length together
        agents = self._simulator.agents
        for begin in range(0, len(todo), agents):
            self._simulate_together(todo[begin : begin + agents])
        return [self._done[origin] for origin in origins]

    def _simulate_together(self, origins: Sequence[Origin]) -> None:
        length = [origin.step - origin.start for origin in origins]
        actions = np.zeros((max(length), len(origins), 2), dtype=np.int8)
        for lane, origin in enumerate(origins):
            actions[: length[lane], lane] = self.actions_of(origin)
        starts = np.array([self._start_state(origin.parent) for origin in origins])
        self._simulator.use(len(origins))
        self._simulator.restore(np.arange(len(origins)), starts)
        states = np.empty((max(length), *starts.shape))
        stood = np.empty((max(length), len(origins), 3))
        for t in range(max(length)):
            stood[t] = self._simulator.step(actions[t]).stood
            states[t] = self._simulator.save()
        self._simulator.use(self._simulator.agents)
        for lane, (origin, steps) in enumerate(zip(origins, length, strict=True)):
            self._done[origin] = Episode(states[:steps, lane].copy(), stood[:steps, lane].copy())

    def _start_state(self, parent: int) -> Floats:
        return self._spawns[-1 - parent] if parent < 0 else self._points.states[parent]

    def _chain(self, origin: Origin) -> list[Origin]:
        chain = [origin]
        while chain[-1].parent >= 0:
            chain.append(self._points.origin(chain[-1].parent))
        return chain[::-1]

    def _path(self, origin: Origin, end: Floats) -> ReplayPath:
        chain = self._chain(origin)
        episodes = self.simulate(chain)
        targets = [self._points.states[later.parent] for later in chain[1:]] + [end]
        good = all(_same(episode, target) for episode, target in zip(episodes, targets, strict=True))
        states = np.concatenate([episode.states for episode in episodes])
        state = self._start_state(chain[0].parent)
        return ReplayPath(
            start=state[:3],
            episodes=tuple(chain),
            positions=states[:, :3],
            duration_s=len(states) * self._simulator.step_s,
            attempts=1,
            succeeded=int(good),
            state=state,
            actions=np.concatenate([self.actions_of(episode) for episode in chain]),
            states=states,
            stood=np.concatenate([episode.stood for episode in episodes]),
        )


def _same(episode: Episode, target: Floats) -> bool:
    """Whether the episode's end equals a state [S], or a position [3], to the last bit."""
    return bool((episode.state[: len(target)] == target).all())
