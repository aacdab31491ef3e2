"""What makes a simulation show the same bug again: the same kind of thing at the same place."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.spatial import cKDTree

from reachtest.confirm.pursuit import Route
from reachtest.confirm.shortcut import over_navmesh
from reachtest.confirm.trials import Trial
from reachtest.geometry import at_rest
from reachtest.interfaces import Surface
from reachtest.navmesh.itself import NavMeshItself
from reachtest.offlimits import SOLID, ZONE, off_limits
from reachtest.records import Bools, Finding, Floats, Level

SAME_PLACE_M = 4.0  # of the last footing or the exit of a fall: a hole has a width, and one jumps into it
ON_MESH_M = 0.5  # "expected" reaches through walls: who went through one has to do it again
SLACK_M = 1.0  # around the box of a finding
IN_POCKET_M = 0.5  # of where somebody stood: less than any pit is deep
LANDING_M = 0.1  # more than a landing sinks in
PLACES_AT_ONCE = 32  # measured against the nav-mesh: about as dear as one


@dataclass(frozen=True)
class Outcome:
    """What is to come about again."""

    kind: str
    target: str | None  # the name of the solid or zone, where that is what counts
    place: Floats  # [3]
    low: Floats  # [3]
    high: Floats  # [3]
    exit_point: Floats | None  # [3]
    standing: Floats | None = None  # [k, 3] of a pocket: where somebody stood or lay in it
    reach_m: float | None = None  # of a pocket: farthest that anybody got from where it began in it

    @property
    def within_m(self) -> float:
        """Who is so near to one of `standing` is in the pocket: in a wedge that is not who passes by."""
        return IN_POCKET_M if self.reach_m is None else min(IN_POCKET_M, self.reach_m + LANDING_M)

    def of_same_bug(self) -> Outcome:
        """Any place of the same bug: who stands off the nav-mesh beside such a place shows that one."""
        if self.kind != "unexpected_area":
            return self
        more = SAME_PLACE_M - SLACK_M
        return replace(self, low=self.low - more, high=self.high + more)

    @cached_property
    def near(self) -> cKDTree:
        """Finds the nearest of `standing`."""
        assert self.standing is not None
        return cKDTree(self.standing)


class Judge:
    """Knows the level: says when, if at all, a simulation came to an outcome."""

    def __init__(self, level: Level, surface: Surface) -> None:
        """`surface` tells expected from unexpected positions."""
        self._level, self._surface = level, surface
        self._holds = {(one.kind, one.name): one.holds for one in off_limits(level)}

    @cached_property
    def _itself(self) -> NavMeshItself:
        return NavMeshItself(self._level)

    def over_navmesh(self, trial: Trial) -> Route | None:
        """The short way over the nav-mesh to where a trial left it for good; None if there is none."""
        on_mesh = np.flatnonzero(self.away(trial) <= ON_MESH_M)
        return over_navmesh(self._level.navmesh, trial, int(on_mesh[-1])) if len(on_mesh) else None

    def outcome_of(self, finding: Finding) -> Outcome:
        """What would show `finding` again."""
        target = finding.target if finding.kind in (SOLID, ZONE) else None
        low, high, exit_point = finding.low, finding.high, finding.exit_point
        standing, reach_m = finding.standing, finding.reach_m
        return Outcome(finding.kind, target, finding.position, low, high, exit_point, standing, reach_m)

    def step(self, outcome: Outcome, trial: Trial, since: int = 0) -> int | None:
        """The first step from `since` on at which `trial` came to `outcome`; None if it did not."""
        if outcome.kind == "fell_out_of_world":
            return len(trial) - 1 if trial.fell and self._same_fall(outcome, trial) else None
        hits = np.flatnonzero(self._shows(outcome, trial, since))
        return since + int(hits[0]) if len(hits) else None

    def away(self, trial: Trial) -> Floats:
        """How far [t] from the nav-mesh the character stood [m]; infinite where it did not, or was not expected."""
        return self._surface.distance(trial.stood)

    def _shows(self, outcome: Outcome, trial: Trial, since: int) -> Bools:
        positions = trial.positions[since:]
        if outcome.kind in (SOLID, ZONE):
            holds = self._holds.get((outcome.kind, outcome.target or ""))
            return np.zeros(len(positions), dtype=np.bool_) if holds is None else holds(positions)
        if outcome.standing is not None:
            return _in_pocket(outcome, trial)[since:]
        stood = trial.stood[since:]
        shown = ((stood >= outcome.low - SLACK_M) & (stood <= outcome.high + SLACK_M)).all(axis=1)
        if outcome.kind == "unexpected_area" and shown.any():
            shown &= ~np.isfinite(self._surface.distance(stood))
        return np.asarray(shown, dtype=np.bool_)

    def _same_fall(self, outcome: Outcome, trial: Trial) -> bool:
        stood = np.concatenate([trial.start[None, :3], trial.stood[np.isfinite(trial.stood[:, 0])]])
        if outcome.exit_point is not None:
            left = self._left_at(stood)
            if left is not None and np.linalg.norm(left - outcome.exit_point) <= SAME_PLACE_M:
                return True
        low, high = outcome.low - SAME_PLACE_M, outcome.high + SAME_PLACE_M
        return bool(((stood[-1] >= low) & (stood[-1] <= high)).all())

    def _left_at(self, places: Floats) -> Floats | None:
        """The last of `places` [n, 3] on the nav-mesh itself; sought from the end, where it mostly is."""
        for end in range(len(places), 0, -PLACES_AT_ONCE):
            some = places[max(end - PLACES_AT_ONCE, 0) : end]
            left = self._itself.last_of(some)
            if left is not None:
                return np.asarray(some[left], dtype=np.float64)
        return None


def _in_pocket(outcome: Outcome, trial: Trial) -> Bools:
    """Where [t] the character stood or lay in a pocket; nowhere if it was out of it again in the end.

    By places and not by their box: that of a slanting pit holds its rim.
    """
    assert outcome.standing is not None
    footings = _footings(trial)
    inside = np.zeros(len(trial), dtype=np.bool_)
    held = np.flatnonzero(np.isfinite(footings[:, 0]))
    if len(held):
        low, high = outcome.standing.min(axis=0), outcome.standing.max(axis=0)
        last = footings[held[-1]]
        if ((last >= low - outcome.within_m) & (last <= high + outcome.within_m)).all():
            inside[held] = outcome.near.query(footings[held])[0] <= outcome.within_m
    return inside


def _footings(trial: Trial) -> Floats:
    """Where [t, 3] the character stood, or lay still, in each step; NaN where it did neither."""
    moved = np.linalg.norm(np.diff(trial.positions, axis=0, prepend=trial.start[None, :3]), axis=1)
    lying = np.where(at_rest(moved)[:, None], trial.positions, np.nan)
    return np.where(np.isfinite(trial.stood), trial.stood, lying)
