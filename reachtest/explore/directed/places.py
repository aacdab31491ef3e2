"""Where to push from: places along the nav-mesh's border.

Shape legend: n places, p pieces of the border, F faces, I islands.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from reachtest.explore.actions import heading_of
from reachtest.navmesh.edges import border
from reachtest.navmesh.islands import Islands, climb_of
from reachtest.records import Bools, Floats, Ints

SPACING_M = 2.0  # between places: who pushes at one comes by both sides of it
PIECE_M = 1.0  # of the border: places are chosen among these, evenly to within one
OUTERMOST_M = 8.0  # what goes on behind the border that far may be an alley along the world's end
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
class Pieces:
    """The border in pieces."""

    middles: Floats  # [p, 3]
    outwards: Floats  # [p, 2]
    island: Ints  # [p]

    def and_also(self, others: Pieces, island: int) -> Pieces:
        """These and `others`, whose islands count on from `island`."""
        return Pieces(
            np.concatenate([self.middles, others.middles]),
            np.concatenate([self.outwards, others.outwards]),
            np.concatenate([self.island, others.island + island]),
        )


def pieces_of(islands: Islands) -> Pieces:
    """The border of the nav-mesh."""
    navmesh = islands.navmesh
    middles, outwards, face = border(navmesh, PIECE_M, climb_of(navmesh))
    return Pieces(middles, outwards, islands.labels[face])


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


def along(pieces: Pieces) -> Places:
    """One of each cell and heading: the two sides of a corner look different ways, and are two places."""
    headings = heading_of(pieces.outwards)
    cell, off = cells_of(pieces.middles)
    kept = first_of(np.column_stack([cell, headings]), off)
    nowhere = np.full(len(kept), NOWHERE)
    return Places(pieces.middles[kept], headings[kept], pieces.island[kept], nowhere)


def cells_of(points: Floats) -> tuple[Ints, Floats]:
    """The cell [p, 3] of each point [p, 3], and how far it is from the cell's middle [p] in cells."""
    cell = np.rint(points / SPACING_M).astype(np.int64)
    return cell, np.linalg.norm(points / SPACING_M - cell, axis=1)


def first_of(key: Ints, *rank: Floats | Ints) -> Ints:
    """The row of every distinct `key` [p, k] that ranks lowest."""
    order = np.lexsort(rank[::-1]) if len(rank) > 1 else np.argsort(rank[0], kind="stable")
    _, first = np.unique(key[order], axis=0, return_index=True)
    return np.asarray(order[first], dtype=np.int64)
