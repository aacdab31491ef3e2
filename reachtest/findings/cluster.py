"""Clusters: which pieces of evidence are one bug.

Shape legend: n points, C cells of a grid that hold some of them, p pairs of cells.
"""

from __future__ import annotations

import numpy as np
from scipy.cluster.hierarchy import DisjointSet
from scipy.spatial import cKDTree

from reachtest.connected import grouped, part_labels
from reachtest.records import Floats, Ints

_MOST_SHOWN = 64  # of the exits of one finding, in reports and baselines
_CELL = 0.999 / np.sqrt(3.0)  # of the gap that links: whatever lies in one cell is linked


def single_linkage(points: Floats, link_m: float, ties: Ints | None = None) -> list[Ints]:
    """Groups of `points` [n, 3] connected by gaps of at most `link_m` or by `ties` [t, 2], as ascending indices.

    Groups come in the order of their first point, so that nothing depends on the tree. A rim that half the episodes
    fall off has more pairs of points than memory holds: the points of a cell count as one, and only where two cells
    may be linked or not are they looked at.
    """
    if not len(points):
        return []
    _, cell = np.unique(np.floor(points / (_CELL * link_m)), axis=0, return_inverse=True)
    cell = cell.ravel()
    members = grouped(cell)
    sure, doubtful = _neighbours(points, members, link_m)
    linked = sure if ties is None else np.concatenate([sure, cell[ties]])
    label = part_labels(len(members), linked)
    parts = DisjointSet(range(int(label.max()) + 1))
    for a, b in doubtful[label[doubtful[:, 0]] != label[doubtful[:, 1]]].tolist():
        if not parts.connected(label[a], label[b]) and _gap(points[members[a]], points[members[b]]) <= link_m:
            parts.merge(label[a], label[b])
    root = np.array([parts[part] for part in range(int(label.max()) + 1)])
    return sorted(grouped(root[label[cell]]), key=lambda group: int(group[0]))


def _neighbours(points: Floats, members: list[Ints], link_m: float) -> tuple[Ints, Ints]:
    """Pairs [p, 2] of cells whose points are linked for sure, and such as may be, the nearest first."""
    order, begin = np.concatenate(members), np.cumsum([0, *map(len, members[:-1])])
    low, high = (reduce.reduceat(points[order], begin) for reduce in (np.minimum, np.maximum))
    # Two cells farther is as far as a gap reaches.
    near = cKDTree(np.floor(low / (_CELL * link_m))).query_pairs(2.5, p=np.inf, output_type="ndarray")
    a, b = near.T
    most = np.linalg.norm(np.maximum(high[a], high[b]) - np.minimum(low[a], low[b]), axis=1)
    least = np.linalg.norm(np.maximum(np.maximum(low[a] - high[b], low[b] - high[a]), 0.0), axis=1)
    doubtful = np.flatnonzero((most > link_m) & (least <= link_m))
    return near[most <= link_m], near[doubtful[least[doubtful].argsort(kind="stable")]]


def _gap(some: Floats, others: Floats) -> float:
    """The least distance between two sets of points."""
    fewer, more = sorted((some, others), key=len)
    return float(np.min(cKDTree(more).query(fewer)[0]))


def thin_out(points: Floats) -> Floats:
    """A few of `points` [n, 3] that show where all of them are: the first in each cell of a grid, at most 64.

    The grid has 2 m, or is as much coarser as it takes.
    """
    cell_m = 2.0
    while True:
        _, first = np.unique(np.floor(points / cell_m), axis=0, return_index=True)
        if len(first) <= _MOST_SHOWN:
            return points[np.sort(first)]
        cell_m *= 2
