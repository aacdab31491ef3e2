"""Confirmed, or not reported as a bug: every finding with a path is simulated again, and its path cut.

Exactly, from its spawn; then from the last state on the nav-mesh before it: with other actions around the found ones,
and all of that at half the physics time step, in the end also from the spawn and by a search along the way. What
half the step does not show, or next to never, is `fragile`: the time step's doing, or too close to tell from it.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence

import numpy as np

from reachtest.confirm.outcome import Judge
from reachtest.confirm.retries import Retries, shows
from reachtest.confirm.shorten import Way, affordable, shorten
from reachtest.confirm.trials import Lane, Trial, run_lanes
from reachtest.interfaces import Simulator, Surface, Teller
from reachtest.records import Confirmation, Fall, Finding, Level, ReplayPath

# What to show of a finding, whether it came out, and (attempts, succeeded) at half the step and nearby.
_Confirmed = tuple[Way, bool, tuple[int, int], tuple[int, int]]

VARIATIONS = (8, 32)  # of a finding, at each time step: fewer where there are many findings
ALL_VARIATIONS = 512
AT_ONCE = 8  # findings: enough to share the cost of a step, few enough to have some done when a signal comes
_STREAM = 0xC0  # apart from the streams of the exploration


class _Interrupted(Exception):
    """Somebody waits."""


class Confirmer:
    """Simulates findings again, a few of them side by side."""

    def __init__(
        self,
        level: Level,
        simulator: Simulator,
        surface: Surface,
        seed: int,
        simulate: Callable[[Level, int], Simulator],
        interrupted: Callable[[], bool] = lambda: False,
        tell: Teller = lambda what, number, total: None,
        path_to: Callable[[Fall], ReplayPath] | None = None,
    ) -> None:
        """`simulate` makes a simulator of a level for a number of agents: it is asked for one at half the step;
        `path_to` gives the way to a fall.

        Once `interrupted`, what is not confirmed yet stays unconfirmed.
        """
        self._simulator = simulator
        self._interrupted, self._tell, self._at = interrupted, tell, (0, 0)
        self._path_to = path_to
        self.judge = Judge(level, surface)
        self._rng = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(_STREAM, 0, 0)))
        self._retries = Retries(level, simulator, simulate, self.judge, self._rng, self._pause)

    def confirm(self, findings: Sequence[Finding]) -> tuple[Finding, ...]:
        """The findings with their confirmation and the shortest known path; those that gate come first."""
        known = {i: way for i, f in enumerate(findings) if (way := self._way(f))}
        order = sorted(known, key=lambda i: (not findings[i].gating, len(known[i].trial)))
        cut = dict(zip(order, affordable([known[i] for i in order]), strict=True))
        count = int(np.clip(ALL_VARIATIONS // max(len(known), 1), *VARIATIONS))
        result = list(findings)
        try:
            for begin in range(0, len(order), AT_ONCE):
                some = order[begin : begin + AT_ONCE]
                self._at = (begin + 1, len(order))
                ways = self._confirmed([known[i] for i in some], [cut[i] for i in some], count)
                for index, confirmed in zip(some, ways, strict=True):
                    result[index] = self._with(*self._elsewhere(findings[index], confirmed, count))
        except _Interrupted:
            pass
        finally:
            self._simulator.use(self._simulator.agents)
        return tuple(sorted(result, key=lambda finding: not finding.gating))

    def _confirmed(self, found: Sequence[Way], cut: Sequence[bool], count: int) -> list[_Confirmed]:
        """Of each way, `cut` where that can be paid: what to show, whether it came out, and (attempts, succeeded)."""
        shorter = iter(self._shorter([way for way, worth in zip(found, cut, strict=True) if worth]))
        ways = [next(shorter) if worth else way for way, worth in zip(found, cut, strict=True)]
        nearby = self._retries.nearby(ways, count)
        half, shown = self._retries.at_half_step(found, ways, count)
        return list(zip(shown, self._exact(shown), half, nearby, strict=True))

    def _shorter(self, ways: Sequence[Way]) -> list[Way]:
        return shorten(ways, self._simulator, self.judge, self._rng, self._pause)

    def _pause(self) -> None:
        self._tell("confirming findings", *self._at)
        if self._interrupted():
            raise _Interrupted

    def _elsewhere(self, finding: Finding, confirmed: _Confirmed, count: int) -> tuple[Finding, _Confirmed]:
        """The finding by another part of its edge, where half the step shows it there and not where it was shown."""
        way, exact, half, nearby = confirmed
        path_to = self._path_to
        if path_to is None or shows(half):
            return finding, confirmed
        for fall in finding.others:
            exit_point = None if np.isnan(fall.exit_point).any() else fall.exit_point
            other = dataclasses.replace(
                finding, path=path_to(fall), position=fall.footing, exit_point=exit_point
            )
            if found := self._way(other):
                ((again, came_out, more, around),) = self._confirmed([found], affordable([found]), count)
                if shows(more):
                    return other, (again, came_out, more, around)
                half = half[0] + more[0], half[1] + more[1]
        return finding, (way, exact, half, nearby)

    def _with(self, finding: Finding, confirmed: _Confirmed) -> Finding:
        way, exact, half, nearby = confirmed
        path = finding.path
        assert path is not None
        tries = (path.attempts + 1, path.succeeded + exact)
        fragile = not shows(half) or tries[1] < tries[0]
        return dataclasses.replace(
            finding,
            path=_shown(path, way.trial, self._simulator.step_s),
            confirmation=Confirmation(tries, half, nearby),
            fragile=fragile,
            gating=finding.gating and not fragile,
        )

    def _way(self, finding: Finding) -> Way | None:
        """The way to a finding, up to where it comes about; None without a path."""
        path = finding.path
        if path is None or path.state is None or path.actions is None or path.states is None:
            return None
        assert path.stood is not None
        fell = finding.kind == "fell_out_of_world"
        trial = Trial(path.state, path.actions, path.states, path.stood, fell)
        return Way(path.state, self.judge.outcome_of(finding), trial)

    def _exact(self, ways: Sequence[Way]) -> list[bool]:
        """Whether each way, all its actions in one go from its start, comes out bit for bit and shows it."""
        lanes = [Lane(way.start, way.trial.actions, len(way.trial)) for way in ways]
        return [
            bool(np.array_equal(again.states, way.trial.states))
            and self.judge.step(way.outcome, again) is not None
            for way, again in zip(ways, run_lanes(self._simulator, lanes, self._pause), strict=True)
        ]


def _shown(path: ReplayPath, trial: Trial, step_s: float) -> ReplayPath:
    return dataclasses.replace(
        path,
        positions=trial.positions,
        actions=trial.actions,
        states=trial.states,
        stood=trial.stood,
        duration_s=len(trial) * step_s,
        found_s=path.duration_s,
    )
