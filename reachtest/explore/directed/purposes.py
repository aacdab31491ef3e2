"""Which lanes of a round act on purpose, and for what: towards open goals, and over the nav-mesh's border."""

from __future__ import annotations

import numpy as np

from reachtest.columns import ColumnIndex
from reachtest.explore.cache import PositionCache
from reachtest.explore.directed.aim import Aim, Aims
from reachtest.explore.directed.borders import Borders
from reachtest.explore.directed.floors import floors_off
from reachtest.explore.directed.footholds import Footholds
from reachtest.explore.directed.gaps import places_to_push
from reachtest.explore.directed.walks import Walks
from reachtest.explore.goals import GoalSet
from reachtest.navmesh.coverage import GoalIslands
from reachtest.navmesh.islands import Islands
from reachtest.records import OUTWARDS, Bools, Candidates, ExploreSettings, Level

AFTERWARDS = 2.0  # times as many lanes once all promised goals are reached, or were tried for enough


class Directed:
    """The directed lanes' purposes: goals as long as some are open, and the border always.

    Goals where one was promised to get come first; those on islands that somebody got onto all the same are extra.
    """

    def __init__(self, aims: Aims, borders: Borders, footholds: Footholds, settings: ExploreSettings) -> None:
        self.aims, self.borders, self._footholds = aims, borders, footholds
        self._lanes, self._all = settings.directed * settings.lanes, float(settings.lanes)  # of every round
        self._effort = settings.effort

    def draw(
        self, rng: np.random.Generator, number: int, cache: PositionCache, candidates: Candidates
    ) -> Aim | None:
        """What the directed lanes of round `number` do; None if nothing."""
        self._footholds.note(cache.positions, candidates.grounded)
        if self.aims.wanting(self._effort):
            some, share = self._lanes, OUTWARDS
        else:
            some, share = min(AFTERWARDS * self._lanes, self._all), 1.0 - OUTWARDS
        lanes = _whole(some, number)
        outwards = min(_whole(share * some, number), lanes)
        self.aims.add(self._footholds.goals)
        goals = self.aims.draw(rng, lanes - outwards, cache, candidates)
        border = self.borders.draw(rng, lanes if goals is None else outwards, cache, candidates)
        aims = [aim for aim in (goals, border) if aim is not None]
        if not aims:
            return None
        starts, headings, targets = (
            np.concatenate([getattr(aim, name) for aim in aims]) for name in ("starts", "headings", "targets")
        )
        return Aim(starts, headings, targets)


def directed(
    level: Level, columns: ColumnIndex, goals: GoalSet, wanted: Bools, islands: Islands, on: GoalIslands
) -> Directed:
    """The purposes of a level with floors in `columns`: `goals`, of which those `wanted` [G] were promised, on
    `islands`."""
    floors = floors_off(level, islands)
    footholds = Footholds(islands, on.connected, on.goal_island, floors)
    walks = Walks(level.character, level.explore, columns)
    aims = Aims(goals, wanted, level.explore.goal_spacing_m, walks)
    along, gaps = places_to_push(islands, on.connected, level.character, floors)
    borders = Borders(along, gaps, footholds, level.character, level.explore)
    return Directed(aims, borders, footholds, level.explore)


def _whole(lanes: float, number: int) -> int:
    """The lanes of a round: a share to the nearest whole number, over the rounds."""
    return int(np.floor((number + 1) * lanes) - np.floor(number * lanes))
