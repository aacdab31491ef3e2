"""What hangs together: connected parts of a graph, or of some of its rows.

Shape legend: N rows, n chosen ones, E pairs.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components

from reachtest.records import Ints

Connection = Literal["weak", "strong"]
WAYS: Connection = "weak"
STRONGLY: Connection = "strong"


def inner_pairs(pairs: Ints, rows: Ints, count: int) -> Ints:
    """Those of `pairs` [E, 2] of `count` rows that are between `rows` [n], as places in `rows`."""
    place = np.full(count, -1, dtype=np.int64)
    place[rows] = np.arange(len(rows))
    inner = place[pairs]
    return inner[(inner >= 0).all(axis=1)]


def part_labels(count: int, pairs: Ints, connection: Connection = WAYS) -> Ints:
    """Which connected part each of `count` rows belongs to [N], by `pairs` [E, 2] of them, from one to the other."""
    ones = np.ones(len(pairs), dtype=np.int8)
    graph = csr_matrix((ones, (pairs[:, 0], pairs[:, 1])), shape=(count, count))
    label = connected_components(graph, directed=connection == STRONGLY, connection=connection)[1]
    return np.asarray(label, dtype=np.int64)


def grouped(label: Ints) -> list[Ints]:
    """The rows of each label [N], ascending, by label."""
    if not len(label):
        return []
    order = np.argsort(label, kind="stable")
    return np.split(order, np.flatnonzero(np.diff(label[order])) + 1)
