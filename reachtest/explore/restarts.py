"""Where the lanes of a round start from: most where the reset heuristics say, some on purpose.

Shape legend: B lanes, M starts each, P cached points.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from reachtest.explore.actions import start_generator
from reachtest.explore.directed import Directed
from reachtest.explore.heuristics import mixture
from reachtest.explore.ledger import Ledger
from reachtest.records import Ints, Level

STARTS_PER_AGENT = 16  # drawn beforehand: at a metre a step a fall takes eight steps at the least


class Restarts:
    """Draws them, by round."""

    def __init__(self, level: Level, directed: Directed, seed: int) -> None:
        self._lanes, self._spawns = level.explore.lanes, len(level.spawns)
        self._directed, self._seed = directed, seed
        self._eta = mixture(level.explore.heuristics, level.explore.power)

    def draw(self, ledger: Ledger) -> tuple[Ints, NDArray[np.int16]]:
        """What each lane starts from [M, B]: cached points, or -1 - i for spawn i; and its heading [B] or 0."""
        headings = np.zeros(self._lanes, dtype=np.int16)
        number, shape = ledger.rounds, (STARTS_PER_AGENT, self._lanes)
        if (
            not len(ledger.archive) or number * self._lanes < self._spawns
        ):  # every spawn is used at least once
            after = np.arange(shape[0] * shape[1]).reshape(shape)
            return -1 - (number * self._lanes + after) % self._spawns, headings
        candidates = ledger.candidates()
        # In the air over nothing, nothing can come of it: the edge that was left is cached too.
        weight = np.where(np.isinf(candidates.above_m), 0.0, self._eta(candidates))
        if not weight.any():
            weight[:] = 1.0
        total = np.cumsum(weight)
        rng = start_generator(self._seed, number)
        starts = np.minimum(
            np.searchsorted(total, rng.random(shape) * total[-1], side="right"), len(weight) - 1
        )
        aim = self._directed.draw(rng, number, ledger.cache, candidates)
        if aim is not None:  # an episode that ends early is tried again from where it began
            starts[:, : len(aim.starts)], headings[: len(aim.starts)] = aim.starts, aim.headings
        return starts, headings
