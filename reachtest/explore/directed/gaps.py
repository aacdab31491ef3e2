"""Gaps between islands of the nav-mesh that a jump may carry over: where it may begin, and where it may land.

Shape legend: n gaps, p pieces of the border, N pairs of them, I islands.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from reachtest.explore.actions import heading_of
from reachtest.explore.directed.places import Pieces, Places, along, cells_of, first_of, pieces_of
from reachtest.navmesh.islands import Islands
from reachtest.records import Bools, Character, Floats, Ints

LANDING_M = 0.4  # behind a gap: not on the very edge
DROP_M = 5.0  # the other side of a gap may lie so much lower
AT_ONCE = 4096  # pieces of the border: a city has many pairs of them
FLOAT_M = 0.1  # a nav-mesh floats, here less and there more
ONTO_FLOOR = 4  # gaps from an island to a floor off the nav-mesh, the shortest: there are many floors


@dataclass(frozen=True)
class Gaps:
    """Gaps between islands that a jump may carry over."""

    places: Places  # at the edge on this side
    outwards: Floats  # [n, 2] straight over that edge
    landings: tuple[Floats, ...]  # n of [k, 3] a little way into the nav-mesh beyond, the nearest first
    own: int  # islands of the nav-mesh: those from there on are floors off it


def places_to_push(
    own: Islands, connected: Bools, who: Character, floors: Islands | None = None
) -> tuple[Places, Gaps]:
    """Along the border of the `connected` islands [own.count] of the nav-mesh and of those that jumps may lead to from
    there; and all gaps, also to and from `floors` off it, whose islands count on from the `own`."""
    border = pieces = pieces_of(own)
    if floors is not None and floors.count:
        pieces = border.and_also(pieces_of(floors), own.count)
        connected = np.append(connected, np.zeros(floors.count, dtype=np.bool_))
    start, end = _leaps(pieces, connected, who)
    reached = _reached(connected, pieces.island[start], pieces.island[end])
    return along(border).on(reached), _gaps(pieces, start, end, own.count)


def jump_carries(who: Character, away: Floats) -> Bools:
    """Whether a running jump may carry by `away` [n, 3] from border to border, were nothing in the way.

    A ballistic flight; the borders of a nav-mesh keep a radius from the edges. Those of floors off it do not: what is
    too far for that is tried in vain.
    """
    rise = away[:, 2] - FLOAT_M
    high_enough = (rise <= who.jump_speed_mps**2 / (2 * who.gravity_mps2)) & (rise >= -DROP_M)
    far = np.hypot(away[:, 0], away[:, 1])
    return np.asarray(high_enough & (far <= _carries_m(who, rise)), dtype=np.bool_)


def _carries_m(who: Character, rise_m: Floats | float) -> Floats:
    return np.asarray(who.walk_speed_mps * flight_s(who, rise_m) + 2 * who.radius_m, dtype=np.float64)


def flight_s(who: Character, rise_m: Floats | float) -> Floats:
    """How long a jump takes that ends `rise_m` higher on its way down; for what is too high, to its apex."""
    over = who.jump_speed_mps**2 - 2 * who.gravity_mps2 * rise_m
    seconds = (who.jump_speed_mps + np.sqrt(np.maximum(over, 0.0))) / who.gravity_mps2
    return np.asarray(seconds, dtype=np.float64)


def _gaps(pieces: Pieces, start: Ints, end: Ints, own: int) -> Gaps:
    """Of pieces `start` [N] in a cell the one from which the way to an island, to pieces `end` [N], is shortest."""
    away = pieces.middles[end] - pieces.middles[start]
    order = np.lexsort((np.linalg.norm(away, axis=1), pieces.island[end], start))
    start, end, away = start[order], end[order], away[order]
    pair = np.column_stack([start, pieces.island[end]])  # a piece of the border, and an island opposite
    first = np.flatnonzero(np.append(True, (pair[1:] != pair[:-1]).any(axis=1))[: len(pair)])
    cell, _ = cells_of(pieces.middles[start[first]])
    far = np.linalg.norm(away[first], axis=1)
    kept = first_of(np.column_stack([cell, pair[first, 1]]), far, start[first])
    between = np.column_stack([pieces.island[start[first[kept]]], pair[first[kept], 1]])
    kept = kept[(between[:, 1] < own) | _among_nearest(between, far[kept])]
    begin, stop = first[kept], np.append(first, len(pair))[kept + 1]
    edge = start[begin]
    ways = away[begin, :2]
    above = np.hypot(ways[:, 0], ways[:, 1]) <= FLOAT_M
    ways[above] = pieces.outwards[edge][above]
    inside = pieces.middles[end]
    inside[:, :2] -= (np.minimum(LANDING_M, _to_middle(pieces))[:, None] * pieces.outwards)[end]
    return Gaps(
        Places(pieces.middles[edge], heading_of(ways), pieces.island[edge], pair[begin, 1]),
        pieces.outwards[edge],
        tuple(inside[one:last] for one, last in zip(begin.tolist(), stop.tolist(), strict=True)),
        own,
    )


def _to_middle(pieces: Pieces) -> Floats:
    """How far inwards from each piece [p] the middle of its island is [m]: one lands no farther in; infinite where that
    is outwards of it."""
    count = np.maximum(np.bincount(pieces.island), 1)[:, None]
    sums = [np.bincount(pieces.island, weights=pieces.middles[:, axis]) for axis in (0, 1)]
    inwards = (
        (pieces.middles[:, :2] - (np.stack(sums, axis=1) / count)[pieces.island]) * pieces.outwards
    ).sum(axis=1)
    return np.where(inwards > 0.0, inwards, np.inf)


def _among_nearest(between: Ints, far: Floats) -> Bools:
    """Which of the gaps [n], each `between` two islands [n, 2] and so `far` [n], are among the shortest of the two."""
    order = np.lexsort((far, between[:, 1], between[:, 0]))
    new = np.append(True, (between[order][1:] != between[order][:-1]).any(axis=1))[: len(order)]
    place = np.arange(len(order))
    result = np.zeros(len(order), dtype=np.bool_)
    result[order] = place - np.maximum.accumulate(np.where(new, place, 0)) < ONTO_FLOOR
    return result


def _reached(connected: Bools, start: Ints, end: Ints) -> Bools:
    """Which islands [I] jumps from islands `start` [N] to `end` [N] lead to from the `connected`, and these."""
    before, reached = np.zeros_like(connected), connected
    while (before != reached).any():
        before, reached = reached, reached.copy()
        reached[end[reached[start]]] = True
    return reached


def _leaps(pieces: Pieces, connected: Bools, who: Character) -> tuple[Ints, Ints]:
    """Pieces of the border [N] that a jump may carry from and to: from any island, since one may get onto it by a way
    that no nav-mesh shows, to any other but the `connected`."""
    apart = np.flatnonzero(~connected[pieces.island])
    reach = float(np.hypot(_carries_m(who, -DROP_M), DROP_M))
    there = cKDTree(pieces.middles[apart].reshape(-1, 3))
    found = [(np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64))]
    for begin in range(0, len(pieces.middles) if len(apart) else 0, AT_ONCE):
        here = cKDTree(pieces.middles[begin : begin + AT_ONCE])
        pairs = here.sparse_distance_matrix(there, reach, output_type="ndarray")
        start, end = begin + pairs["i"], apart[pairs["j"]]
        good = (pieces.island[start] != pieces.island[end]) & jump_carries(
            who, pieces.middles[end] - pieces.middles[start]
        )
        found.append((start[good], end[good]))
    starts, ends = zip(*found, strict=True)
    return np.concatenate(starts), np.concatenate(ends)
