"""Which lanes of a round act on purpose, and for what: towards open goals, and over the nav-mesh's border."""

from __future__ import annotations

import numpy as np

from reachtest.explore.aim import Aim, Aims
from reachtest.explore.borders import Borders
from reachtest.explore.cache import PositionCache
from reachtest.records import OUTWARDS, Candidates


class Directed:
    """The directed lanes' purposes: goals as long as some are open, and the border always."""

    def __init__(self, aims: Aims, borders: Borders, lanes: float) -> None:
        """`lanes` of every round are directed, on the average."""
        self.aims, self.borders, self._lanes = aims, borders, lanes

    def draw(
        self, rng: np.random.Generator, number: int, cache: PositionCache, candidates: Candidates
    ) -> Aim | None:
        """What the directed lanes of round `number` do; None if nothing."""
        lanes = _whole(self._lanes, number)
        outwards = min(_whole(OUTWARDS * self._lanes, number), lanes)
        goals = self.aims.draw(rng, lanes - outwards, cache, candidates)
        border = self.borders.draw(rng, lanes if goals is None else outwards, cache, candidates)
        aims = [aim for aim in (goals, border) if aim is not None]
        if not aims:
            return None
        starts, headings, targets = (
            np.concatenate([getattr(aim, name) for aim in aims]) for name in ("starts", "headings", "targets")
        )
        return Aim(starts, headings, targets)


def _whole(lanes: float, number: int) -> int:
    """The lanes of a round: a share to the nearest whole number, over the rounds."""
    return int(np.floor((number + 1) * lanes) - np.floor(number * lanes))
