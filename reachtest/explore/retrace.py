"""Ways one can walk back, though nobody turned round there: what was walked through on level ground leads both ways.

Every episode ends somewhere, mostly where nobody was before. Without this each such place is one that nothing found
leads back from, and in a wide level nearly all probes are spent on open ground.

A flight is no walk: neither is a fall into a pit. Who is slow may have run into what holds him, and so may who was not
seen to leave a place again: only places that were walked through lead back.

Shape legend: B lanes, T agent steps of a round, M starts drawn for each lane, n visits of a lane after the other.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from reachtest.explore.rollout import Trajectories
from reachtest.records import Bools, Character, Floats, Ints

TIMES = 3  # of an agent step
BEFORE, WITHIN, AFTER = range(TIMES)
SURE = (
    0.5  # share of the walking speed that nobody has who is held, and of the height that a capsule rolls over
)


@dataclass(frozen=True)
class Retrace:
    """When one can walk back."""

    drop_m: float  # from no farther down
    speed_mps: float  # and where one was no slower than this

    @classmethod
    def of(cls, who: Character) -> Retrace:
        """The rule for `who`: back up go a round bottom's ledges, on the side of caution half as high."""
        rolls_over = who.radius_m * (1.0 - np.cos(np.radians(who.slope_limit_deg)))
        return cls(SURE * float(rolls_over), SURE * who.walk_speed_mps)

    def lead_back(
        self, rolled: Trajectories, standing: Bools, lane: Ints, time: Ints, heights: Floats, moved: Bools
    ) -> Ints:
        """Of visits [n] of places in the order of `lane` and `time`, those from which one can walk back to the place
        before: whose place was walked into and out of. `moved` [n - 1] says where one is in another place next, in
        one episode.
        """
        walked = self._walks_back(rolled, standing, lane, time, heights)
        entered = np.flatnonzero(moved)
        stops = np.cumsum(~walked)
        through = walked[entered[:-1]] & (stops[entered[1:]] == stops[entered[:-1]])
        return np.asarray(entered[:-1][through] + 1, dtype=np.int64)

    def _walks_back(
        self, rolled: Trajectories, standing: Bools, lane: Ints, time: Ints, heights: Floats
    ) -> Bools:
        """Whether one can walk back [n - 1] from each visit but the first to the one before.

        `time` [n] is `TIMES` times the agent step and one of `BEFORE`, `WITHIN` and `AFTER`; `heights` [n] are of the
        places and `standing` [M, B] says who stands at its start.
        """
        t, when = time // TIMES, time % TIMES
        on_ground = np.where(when == BEFORE, standing[rolled.which[t, lane], lane], rolled.grounded[t, lane])
        velocity = rolled.states[t, lane, 3:5]
        moving = (when == WITHIN) & (np.hypot(velocity[:, 0], velocity[:, 1]) >= self.speed_mps)
        without_a_gap = np.diff(time) <= TIMES
        level = np.diff(heights) >= -self.drop_m
        return np.asarray(on_ground[:-1] & on_ground[1:] & moving[1:] & without_a_gap & level)
