"""A bounding volume hierarchy over boxes, of a layout that depends on their number alone.

MuJoCo's own is built by its compiler; models that are filled afterwards need one of the same size.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from reachtest.records import Floats


def bounding_tree(low: Floats, high: Floats) -> tuple[Floats, NDArray[np.int32], NDArray[np.int32]]:
    """Nodes of a binary tree over boxes [N, 3]: centre and half extents [2N - 1, 6], children [2N - 1, 2] (-1: a
    leaf), and the box of each leaf [2N - 1] (-1: an inner node)."""
    shape = _shape(len(low))
    order = np.arange(len(low))
    middle = (low + high) / 2
    for segments in shape.levels:
        # Halve every segment of this level across its longest side.
        owner = np.repeat(np.arange(len(segments) - 1), np.diff(segments))
        some = middle[order]
        spread = np.maximum.reduceat(some, segments[:-1]) - np.minimum.reduceat(some, segments[:-1])
        key = some[np.arange(len(order)), spread.argmax(axis=1)[owner]]
        order = order[np.lexsort((key, owner))]
    boxes = np.empty((len(shape.begin), 6))
    bottom = np.minimum.reduceat(np.append(low[order], low[:1], axis=0), shape.ranges)[::2]
    top = np.maximum.reduceat(np.append(high[order], high[:1], axis=0), shape.ranges)[::2]
    boxes[:, :3], boxes[:, 3:] = (bottom + top) / 2, (top - bottom) / 2
    leaves = np.where(shape.child[:, 0] < 0, order[shape.begin], -1).astype(np.int32)
    return boxes, shape.child, leaves


class _Shape:
    """Which nodes there are for N boxes, and which stretch of the sorted boxes each holds."""

    def __init__(self, count: int) -> None:
        begin, end, child = [0], [count], [(-1, -1)]
        level, levels = [0], []
        while any(end[node] - begin[node] > 1 for node in level):
            levels.append(np.array([begin[node] for node in level] + [count]))
            following: list[int] = []
            for node in level:
                if end[node] - begin[node] < 2:
                    following.append(node)
                    continue
                middle = (begin[node] + end[node] + 1) // 2
                child[node] = (len(begin), len(begin) + 1)
                following += child[node]
                begin += [begin[node], middle]
                end += [middle, end[node]]
                child += [(-1, -1), (-1, -1)]
            level = following
        self.levels = levels
        self.begin = np.array(begin)
        self.ranges = np.stack([begin, end], axis=1).ravel()
        self.child = np.array(child, dtype=np.int32)


@lru_cache(maxsize=4)
def _shape(count: int) -> _Shape:
    return _Shape(count)
