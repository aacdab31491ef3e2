"""Clusters: which pieces of evidence are one bug."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from reachtest.records import Floats, Ints

_MOST_SHOWN = 64  # of the exits of one finding, in reports and baselines


def single_linkage(points: Floats, link_m: float, ties: Ints | None = None) -> list[Ints]:
    """Groups of `points` [n, 3] connected by gaps of at most `link_m` or by `ties` [t, 2], as ascending indices.

    Groups come in the order of their first point, so that nothing depends on the tree.
    """
    if not len(points):
        return []
    pairs = cKDTree(points).query_pairs(link_m, output_type="ndarray")
    pairs = pairs if ties is None else np.concatenate([pairs, ties])
    ones = np.ones(len(pairs), dtype=np.int8)
    graph = coo_matrix((ones, (pairs[:, 0], pairs[:, 1])), shape=(len(points), len(points)))
    _, label = connected_components(graph, directed=False)
    _, first = np.unique(label, return_index=True)
    return [np.flatnonzero(label == label[i]) for i in np.sort(first)]


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
