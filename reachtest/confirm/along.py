"""A small search at another time step along a found way: what came nearest to it is gone on from.

A script of actions drifts off, and whoever follows a way from its beginning has to get every part of it right in one
go. Here, as in Go-Explore (Ecoffet et al., Nature 590, 2021), each state that is like one of the found way is kept,
and attempts go on from the best of them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from reachtest.confirm.outcome import Judge
from reachtest.confirm.shorten import Way, first_steps, joined, pursuits
from reachtest.confirm.trials import Lane, Trial, run_lanes
from reachtest.confirm.variation import vary
from reachtest.interfaces import Simulator
from reachtest.records import Floats

ROUNDS = 12
LANES = 64  # a round
MOST_STEPS = 250_000  # of a finding [agent steps]: about 15 s
KEPT = 4  # states for each step of the way: more than one, for one may be stuck
NEAR_M = 1.5  # of a found state, as states differ (see `_Archive.add`), or it is none of the way
FRONT = 6  # steps of the way that half of the lanes go on from: the last that were reached
PURSUITS = 32  # to choose from
SPARE_STEPS = 8  # more than the rest of the way has


@dataclass(frozen=True)
class _Kept:
    """A trial as far as a state like a found one."""

    trial: Trial
    steps: int
    off_m: float

    @property
    def state(self) -> Floats:
        return self.trial.states[self.steps - 1] if self.steps else self.trial.start


class _Archive:
    """What came nearest to each state of a way."""

    def __init__(self, way: Way, step_s: float) -> None:
        states = np.concatenate([way.start[None], way.trial.states])
        self._scale = np.repeat([1.0, step_s], 3)
        self._found = states[:, :6] * self._scale  # [t + 1, 6]
        self._kept: dict[int, list[_Kept]] = {0: [_Kept(first_steps(way.trial, 0), 0, 0.0)]}

    def add(self, trial: Trial, since: int) -> None:
        """Keep what is good of a trial's states from step `since` on.

        States differ by their distance [m] and by how far their velocities take them apart in a step.
        """
        states = trial.states[since:, :6] * self._scale
        off = np.linalg.norm(states[:, None] - self._found[None, 1:], axis=2)
        like = off.argmin(axis=1)
        for row in np.flatnonzero(off.min(axis=1) < NEAR_M).tolist():
            step = int(like[row])
            kept = self._kept.setdefault(step + 1, [])
            kept.append(_Kept(trial, since + row + 1, float(off[row, step])))
            kept.sort(key=lambda one: one.off_m)
            del kept[KEPT:]

    def draw(self, rng: np.random.Generator) -> list[tuple[int, _Kept]]:
        """`LANES` states to go on from, each with its step of the way: half of them where it was last reached."""
        steps = sorted(step for step in self._kept if step < len(self._found) - 1)
        drawn = [*rng.choice(steps[-FRONT:], LANES // 2), *rng.choice(steps, LANES - LANES // 2)]
        return [(int(step), self._one(int(step), rng)) for step in drawn]

    def _one(self, step: int, rng: np.random.Generator) -> _Kept:
        kept = self._kept[step]
        return kept[int(rng.integers(len(kept)))]


def search_along(
    way: Way,
    simulator: Simulator,
    judge: Judge,
    rng: np.random.Generator,
    times: int,
    most_steps: int,
    pause: Callable[[], None],
) -> tuple[int, Trial | None]:
    """The attempts, and the first of them that came to the outcome of `way`, if one did.

    It begins anew up to `times`, for what was kept early may lead nowhere, in `most_steps` agent steps or so.
    `pause` is called now and then.
    """
    attempts = 0
    rounds = max(min(most_steps, MOST_STEPS) // (LANES * len(way.trial)), int(most_steps > 0))
    for number in range(min(times * ROUNDS, rounds)):
        if number % ROUNDS == 0:
            archive = _Archive(way, simulator.step_s)
        drawn = archive.draw(rng)
        lanes = [_lane(way, *one, script=row % 2 == 0, rng=rng) for row, one in enumerate(drawn)]
        for (_, kept), rest in zip(drawn, run_lanes(simulator, lanes, pause), strict=True):
            whole = joined(first_steps(kept.trial, kept.steps), rest)
            attempts += 1
            step = judge.step(way.outcome, whole, kept.steps)
            if step is not None:
                return attempts, first_steps(whole, step + 1)
            archive.add(whole, kept.steps)
    return attempts, None


def _lane(way: Way, step: int, kept: _Kept, script: bool, rng: np.random.Generator) -> Lane:
    """From a state like that after `step` of the way, by a script around the rest of it or along its route."""
    found, state = way.trial, kept.state
    rest = Trial(state, found.actions[step:], found.states[step:], found.stood[step:], found.fell)
    steps = len(rest) * 5 // 4 + SPARE_STEPS
    if script:
        return Lane(state, vary(rest.actions, steps, rng), steps)
    return Lane(state, pursuits(rest, PURSUITS, steps, rng)[int(rng.integers(PURSUITS))], steps)
