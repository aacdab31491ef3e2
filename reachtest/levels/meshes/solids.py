"""Closed volumes: is a surface closed, and which way does it face?

Shape legend: F triangles, E directed edges.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from reachtest.errors import Problem
from reachtest.levels.meshes.defects import degenerate
from reachtest.levels.meshes.scene import Piece
from reachtest.records import Floats, Frame, Solid

_WELD_M = 1e-5  # corners nearer than this are one: exporters repeat them for every face


@dataclass(frozen=True)
class Leaks:
    """What keeps a surface from enclosing a volume."""

    open_edges: int  # edges with an odd number of faces
    turned_edges: int  # edges whose faces run the same way round
    edges: int
    place: Floats  # [3] middle of the first bad edge

    @property
    def closed(self) -> bool:
        """Whether the surface encloses a volume."""
        return not (self.open_edges or self.turned_edges)


def find_leaks(triangles: Floats) -> Leaks:
    """Check that every edge of `triangles` [F, 3, 3] is used equally often in both directions."""
    corners = triangles.reshape(-1, 3)
    _, first, vertex = np.unique(
        np.round(corners / _WELD_M).astype(np.int64), axis=0, return_index=True, return_inverse=True
    )
    face = vertex.reshape(-1, 3)
    start, end = face.ravel(), np.roll(face, -1, axis=1).ravel()
    proper = start != end
    start, end = start[proper], end[proper]
    key = np.minimum(start, end) * len(first) + np.maximum(start, end)
    edge, place, index, uses = np.unique(key, return_index=True, return_inverse=True, return_counts=True)
    balance = np.bincount(index, weights=np.where(start < end, 1, -1), minlength=len(edge))
    open_ = uses % 2 == 1
    turned = ~open_ & (balance != 0)
    bad = np.flatnonzero(open_ | turned)
    at = place[bad[0]] if len(bad) else 0
    middle = (corners[first[start[at]]] + corners[first[end[at]]]) / 2 if len(start) else np.zeros(3)
    return Leaks(int(open_.sum()), int(turned.sum()), len(edge), middle)


def make_solids(
    name: str, pieces: tuple[Piece, ...], where: str, frame: Frame
) -> tuple[list[Solid], list[Problem]]:
    """One solid for every piece, or one for all of them where they are closed only together."""
    alone = [(piece.name, piece.triangles) for piece in pieces]
    if not all(find_leaks(triangles).closed for _, triangles in alone):
        alone = [(name, np.concatenate([piece.triangles for piece in pieces]))]
        leaks = find_leaks(alone[0][1])
        if not leaks.closed:
            return [], [_problem(leaks, where, frame)]
    return [Solid(label, _outward(triangles[~degenerate(triangles)])) for label, triangles in alone], []


def _outward(triangles: Floats) -> Floats:
    """The same closed surface with its normals outwards, as its signed volume tells."""
    volume = np.einsum("fi,fi->f", triangles[:, 0], np.cross(triangles[:, 1], triangles[:, 2])).sum()
    return triangles if volume >= 0 else triangles[:, ::-1]


def _problem(leaks: Leaks, where: str, frame: Frame) -> Problem:
    place = ", ".join(f"{value:.3g}" for value in frame.to_source(leaks.place))
    if leaks.open_edges:
        found = f"is not watertight: {leaks.open_edges} of {leaks.edges} edges are open, one near ({place})"
        remedy = "close the holes, or give it role: collision"
    else:
        found = f"has {leaks.turned_edges} edges whose faces look opposite ways, one near ({place})"
        remedy = "recalculate the normals to the outside, or give it role: collision"
    return Problem(where, found, remedy)
