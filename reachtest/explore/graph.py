"""The graph of all transitions: what leads where.

Shape legend: N places, E transitions, S state size.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import breadth_first_order

from reachtest.geometry import unpack_heights
from reachtest.records import Bools, Floats, Ints

UNKNOWN = np.iinfo(np.int32).min
OUT = 0  # the key of the place outside of the world: no cell has it
LYING = 1 << 19  # cells higher than any level is: the keys of places to lie in


@dataclass(frozen=True)
class Graph:
    """The transitions as they stand: places by ascending key; the first is OUT."""

    keys: Ints  # [N]
    places: Floats  # [N, 3] where the character first stood in each
    origins: NDArray[
        np.int32
    ]  # [N, 5] how it got there, as in `Origin`; parent `UNKNOWN` where probes found it
    states: Floats  # [N, S] of the character at the end of that; NaN where nothing was done yet
    ends: Ints  # [E, 2] rows of `keys`: from, to

    def leads_to(self, goals: Bools) -> Bools:
        """Which places [N] some transitions lead from to one of `goals` [N]."""
        return _spread(self.ends[:, ::-1], goals)

    def led_to_from(self, starts: Bools) -> Bools:
        """Which places [N] some transitions lead to from one of `starts` [N]."""
        return _spread(self.ends, starts)

    @cached_property
    def is_out(self) -> Bools:
        """[N]"""
        return np.asarray(self.keys == OUT, dtype=np.bool_)


def lies(keys: Ints) -> Bools:
    """Whether `keys` [n] are of places where somebody lay."""
    return np.asarray(unpack_heights(keys) >= LYING // 2, dtype=np.bool_)


def _spread(ends: Ints, sources: Bools) -> Bools:
    """What [N] is found from `sources` [N] along `ends` [E, 2], those included."""
    count, first = len(sources), np.flatnonzero(sources)
    start = np.concatenate([ends[:, 0], np.full(len(first), count)])  # from one more place to all sources
    end = np.concatenate([ends[:, 1], first])
    shape = (count + 1, count + 1)
    graph = csr_matrix((np.ones(len(start), dtype=np.int8), (start, end)), shape=shape)
    found = np.zeros(count + 1, dtype=np.bool_)
    found[breadth_first_order(graph, count, return_predecessors=False)] = True
    return found[:count]
