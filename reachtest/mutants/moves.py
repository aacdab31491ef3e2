"""How the character gets from one place of a field to the next: walking, stepping, sliding, dropping, jumping.

Shape legend: N places, M moves, n of them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import breadth_first_order

from reachtest.mutants.field import Field
from reachtest.records import Bools, Ints

_STRAIGHT = ((-1, 0), (1, 0), (0, -1), (0, 1))
_AROUND = (*_STRAIGHT, (-1, -1), (-1, 1), (1, -1), (1, 1))
_STEP_OUT = 4  # [cells] from an edge until the capsule is clear of it: its radius and two


@dataclass(frozen=True)
class Moves:
    """Moves without a jump, by the place they begin at."""

    start: Ints  # [N + 1] first move of each place
    target: Ints  # [M]
    rim: Bools  # [N] places at an edge or a wall
    falls: Bools  # [N] places from which one drops out of the world

    def flood(self, seeds: Ints, barred: Bools | None = None) -> Bools:
        """The places [N] that `seeds` lead to, without going through those that are `barred` [N]."""
        count, every, target = len(self.rim), np.diff(self.start), self.target
        if barred is not None:
            keep = ~(barred[target] | np.repeat(barred, every))
            every = np.bincount(np.repeat(np.arange(count), every)[keep], minlength=count)
            target, seeds = target[keep], seeds[~barred[seeds]]
        ends = np.concatenate(
            [[0], np.cumsum(every), [every.sum() + len(seeds)]]
        )  # one more leads to all seeds
        there = np.concatenate([target, seeds])
        graph = csr_matrix((np.ones(len(there), dtype=np.int8), there, ends), shape=(count + 1, count + 1))
        result = np.zeros(count + 1, dtype=np.bool_)
        result[breadth_first_order(graph, count, return_predecessors=False)] = True
        return result[:count]


def moves_of(field: Field) -> Moves:
    """All moves but jumps."""
    count = len(field.column)
    pairs, sides = [np.zeros((0, 2), dtype=np.int64)], np.zeros(count, dtype=np.int64)
    for direction in _STRAIGHT:
        walked = _walks(field, direction)
        sides[np.unique(walked[:, 0])] += 1
        pairs.append(walked)
    rim = sides < len(_STRAIGHT)
    falls = np.zeros(count, dtype=np.bool_)
    for direction in _AROUND:
        pairs += _drops(field, direction, np.flatnonzero(rim), falls)
    every = np.concatenate(pairs)
    every = every[np.argsort(every[:, 0], kind="stable")]
    return Moves(np.searchsorted(every[:, 0], np.arange(count + 1)), every[:, 1], rim, falls)


def aside(field: Field, column: Ints, direction: tuple[int, int], cells: int = 1) -> tuple[Ints, Bools]:
    """The column [n] some cells away, and whether the grid has it."""
    i, j = np.divmod(column, field.grid.shape[1])
    i, j = i + cells * direction[0], j + cells * direction[1]
    inside = (i >= 0) & (j >= 0) & (i < field.grid.shape[0]) & (j < field.grid.shape[1])
    return np.where(inside, i * field.grid.shape[1] + j, 0), inside


def _walks(field: Field, direction: tuple[int, int]) -> Ints:
    """Pairs of places [n, 2]: from the first one walks, steps or slides to the second, one column away."""
    there, inside = aside(field, field.column, direction)
    first = field.after(there, np.maximum(field.level - field.step, 0))
    column, level = np.append(field.column, -1), np.append(field.level, 0)
    walkable = np.append(field.walkable, False)
    found = []
    for place in (first, np.minimum(first + 1, len(field.column))):
        rise = level[place] - field.level
        ok = inside & (column[place] == there) & (rise <= field.step)
        top = np.maximum(level[place], field.level)
        ok &= field.free[field.column, top] & field.free[there, top]
        ok &= field.walkable | (rise < 0) | ((rise == 0) & walkable[place])  # nobody climbs what is too steep
        found.append(np.stack([np.flatnonzero(ok), place[ok]], axis=1))
    return np.concatenate(found)


def _drops(field: Field, direction: tuple[int, int], rim: Ints, falls: Bools) -> list[Ints]:
    """Pairs of places [n, 2]: stepping out from the first and falling one lands at the second.

    Marks in `falls` [N] from where one lands nowhere.
    """
    pairs, clear = [], np.ones(len(rim), dtype=np.bool_)
    for cells in range(1, _STEP_OUT + 1):
        there, inside = aside(field, field.column[rim], direction, cells)
        clear &= inside & field.free[there, field.level[rim]]
        land = field.land[there, field.level[rim]].astype(np.int64)
        falls[rim[clear & (land < 0)]] = True
        down = np.flatnonzero(clear & (land >= 0) & (land < field.level[rim]))
        place = field.find(there[down], land[down])
        known = place >= 0
        pairs.append(np.stack([rim[down[known]], place[known]], axis=1))
    return pairs
