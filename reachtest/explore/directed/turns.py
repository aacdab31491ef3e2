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


def in_turns(tries: Ints, rank: Floats, target: Ints, lanes: int) -> Ints:
    """The rows for `lanes` lanes: one of the target that was tried least, of its rows the one with the lowest `rank`.

    A row comes over again where its target has few: a step of a pillar may have thirty gaps around it, the roof beyond
    it two. `target` [n] and `tries` [n] are by row.
    """
    _, of = np.unique(target, return_inverse=True)
    rank, total = rank.copy(), np.bincount(of, weights=tries)
    chosen = np.empty(lanes, dtype=np.int64)
    for lane in range(lanes):
        where = int(total.argmin())
        chosen[lane] = row = int(np.where(of == where, rank, np.inf).argmin())
        rank[row] += 1
        total[where] += 1
    return chosen
