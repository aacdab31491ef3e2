"""Triangles that share an edge: which two make one flat piece, and how far prisms stand back where they meet.

Shape legend: F triangles, E candidate pairs.
"""

from __future__ import annotations

import numpy as np

from reachtest.geometry import triangle_normals
from reachtest.records import Bools, Floats, Ints
from reachtest.world.pieces import PRISM_M
from reachtest.world.solids import FLAT_M


class CommonEdges:
    """Which triangles meet at an edge, in opposite directions as neighbours of one surface do."""

    def __init__(self, triangles: Floats, vertex: Ints) -> None:
        """Of `triangles` [F, 3, 3] with vertex numbers [F, 3]."""
        self._triangles = triangles
        self._count = count = len(triangles)
        begin, end = vertex.ravel(), np.roll(vertex, -1, axis=1).ravel()
        key = int(vertex.max(initial=0)) + 1
        forward, backward = begin * key + end, end * key + begin
        order = np.argsort(forward, kind="stable")
        place = np.minimum(np.searchsorted(forward[order], backward), max(3 * count - 1, 0))
        twin = order[place] if count else order
        self._mine = np.flatnonzero(
            forward[twin] == backward
        )  # edges: triangle * 3 + the corner they begin at
        self._twin = twin[self._mine]
        self._normals = triangle_normals(triangles)[0]
        self.inset = self._insets()

    def _insets(self) -> Floats:
        """How far [F, 3] the lower side of each triangle's prism has to stand back from each of its edges [m].

        Where two faces meet at less than a right angle the prism of the one would stick out of the other, and who
        walks up a ramp would stop at the back of its upper end. Not where they meet the other way round, in a notch.
        """
        result = np.zeros(3 * self._count)
        one, two = self._normals[self._mine // 3], self._normals[self._twin // 3]
        cos = np.einsum("ed,ed->e", one, two)
        apex = np.roll(self._triangles, -2, axis=1).reshape(-1, 3)[self._twin]
        behind = np.einsum("ed,ed->e", apex - self._triangles.reshape(-1, 3)[self._mine], one) < -FLAT_M
        acute = behind & (cos < 0)
        sin = np.sqrt(np.maximum(1 - cos[acute] ** 2, 1e-6))
        result[self._mine[acute]] = PRISM_M * -cos[acute] / sin
        return result.reshape(-1, 3)

    def quadrilaterals(self) -> tuple[Floats, Ints, Floats]:
        """Convex quadrilaterals [n, 4, 3] of two triangles of one plane, those triangles [n, 2], and the insets [n, 4].

        Rectangles come first, then those with the longest common edge; what is paired is not paired again.
        """
        pairs = np.stack([self._mine, self._twin], axis=1) // 3
        once = pairs[:, 0] < pairs[:, 1]
        mine, twin, pairs = self._mine[once], self._twin[once], pairs[once]
        points = self._triangles.reshape(-1, 3)
        following, apex = _turn(mine, 1), _turn(mine, 2)
        quads = points[np.stack([apex, mine, _turn(twin, 2), twin], axis=1)]
        insets = self.inset.ravel()[np.stack([apex, _turn(twin, 1), _turn(twin, 2), following], axis=1)]
        good = np.flatnonzero(_flat_and_convex(quads))
        length = np.linalg.norm(quads[good, 1] - quads[good, 3], axis=1)
        rank = (pairs[good, 1], pairs[good, 0], -length.round(6), ~is_rectangle(quads[good]))
        good = good[np.lexsort(rank)]
        chosen = good[_matching(pairs[good], self._count)]
        return quads[chosen], pairs[chosen], insets[chosen]


def _turn(edge: Ints, by: int) -> Ints:
    """The edges (triangle * 3 + corner) of the same triangles, so many corners on."""
    return edge - edge % 3 + (edge + by) % 3


def _flat_and_convex(quads: Floats) -> Bools:
    """Which quadrilaterals [E, 4, 3] lie in a plane and turn the same way at every corner."""
    sides = np.roll(quads, -1, axis=1) - quads
    turns = np.cross(np.roll(sides, 1, axis=1), sides)
    normal = turns.sum(axis=1)
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
    height = ((quads - quads.mean(axis=1, keepdims=True)) * normal[:, None]).sum(axis=2)
    longest = np.linalg.norm(sides, axis=2).max(axis=1)
    convex = (turns * normal[:, None]).sum(axis=2).min(axis=1) >= -1e-9 * longest
    return np.asarray((np.abs(height).max(axis=1) < FLAT_M) & convex)


def is_rectangle(quads: Floats) -> Bools:
    """Which quadrilaterals [E, 4, 3] are rectangles: diagonals of a length that halve each other."""
    halve = np.abs(quads[:, 0] + quads[:, 2] - quads[:, 1] - quads[:, 3]).max(axis=1) < FLAT_M
    first = np.linalg.norm(quads[:, 0] - quads[:, 2], axis=1)
    second = np.linalg.norm(quads[:, 1] - quads[:, 3], axis=1)
    return np.asarray(halve & (np.abs(first - second) < FLAT_M))


def _matching(pairs: Ints, count: int) -> Ints:
    """Pairs [E, 2] taken in order unless one of the two is taken: the indices of those taken."""
    taken: list[Ints] = []
    open_ = np.arange(len(pairs))
    while len(open_):
        # Who is the first choice of both its triangles would be taken by going through them one by one.
        first = np.full(count, len(pairs))
        np.minimum.at(first, pairs[open_].ravel(), np.repeat(open_, 2))
        mutual = (first[pairs[open_]] == open_[:, None]).all(axis=1)
        taken.append(open_[mutual])
        used = np.zeros(count, dtype=np.bool_)
        used[pairs[open_[mutual]].ravel()] = True
        open_ = open_[~used[pairs[open_]].any(axis=1)]
    return np.sort(np.concatenate(taken)) if taken else np.empty(0, dtype=np.int64)
