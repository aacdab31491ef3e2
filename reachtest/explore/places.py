"""Where to push from: along the nav-mesh's border, and at gaps between its islands that a jump may carry over.

Shape legend: n places, p pieces of the border, F faces, I islands.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from reachtest.explore.actions import heading_of
from reachtest.navmesh.edges import border
from reachtest.navmesh.islands import CLIMB_M, Islands
from reachtest.records import Bools, Character, Floats, Ints

SPACING_M = 2.0  # between places: who pushes at one comes by both sides of it
PIECE_M = 1.0  # of the border: places are chosen among these, evenly to within one
OUTERMOST_M = 8.0  # what goes on behind the border that far may be an alley along the world's end
RUN_UP_M = 2.0  # before a gap: from a standstill most of a character's speed
LANDING_M = 0.4  # behind a gap: not on the very edge
FLOAT_M = 0.1  # a nav-mesh floats, here less and there more
NOWHERE = -1  # the target of places that no island lies opposite


@dataclass(frozen=True)
class Places:
    """Places to push from, and which way."""

    positions: Floats  # [n, 3]
    headings: Ints  # [n] 1 to 8
    island: Ints  # [n] on whose border they are
    target: Ints  # [n] the island on the other side, or NOWHERE

    def on(self, islands: Bools) -> Places:
        """Those on `islands` [I]."""
        kept = islands[self.island]
        return Places(self.positions[kept], self.headings[kept], self.island[kept], self.target[kept])


@dataclass(frozen=True)
class Gaps:
    """Gaps between islands that a jump may carry over."""

    places: Places  # before them, with room to run up
    edges: Floats  # [n, 3] of the nav-mesh on this side
    outwards: Floats  # [n, 2] straight over that edge
    landings: tuple[
        Floats, ...
    ]  # n of [k, 3] a little way into the nav-mesh on the other side, the nearest first

    def on(self, islands: Bools) -> Gaps:
        """Those before which `islands` [I] are."""
        kept = islands[self.places.island]
        landings = tuple(self.landings[number] for number in np.flatnonzero(kept))
        return Gaps(self.places.on(islands), self.edges[kept], self.outwards[kept], landings)


@dataclass(frozen=True)
class _Pieces:
    middles: Floats  # [p, 3]
    outwards: Floats  # [p, 2]
    island: Ints  # [p]


def places_to_push(islands: Islands, connected: Bools, who: Character) -> tuple[Places, Gaps]:
    """Along the border, and at gaps: of the `connected` islands [I] and of those that jumps may lead to from there."""
    navmesh = islands.navmesh
    climb = CLIMB_M if navmesh.agent.climb_m is None else navmesh.agent.climb_m
    middles, outwards, face = border(navmesh, PIECE_M, climb)
    pieces = _Pieces(middles, outwards, islands.labels[face])
    gaps = _gaps(pieces, connected, who)
    likely = _closure(connected, gaps.places)
    return _along(pieces).on(likely), gaps.on(likely)


def outermost(places: Floats, headings: Ints) -> Bools:
    """Which border places [n, 3] look out of the world: farther on that way there is no more border, so no nav-mesh."""
    result = np.zeros(len(places), dtype=np.bool_)
    for heading in np.unique(headings).tolist():
        angle = (heading - 1) * np.pi / 4
        ahead = places[:, :2] @ np.array([np.cos(angle), np.sin(angle)])
        across = places[:, :2] @ np.array([-np.sin(angle), np.cos(angle)])
        _, strip = np.unique(np.rint(across / SPACING_M), return_inverse=True)
        farthest = np.full(strip.max() + 1, -np.inf)
        np.maximum.at(farthest, strip, ahead)
        result |= (headings == heading) & (ahead >= farthest[strip] - OUTERMOST_M)
    return result


def jump_carries(who: Character, away: Floats) -> Bools:
    """Whether a running jump may carry by `away` [n, 3] from border to border, were nothing in the way.

    A ballistic flight; the borders of a nav-mesh keep a radius from the edges.
    """
    rise = away[:, 2] - FLOAT_M
    high_enough = rise <= who.jump_speed_mps**2 / (2 * who.gravity_mps2)
    far = np.hypot(away[:, 0], away[:, 1])
    carried = who.walk_speed_mps * flight_s(who, rise) + 2 * who.radius_m
    return np.asarray(high_enough & (far <= carried), dtype=np.bool_)


def flight_s(who: Character, rise_m: Floats) -> Floats:
    """How long a jump takes that ends `rise_m` higher on its way down; for what is too high, to its apex."""
    over = who.jump_speed_mps**2 - 2 * who.gravity_mps2 * rise_m
    return (who.jump_speed_mps + np.sqrt(np.maximum(over, 0.0))) / who.gravity_mps2


def _along(pieces: _Pieces) -> Places:
    """One of each cell and heading: the two sides of a corner look different ways, and are two places."""
    headings = heading_of(pieces.outwards)
    cell, off = _cells(pieces.middles)
    kept = _first_of(np.column_stack([cell, headings]), off)
    nowhere = np.full(len(kept), NOWHERE)
    return Places(pieces.middles[kept], headings[kept], pieces.island[kept], nowhere)


def _gaps(pieces: _Pieces, connected: Bools, who: Character) -> Gaps:
    """Before gaps between islands that a jump may cross, unless both are connected: of each cell the nearest."""
    apart = np.flatnonzero(~connected[pieces.island])
    reach = who.walk_speed_mps * 2 * who.jump_speed_mps / who.gravity_mps2 + 2 * who.radius_m
    everything, some = cKDTree(pieces.middles.reshape(-1, 3)), cKDTree(pieces.middles[apart].reshape(-1, 3))
    pairs = everything.sparse_distance_matrix(some, reach, output_type="ndarray")
    one, other = pairs["i"], apart[pairs["j"]]
    both = connected[pieces.island[one]]  # pairs of two that are apart come both ways of themselves
    start, end = np.concatenate([one, other[both]]), np.concatenate([other, one[both]])
    away = pieces.middles[end] - pieces.middles[start]
    good = (pieces.island[start] != pieces.island[end]) & jump_carries(who, away)
    start, end, away = start[good], end[good], away[good]
    order = np.lexsort((np.linalg.norm(away, axis=1), pieces.island[end], start))
    start, end, away = start[order], end[order], away[order]
    pair = np.column_stack([start, pieces.island[end]])  # a piece of the border, and an island opposite
    first = np.flatnonzero(np.append(True, (pair[1:] != pair[:-1]).any(axis=1))[: len(pair)])
    cell, _ = _cells(pieces.middles[start[first]])
    kept = _first_of(
        np.column_stack([cell, pair[first, 1]]), np.linalg.norm(away[first], axis=1), start[first]
    )
    begin, stop = first[kept], np.append(first, len(pair))[kept + 1]
    positions, ways = pieces.middles[start[begin]], away[begin, :2]
    above = np.hypot(ways[:, 0], ways[:, 1]) <= FLOAT_M
    ways[above] = pieces.outwards[start[begin]][above]
    positions[:, :2] -= RUN_UP_M * ways / np.linalg.norm(ways, axis=1, keepdims=True)
    inside = pieces.middles[end]
    inside[:, :2] -= LANDING_M * pieces.outwards[end]
    return Gaps(
        Places(positions, heading_of(ways), pieces.island[start[begin]], pair[begin, 1]),
        pieces.middles[start[begin]],
        pieces.outwards[start[begin]],
        tuple(inside[one:last] for one, last in zip(begin.tolist(), stop.tolist(), strict=True)),
    )


def _closure(connected: Bools, gaps: Places) -> Bools:
    """The islands [I] that one may get to from the `connected` ones, jump by jump."""
    result = connected.copy()
    while (new := gaps.target[result[gaps.island] & ~result[gaps.target]]).size:
        result[new] = True
    return result


def _cells(points: Floats) -> tuple[Ints, Floats]:
    """The cell [p, 3] of each point [p, 3], and how far it is from the cell's middle [p] in cells."""
    cell = np.rint(points / SPACING_M).astype(np.int64)
    return cell, np.linalg.norm(points / SPACING_M - cell, axis=1)


def _first_of(key: Ints, *rank: Floats | Ints) -> Ints:
    """The row of every distinct `key` [p, k] that ranks lowest."""
    order = np.lexsort(rank[::-1]) if len(rank) > 1 else np.argsort(rank[0], kind="stable")
    _, first = np.unique(key[order], axis=0, return_index=True)
    return np.asarray(order[first], dtype=np.int64)
