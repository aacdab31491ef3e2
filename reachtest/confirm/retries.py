"""What was found, tried again: with other actions around the found ones, as it was and at half the time step."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence

import numpy as np

from reachtest.confirm.along import MOST_STEPS, search_along
from reachtest.confirm.outcome import ON_MESH_M, Judge
from reachtest.confirm.shorten import Way, pursuits
from reachtest.confirm.trials import Lane, Plan, Trial, run_lanes
from reachtest.confirm.variation import held, vary
from reachtest.geometry import near_from_above
from reachtest.interfaces import Simulator
from reachtest.records import Level

# As many again for what half the step has not shown, twice from a run-up earlier: where the coarse step turned and
# jumped in one tick, the half step takes off as much slower, and has to begin before (0 of 66, and 31 of 66 half a
# second earlier, measured at two ledges). Then from the spawn, and at last by a search along the way: fragile is said
# late. Not of pockets: who is on the way through one would do.
EARLIER_STEPS = (4, 16)
SEARCHES, ALL_SEARCHES = 5, 20  # of a finding, and of those tried together: about 3 s each
SEARCH_SHARE = 0.25  # of the run's steps at most are searches, or LEAST_SEARCHED; what gates comes first
LEAST_SEARCHED = 4 * MOST_STEPS  # a minute
AGAIN = 0.1  # of the attempts around what the search found: less is the half step's own rounding
RARELY = 1 / 200  # of the attempts: what half the step shows no oftener it does not show
LEAD_STEPS = 8  # about a second before the outcome at the least, or there is nothing to vary
AROUND_M = 40.0  # of the level around what is simulated at half the step: its tiles are compiled anew
FINE_LANES = 64

Tries = tuple[int, int]  # attempts, and how many of them showed it


def shows(tries: Tries) -> bool:
    """Whether attempts and successes at half the step say that it is no doing of the coarse one."""
    return tries[1] > RARELY * tries[0]


class Retries:
    """Tries ways again, from a little before their outcome."""

    def __init__(
        self,
        level: Level,
        simulator: Simulator,
        simulate: Callable[[Level, int], Simulator],
        judge: Judge,
        rng: np.random.Generator,
        pause: Callable[[], None],
    ) -> None:
        """`simulate` makes a simulator of a level for a number of agents: it is asked for one at half the step.

        `pause` is called between steps.
        """
        self._level, self._simulator, self._simulate = level, simulator, simulate
        self._judge, self._rng, self._pause = judge, rng, pause
        self._steps_left = max(LEAST_SEARCHED, int(SEARCH_SHARE * level.explore.steps))

    def nearby(self, ways: Sequence[Way], count: int) -> list[Tries]:
        """`count` attempts at each way at the step it was found with."""
        return self._attempt(self._simulator, [self._stretch(way) for way in ways], count)

    def at_half_step(
        self, found: Sequence[Way], cut: Sequence[Way], count: int
    ) -> tuple[list[Tries], list[Way]]:
        """The tries of each way, and the way to show: the cut one only if half the step shows it too."""
        finer = self._simulate(_at_half_step(_around(self._level, [*found, *cut])), FINE_LANES)
        loose, loosely_cut = _of_same_bug(found), _of_same_bug(cut)
        tries = self._attempt(finer, [self._stretch(way) for way in loosely_cut], count, as_found=True)
        shown = [
            way if good else found[row] for row, (way, (_, good)) in enumerate(zip(cut, tries, strict=True))
        ]
        for earlier_by in (*EARLIER_STEPS, None):
            missing = _missing(tries)
            earlier = [self._earlier(loose[row], earlier_by) for row in missing]
            more = self._attempt(finer, earlier, count, as_found=True)
            for row, (attempts, succeeded) in zip(missing, more, strict=True):
                tries[row] = (tries[row][0] + attempts, succeeded)
        searches = int(np.clip(ALL_SEARCHES // max(len(_missing(tries)), 1), 1, SEARCHES))
        rows = [row for row in _missing(tries) if loose[row].outcome.standing is None]
        for number, row in enumerate(rows):
            way = self._earlier(loose[row], EARLIER_STEPS[-1])
            share = max(self._steps_left, 0) // (len(rows) - number)
            attempts, trial = search_along(way, finer, self._judge, self._rng, searches, share, self._pause)
            self._steps_left -= attempts * len(way.trial)
            tries[row] = (tries[row][0] + attempts, int(trial is not None))
            if trial is not None:
                it = self._stretch(dataclasses.replace(way, trial=trial))
                (around,) = self._attempt(finer, [it], count, as_found=True)
                rare = (tries[row][0] + around[0], 1 + around[1])
                tries[row] = around if around[1] >= AGAIN * around[0] else rare
        return tries, shown

    def _stretch(self, way: Way, lead: int = LEAD_STEPS) -> Way:
        """What remains of a way from the last state on the nav-mesh at least `lead` steps before its outcome.

        Where there is none, from the last expected one; rather not from the instant of a jump: the half step would
        have to make that of the coarse one.
        """
        trial = way.trial
        away = self._judge.away(trial)[: max(len(trial) - lead, 0)]
        on_mesh, expected = away <= ON_MESH_M, np.isfinite(away)
        calm = on_mesh & (trial.actions[: len(away), 1] == 0)
        some = next((kind for kind in (calm, on_mesh, expected) if kind.any()), expected)
        begin = int(np.flatnonzero(some)[-1]) + 1 if some.any() else 0
        start = trial.states[begin - 1] if begin else way.start
        rest = Trial(start, trial.actions[begin:], trial.states[begin:], trial.stood[begin:], trial.fell)
        return Way(start, way.outcome, rest)

    def _earlier(self, way: Way, steps: int | None) -> Way:
        """What remains of a way from so many steps before its stretch; all of it for None."""
        length = len(way.trial)
        return self._stretch(way, length if steps is None else len(self._stretch(way).trial) + steps)

    def _attempt(
        self, simulator: Simulator, ways: Sequence[Way], count: int, as_found: bool = False
    ) -> list[Tries]:
        """`count` variations of each way: half of them scripts, half followers."""
        lanes, owner = [], []
        for row, way in enumerate(ways):
            steps = len(way.trial) * 5 // 4 + LEAD_STEPS
            plans: list[Plan] = [vary(way.trial.actions, steps, self._rng) for _ in range(count // 2)]
            plans += [held(way.trial.actions, steps)] if as_found else []
            plans += pursuits(way.trial, count - count // 2, steps, self._rng)
            lanes += [Lane(way.start, plan, steps) for plan in plans]
            owner += [row] * len(plans)
        tries = np.zeros((len(ways), 2), dtype=np.int64)
        for row, trial in zip(owner, run_lanes(simulator, lanes, self._pause), strict=True):
            tries[row] += 1, self._judge.step(ways[row].outcome, trial) is not None
        return [(int(attempts), int(succeeded)) for attempts, succeeded in tries]


def _of_same_bug(ways: Sequence[Way]) -> list[Way]:
    return [dataclasses.replace(way, outcome=way.outcome.of_same_bug()) for way in ways]


def _missing(tries: Sequence[Tries]) -> list[int]:
    return [row for row, (_, succeeded) in enumerate(tries) if not succeeded]


def _at_half_step(level: Level) -> Level:
    finer = dataclasses.replace(
        level.explore,
        physics_hz=2 * level.explore.physics_hz,
        action_repeat=2 * level.explore.action_repeat,
    )
    return dataclasses.replace(level, explore=finer)


def _around(level: Level, ways: Sequence[Way]) -> Level:
    """The level within `AROUND_M` of the ways, seen from above: falls go on below."""
    places = [np.concatenate([way.start[None, :3], way.trial.positions]) for way in ways]
    near = near_from_above(level.collision, places, AROUND_M)
    return dataclasses.replace(level, collision=level.collision[near])
