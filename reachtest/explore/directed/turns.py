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


def by_target(tries: Ints, rank: Floats, target: Ints) -> Floats:
    """How many tries of the same `target` [n] there were before it is a row's turn [n]: targets take turns.

    A step of a pillar may have thirty gaps around it, and the roof beyond it three. Within a target `rank` [n] counts.
    """
    order = np.lexsort((rank, target))
    new = np.append(True, np.diff(target[order]) > 0)
    place = np.empty(len(tries))
    place[order] = np.arange(len(tries)) - np.flatnonzero(new)[np.cumsum(new) - 1]
    return place + np.bincount(target, weights=tries)[target]
