"""Whose turn it is: what was tried least, and of what many gaps lead to, no more than of what few do.

Shape legend: n rows of a table of things to try.
"""

from __future__ import annotations

import numpy as np

from reachtest.records import Floats, Ints


def least_tried(tries: Floats, lanes: int) -> Ints:
    """The rows for `lanes` lanes of which `tries` [n] are the fewest; over again where there are fewer rows."""
    least = np.argpartition(tries, min(lanes, len(tries)) - 1)[:lanes]
    return np.resize(least[np.argsort(tries[least])], lanes)


def in_turns(rank: Floats, target: Ints, tries: Floats | Ints, lanes: int) -> Ints:
    """The rows for `lanes` lanes: one of the target that was tried least, of its rows the one with the lowest `rank`.

    A row comes over again where its target has few: a step of a pillar may have thirty gaps around it, the roof beyond
    it two. `rank` and `target` [n] are by row, `tries` [m] by target.
    """
    rank, tries = rank.copy(), tries.copy()
    chosen = np.empty(lanes, dtype=np.int64)
    for lane in range(lanes):
        where = int(tries.argmin())
        chosen[lane] = row = int(np.where(target == where, rank, np.inf).argmin())
        rank[row] += 1
        tries[where] += 1
    return chosen
