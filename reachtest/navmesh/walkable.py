"""Where the character can stand, and step to from there: what Recast's filters leave, eroded by the radius.

Shape legend: N spans, M walkable places.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from reachtest.navmesh.filters import DIRECTIONS, Columns, VoxelAgent, ceiling, even, ledges, low_obstacles
from reachtest.navmesh.voxels import Spans
from reachtest.records import Bools, Ints

STRAIGHT, DIAGONAL = 2, 3  # lengths of a chamfer distance, in half cells: rcErodeWalkableArea


@dataclass(frozen=True)
class Places:
    """Walkable places, in order of column and height, with their neighbours (rcCompactHeightfield)."""

    span: Ints  # [M] which span
    column: Ints  # [M]
    bottom: Ints  # [M] where the free space begins: the span's top
    top: Ints  # [M] where it ends
    neighbour: Ints  # [4, M] the place one step away in each of DIRECTIONS; -1 where there is none


def walkable_places(spans: Spans, shape: tuple[int, int], agent: VoxelAgent) -> Places:
    """Where the agent can stand without its body touching a wall or hanging over an edge.

    The outermost columns of the grid count as edges.
    """
    above = ceiling(spans)
    walkable = low_obstacles(spans, agent)
    walkable &= ~ledges(spans, above, walkable, shape, agent)
    walkable &= above - spans.top >= agent.height  # rcFilterWalkableLowHeightSpans
    return _eroded(_connected(spans, above, walkable, shape, agent), agent.radius)


def _connected(
    spans: Spans, above: Ints, walkable: Bools, shape: tuple[int, int], agent: VoxelAgent
) -> Places:
    """The walkable spans and who can be stepped to from where (rcBuildCompactHeightfield)."""
    span = np.flatnonzero(walkable)
    column, floor, head = spans.column[span], spans.top[span], above[span]
    columns = Columns(column, floor, shape)
    neighbour = np.full((4, len(span)), -1, dtype=np.int64)
    reach = max(agent.climb, agent.rise)
    for direction, offset in enumerate(DIRECTIONS):
        place, stop, _ = columns.beside(column, floor - reach, offset)
        for who, at in columns.up_to(place, stop, floor + reach):
            free = np.minimum(head[who], head[at]) - np.maximum(floor[who], floor[at]) >= agent.height
            if reach > agent.climb:
                free &= (np.abs(floor[who] - floor[at]) <= agent.climb) | even(
                    spans, span[who], span[at], offset, agent
                )
            free &= neighbour[direction, who] < 0  # the lowest, where there are two
            neighbour[direction, who[free]] = at[free]
    for direction in range(2):  # both see each other, or neither
        back = _mutual(neighbour, direction)
        neighbour[direction + 2] = _mutual(neighbour, direction + 2)
        neighbour[direction] = back
    return Places(span, column, floor, head, neighbour)


def _mutual(neighbour: Ints, direction: int) -> Ints:
    """Neighbours in `direction` [M] that have this place as theirs the other way; -1 for others."""
    there = neighbour[direction]
    returned = neighbour[(direction + 2) % 4][there]
    return np.where((there >= 0) & (returned == np.arange(len(there))), there, -1)


def _eroded(places: Places, radius: int) -> Places:
    """Without the places nearer than `radius` to one that lacks a neighbour (rcErodeWalkableArea)."""
    limit = STRAIGHT * radius
    distance = np.where((places.neighbour < 0).any(axis=0), 0, limit)
    for _ in range(radius):  # each pass carries the distance at least one cell farther
        for direction in range(4):
            step = places.neighbour[direction]
            corner = np.where(step >= 0, places.neighbour[(direction + 3) % 4][step], -1)
            for place, length in ((step, STRAIGHT), (corner, DIAGONAL)):
                distance = np.minimum(distance, np.where(place >= 0, distance[place] + length, limit))
    return chosen(places, distance >= limit)


def chosen(places: Places, keep: Bools) -> Places:
    """Only the places to keep [M], with the neighbours among them."""
    number = np.append(np.where(keep, np.cumsum(keep) - 1, -1), -1)  # the last is for "none"
    return Places(
        places.span[keep],
        places.column[keep],
        places.bottom[keep],
        places.top[keep],
        number[places.neighbour[:, keep]],
    )
