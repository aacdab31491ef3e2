"""The shortest known way to a finding: the found one without its loops, followed again by characters that hurry.

A found way is a chain of random walks. It is cut in two ways, both judged by simulation: characters follow it from
the spawn without its loops and with other lookaheads, and pieces are left out of what they did (Zeller and
Hildebrandt's delta debugging, TSE 2002, from the end backwards). All budgets are counted in agent steps, never in
seconds: the same run gives the same way.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from reachtest.confirm.outcome import Judge, Outcome
from reachtest.confirm.pursuit import LOOP_M, Pursuit, Route, route_of
from reachtest.confirm.trials import LOOK_STEPS, Actions, Lane, Trial, Trials, run_lanes
from reachtest.interfaces import Simulator
from reachtest.records import Floats

FOLLOWERS = 16  # of a finding: fewer find little, more cost more than they find
FOLLOWED_TIMES = 2  # the second follows the best of the first; a third found next to nothing on maps/small
MAX_LANE_STEPS = 100_000  # a run, about half as many as its exploration: the rest of the ways stays as found
SHORT_CUTS_M = (0.5, 2.5, 6.0)  # what counts as a loop: see `route_of`
AHEAD_M = (0.8, 1.5, 2.5, 4.0)
RANDOM_SHARES = (0.0, 0.0, 0.05, 0.1)
CHUNKS = (64, 32, 16, 8, 4, 2, 1)  # [agent steps] left out


@dataclass(frozen=True)
class Way:
    """From a start state to an outcome."""

    start: Floats  # [S]
    outcome: Outcome
    trial: Trial  # its actions and where they led; ends where the outcome comes about

    def cut_to(self, trial: Trial, steps: int) -> Way:
        """The same with the first `steps` of another trial."""
        return replace(self, trial=first_steps(trial, steps))


def first_steps(trial: Trial, steps: int) -> Trial:
    """The first `steps` of a trial."""
    return Trial(
        trial.start,
        trial.actions[:steps],
        trial.states[:steps],
        trial.stood[:steps],
        trial.fell and steps >= len(trial),
    )


def affordable(ways: Sequence[Way]) -> list[bool]:
    """Which ways are worth cutting: one after the other, as long as the budget of a run allows."""
    cost = np.cumsum([FOLLOWED_TIMES * FOLLOWERS * len(way.trial) for way in ways])
    return [bool(spent <= MAX_LANE_STEPS) for spent in cost]


def shorten(
    ways: Sequence[Way],
    simulator: Simulator,
    judge: Judge,
    rng: np.random.Generator,
    pause: Callable[[], None] = lambda: None,
) -> list[Way]:
    """Ways as long or shorter, each simulated from its start; `pause` is called now and then."""
    best, shorter = list(ways), list(range(len(ways)))
    for _ in range(FOLLOWED_TIMES):
        followed = _follow([best[i] for i in shorter], simulator, judge, rng, pause)
        better = [len(way.trial) < len(best[i].trial) for i, way in zip(shorter, followed, strict=True)]
        for i, way in zip(shorter, followed, strict=True):
            best[i] = way
        shorter = [i for i, gained in zip(shorter, better, strict=True) if gained]
    return _leave_out(best, simulator, judge, pause)


def pursuits(
    trial: Trial,
    count: int,
    steps: int,
    rng: np.random.Generator,
    loops_m: Sequence[float] = (LOOP_M,),
    other: Sequence[Route] = (),
) -> list[Pursuit]:
    """`count` different ways to follow a trial, or `other` routes to the same, for `steps`."""
    routes = [route_of(trial.start[:3], trial.positions, trial.actions, loop_m) for loop_m in loops_m]
    routes += other
    kinds = list(itertools.product(RANDOM_SHARES, (True, False), AHEAD_M, routes))
    return [
        Pursuit(
            route,
            ahead_m=ahead_m,
            jumps_as_found=as_found,
            noise=rng.random((steps, 3)),
            random_share=random_share,
        )
        for random_share, as_found, ahead_m, route in itertools.islice(itertools.cycle(kinds), count)
    ]


def _follow(
    ways: Sequence[Way],
    simulator: Simulator,
    judge: Judge,
    rng: np.random.Generator,
    pause: Callable[[], None],
) -> list[Way]:
    """The followers of each way that arrived in the fewest steps, where that is fewer than the way has."""
    owner, lanes = np.repeat(np.arange(len(ways)), FOLLOWERS), []
    for way in ways:
        steps = max(len(way.trial) - 1, 1)  # only what is shorter counts
        short = judge.over_navmesh(way.trial)
        plans = pursuits(way.trial, FOLLOWERS, steps, rng, SHORT_CUTS_M, [short] if short else [])
        lanes += [Lane(way.start, plan, steps) for plan in plans]
    trials, best, seen = Trials(simulator, lanes), list(ways), [0] * len(lanes)
    going_on = True
    while going_on:
        going_on = trials.advance(LOOK_STEPS)
        pause()
        for lane in [i for i in range(len(lanes)) if trials.length(i) > seen[i]]:
            index, trial = int(owner[lane]), trials.trial(lane)
            step = judge.step(ways[index].outcome, trial, seen[lane])
            seen[lane] = len(trial)
            if step is not None and step + 1 < len(best[index].trial):
                best[index] = ways[index].cut_to(trial, step + 1)
                for same in np.flatnonzero(owner == index).tolist():
                    trials.limit(same, step)
    return best


def _leave_out(
    ways: Sequence[Way], simulator: Simulator, judge: Judge, pause: Callable[[], None]
) -> list[Way]:
    """The best of what is left when one piece is left out, each tried from the state before it."""
    owner, cuts, lanes = [], [], []
    for index, way in enumerate(ways):
        for begin, chunk in _pieces(len(way.trial), FOLLOWERS):
            left = way.trial.actions[begin + chunk :]
            if len(left):
                before = way.trial.states[begin - 1] if begin else way.start
                owner.append(index)
                cuts.append(begin)
                lanes.append(Lane(before, left, len(left)))
    best = list(ways)
    for index, begin, trial in zip(owner, cuts, run_lanes(simulator, lanes, pause), strict=True):
        whole = joined(first_steps(ways[index].trial, begin), trial)
        step = judge.step(ways[index].outcome, whole, begin)
        if step is not None and step + 1 < len(best[index].trial):
            best[index] = ways[index].cut_to(whole, step + 1)
    return best


def _pieces(length: int, count: int) -> list[tuple[int, int]]:
    """`count` pieces (begin, steps) of a way of `length` steps: from its end backwards, the large ones first."""
    result = [
        (begin, chunk)
        for chunk in CHUNKS
        if chunk < length
        for begin in range(length - chunk - 1, max(length - 8 * chunk, 0) - 1, -chunk)
        if begin >= 0
    ]
    spread = np.linspace(0, len(result) - 1, min(count, len(result))).astype(int)
    return [result[i] for i in dict.fromkeys(spread.tolist())]


def joined(first: Trial, second: Trial) -> Trial:
    """A trial that went on from where another ended."""
    actions: Actions = np.concatenate([first.actions, second.actions])
    return Trial(
        first.start,
        actions,
        np.concatenate([first.states, second.states]),
        np.concatenate([first.stood, second.stood]),
        second.fell,
    )
