"""The ways behind new points and falls: where the character last stood, and where it last stood on the nav-mesh.

Shape legend: B lanes, T agent steps of a round, M starts a lane, S spawns, n points asked for.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from reachtest.explore.rollout import Trajectories
from reachtest.interfaces import Surface
from reachtest.records import Bools, Floats, Ints


def of_parents(parents: Ints, archived: Callable[[Ints], Floats], spawned: Floats) -> Floats:
    """Rows [..., k] of `parents`: of cached points, or of spawn i [S, k] for -1 - i."""
    at_spawn = parents < 0
    result = np.empty((*parents.shape, spawned.shape[1]))
    result[at_spawn] = spawned[-1 - parents[at_spawn]]
    result[~at_spawn] = archived(parents[~at_spawn])
    return result


@dataclass(frozen=True)
class Trails:
    """One round looked back on: in the episode under way, else at its parent, else at its spawn."""

    rolled: Trajectories
    parents: Ints  # [M, B]
    surface: Surface
    spawned: Floats  # [S, 3] positions

    def footings(self, t: Ints, b: Ints, archived: Callable[[Ints], Floats]) -> Floats:
        """Where the characters of lanes b [n] last stood at steps t [n], those included: [n, 3]."""
        return self._at(self._stood[t, b], t, b, archived, self.spawned)

    def exits(self, t: Ints, b: Ints, archived: Callable[[Ints], Floats]) -> Floats:
        """Likewise where they last stood at an expected position; NaN if they did not yet.

        Looked for backwards: as a rule it is the last place they stood at, and distances are dear.
        """
        step, begin = self._stood[t, b], self.rolled.start[t, b]
        open_ = np.flatnonzero(step >= begin)
        while len(open_):
            astray = ~self._expected(step[open_], b[open_])
            open_ = open_[astray]
            earlier = step[open_] - 1
            step[open_] = np.where(earlier >= 0, self._stood[earlier, b[open_]], -1)
            open_ = open_[step[open_] >= begin[open_]]
        return self._at(step, t, b, archived, np.full_like(self.spawned, np.nan))

    @cached_property
    def _stood(self) -> Ints:
        """The last step [T, B] at which the character stood, up to each step; -1 before the first."""
        steps = np.arange(len(self.rolled.stood))[:, None]
        return np.maximum.accumulate(
            np.where(np.isfinite(self.rolled.stood[:, :, 0]), steps, -1), axis=0, dtype=np.int64
        )

    def _expected(self, step: Ints, b: Ints) -> Bools:
        """Whether the places stood at in steps [n] of lanes b [n] lie near the nav-mesh; each is measured once."""
        lanes = self.rolled.stood.shape[1]
        distinct, which = np.unique(step * lanes + b, return_inverse=True)
        places = self.rolled.stood[distinct // lanes, distinct % lanes]
        return np.asarray(np.isfinite(self.surface.distance(places))[which], dtype=np.bool_)

    def _at(
        self, step: Ints, t: Ints, b: Ints, archived: Callable[[Ints], Floats], spawned: Floats
    ) -> Floats:
        """The places stood at in `step` [n], where that is within the episode; else those of its parent."""
        during = step >= self.rolled.start[t, b]
        result = np.empty((len(t), 3))
        result[during] = self.rolled.stood[step[during], b[during]]
        before = ~during
        result[before] = of_parents(self.parents[self.rolled.which[t, b], b][before], archived, spawned)
        return result
