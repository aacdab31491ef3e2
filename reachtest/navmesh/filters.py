"""Which spans are floors for the agent, and how columns beside each other go on: Recast's filters, and slopes.

Shape legend: N spans, n chosen ones.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from reachtest.navmesh.voxels import TOP_BITS, Spans
from reachtest.records import Bools, Ints

OPEN = 1 << (TOP_BITS - 1)  # [cell heights] where nothing is above
DIRECTIONS = ((-1, 0), (0, 1), (1, 0), (0, -1))  # Recast's order; direction d and d + 2 are opposite
_ROUNDING_M = 1e-6


@dataclass(frozen=True)
class VoxelAgent:
    """The character in cells, as rcConfig has it: walkableHeight, walkableClimb, walkableRadius.

    Recast tells slopes from steps by the climb alone, and so wants one that is higher than what a slope rises over a
    cell or two. Where it is not, the slopes of the surfaces tell.
    """

    height: int
    climb: int
    radius: int
    rise: int  # what the steepest slope rises from one cell to the next
    spread: int  # by what the floors around one may differ: the climb in Recast, which may be too little on stairs
    rise_m: float  # likewise, in metres
    rolls_m: float  # what the round bottom meets as a slope that it may walk


def ceiling(spans: Spans) -> Ints:
    """Bottom of the next span in the column [N]; OPEN where there is none."""
    above = np.full(len(spans), OPEN, dtype=np.int64)
    same = spans.column[1:] == spans.column[:-1]
    above[:-1][same] = spans.bottom[1:][same]
    return above


def low_obstacles(spans: Spans, agent: VoxelAgent) -> Bools:
    """Walkable, with what is low enough to step on from the walkable span below it
    (rcFilterLowHangingWalkableObstacles): kerbs and the sides of stairs [N]."""
    walkable = spans.walkable.copy()
    over = spans.walkable[:-1] & (spans.column[1:] == spans.column[:-1])
    walkable[1:] |= over & (spans.top[1:] - spans.top[:-1] <= agent.climb)
    return walkable


def ledges(spans: Spans, above: Ints, walkable: Bools, shape: tuple[int, int], agent: VoxelAgent) -> Bools:
    """Spans [N] beside a drop of more than the climb, or on ground that is steeper than it looks: the floors
    around, as far as they can be stepped on, differ by more than the spread (rcFilterLedgeSpans)."""
    here = np.flatnonzero(walkable)
    columns = Columns(spans.column, spans.top, shape)
    bottom = np.append(spans.bottom, OPEN)
    floor, head = spans.top[here], above[here]
    ledge = np.zeros(len(here), dtype=np.bool_)
    lowest, highest = floor.copy(), floor.copy()
    for direction in DIRECTIONS:
        place, stop, inside = columns.beside(spans.column[here], floor - agent.climb, direction)
        # Below the first span that is not too low lies a drop; does the agent fit through above it?
        gap = np.where(place < stop, bottom[place], OPEN)
        drop = ~inside | (np.minimum(head, gap) - floor >= agent.height)
        ledge |= drop & ~_slopes_down(spans, here, columns, direction, agent)
        for who, at in columns.up_to(place, stop, floor + agent.climb):
            there = spans.top[at]
            fits = np.minimum(head[who], above[at]) - np.maximum(floor[who], there) >= agent.height
            who, there = who[fits], there[fits]
            lowest[who] = np.minimum(lowest[who], there)
            highest[who] = np.maximum(highest[who], there)
    result = np.zeros(len(spans), dtype=np.bool_)
    result[here] = ledge | (highest - lowest > agent.spread)
    return result


def _slopes_down(
    spans: Spans, here: Ints, columns: Columns, direction: tuple[int, int], agent: VoxelAgent
) -> Bools:
    """Which spans `here` [n] go on in `direction` as a slope that falls by more than the climb from cell to cell."""
    result = np.zeros(len(here), dtype=np.bool_)
    if agent.rise > agent.climb:
        floor = spans.top[here]
        place, stop, _ = columns.beside(spans.column[here], floor - agent.rise, direction)
        for who, at in columns.up_to(place, stop, floor - agent.climb):
            result[who] |= spans.walkable[at] & even(spans, here[who], at, direction, agent)
    return result


def even(spans: Spans, here: Ints, there: Ints, direction: tuple[int, int], agent: VoxelAgent) -> Bools:
    """Whether the surfaces of spans `here` and `there` [n], which lies in `direction`, meet where their columns do.

    A surface that ends in a column is drawn on to its end, half a cell at most: slopes may differ by that there.
    """
    axis, sign = (0, direction[0]) if direction[0] else (1, direction[1])
    rate, other = (np.clip(spans.rate[at, axis], -agent.rise_m, agent.rise_m) for at in (here, there))
    gap = np.abs(spans.floor[here] + sign * rate / 2 - spans.floor[there] + sign * other / 2)
    slack = np.maximum((np.abs(rate) + np.abs(other)) / 2, min(agent.rolls_m, agent.rise_m / 2))
    return np.asarray(gap <= slack + _ROUNDING_M, dtype=np.bool_)


class Columns:
    """Finds the spans of a column by height: `column` and, within a column, `top` [N] are in order."""

    def __init__(self, column: Ints, top: Ints, shape: tuple[int, int]) -> None:
        self._shape = shape
        self._top = np.append(top, OPEN)
        self._start = np.append(0, np.cumsum(np.bincount(column, minlength=shape[0] * shape[1])))

    def beside(self, column: Ints, least: Ints, direction: tuple[int, int]) -> tuple[Ints, Ints, Bools]:
        """In the column one step away in `direction`: the first span whose top is `least` or higher, the end of
        the column, both [n]; and whether the grid has such a column."""
        i, j = np.divmod(column, self._shape[1])
        if direction[0]:
            inside = (i > 0) if direction[0] < 0 else (i < self._shape[0] - 1)
        else:
            inside = (j > 0) if direction[1] < 0 else (j < self._shape[1] - 1)
        there = np.where(inside, column + direction[0] * self._shape[1] + direction[1], 0)
        place = self._start[there]
        stop = np.where(inside, self._start[there + 1], place)
        low = np.flatnonzero((place < stop) & (self._top[place] < least))
        while len(low):
            place[low] += 1
            low = low[(place[low] < stop[low]) & (self._top[place[low]] < least[low])]
        return place, stop, inside

    def up_to(self, place: Ints, stop: Ints, most: Ints) -> Iterator[tuple[Ints, Ints]]:
        """From `place` [n] on, lowest first, each span whose top is `most` or lower: of whom, and which."""
        step = 0
        who = np.flatnonzero((place < stop) & (self._top[place] <= most))
        while len(who):
            yield who, place[who] + step
            step += 1
            at = place[who] + step
            who = who[(at < stop[who]) & (self._top[np.minimum(at, len(self._top) - 1)] <= most[who])]
