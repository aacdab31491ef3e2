"""What triangles collide as: convex pieces, as few as cover exactly the same space.

A triangle is a thin prism, extruded against its normal. Two triangles of one plane that make a convex quadrilateral
are one piece, and if it is a rectangle, a box. A closed convex part is one solid piece.

Shape legend: F triangles, N pieces, E candidate pairs, C corners of a piece or of a polygon.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from reachtest.geometry import triangle_normals
from reachtest.records import Bools, Floats, Ints
from reachtest.world.solids import CORNERS, FLAT_M, convex_solids, weld

PRISM_M = 0.03  # thick enough to be hit by walking characters, thin enough for double-sided walls
MIN_ALTITUDE_M = 1e-3  # thinner slivers make no convex hull; the gap they leave is as thin
_MOST_INSET = 0.8  # of the way to a polygon's middle: its prism keeps some width below


@dataclass(frozen=True)
class Pieces:
    """Convex pieces, each the hull of `corners`; a box where `half` says so."""

    corners: Floats  # [N, C, 3] where a piece has fewer, its last are repeated
    count: Ints  # [N] corners that are no repetitions
    half: Floats  # [N, 3] half extents of a box along its axes; NaN: not a box
    axes: Floats  # [N, 3, 3] the box's axes as columns, right-handed; identity elsewhere

    def __len__(self) -> int:
        return len(self.corners)

    @property
    def low(self) -> Floats:
        """Smallest coordinates [N, 3]."""
        return np.asarray(self.corners.min(axis=1))

    @property
    def high(self) -> Floats:
        """Largest coordinates [N, 3]."""
        return np.asarray(self.corners.max(axis=1))

    @property
    def is_box(self) -> Bools:
        """Which pieces [N] are boxes."""
        return np.isfinite(self.half[:, 0])

    def take(self, ids: Ints) -> Pieces:
        """The pieces `ids` [n]."""
        return Pieces(self.corners[ids], self.count[ids], self.half[ids], self.axes[ids])


def pieces_of(triangles: Floats, hollow: Floats | None = None) -> Pieces:
    """Convex pieces of `triangles` [F, 3, 3], in the order of their first triangle. Slivers are left out.

    A closed part around one of the points `hollow` [n, 3] keeps its sides: somebody starts in there.
    """
    triangles = usable_triangles(triangles)
    vertex = weld(triangles)
    left = np.ones(len(triangles), dtype=np.bool_)
    first, made = [], []
    for starts, count, corners in convex_solids(
        triangles, vertex, np.empty((0, 3)) if hollow is None else hollow
    ):
        left[(starts[:, None] + np.arange(count)).ravel()] = False
        first.append(starts)
        made.append(_hulls(corners))
    rest = np.flatnonzero(left)
    edges = CommonEdges(triangles[rest], vertex[rest])
    quads, pairs, insets = edges.quadrilaterals()
    single = np.setdiff1d(np.arange(len(rest)), pairs)
    first += [rest[pairs.min(axis=1)], rest[single]]
    made += [_thin(quads, insets), _thin(triangles[rest[single]], edges.inset[single])]
    return _joined(made).take(np.argsort(np.concatenate(first), kind="stable"))


def _joined(parts: list[Pieces]) -> Pieces:
    """All pieces, with room for the corners of the roundest."""
    most = max(part.corners.shape[1] for part in parts)
    corners = [np.pad(p.corners, ((0, 0), (0, most - p.corners.shape[1]), (0, 0)), "edge") for p in parts]
    rest = (np.concatenate([getattr(part, name) for part in parts]) for name in ("count", "half", "axes"))
    return Pieces(np.concatenate(corners), *rest)


def usable_triangles(triangles: Floats) -> Floats:
    """The triangles [F, 3, 3] that are not slivers."""
    _, area = triangle_normals(triangles)
    longest = np.linalg.norm(triangles - np.roll(triangles, 1, axis=1), axis=2).max(axis=1)
    return triangles[2 * area > MIN_ALTITUDE_M * np.maximum(longest, 1e-12)]


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


def _hulls(corners: Floats) -> Pieces:
    """Solid pieces of corners [n, C, 3]; boxes are recognised whichever way they are turned."""
    start = corners[:, :1]
    away = corners - start
    order = np.argsort(np.linalg.norm(away, axis=2), axis=1, kind="stable")
    # Of a box's corner, the three nearest others or two of them and a face's diagonal: try what is at right angles.
    half, axes = np.full((len(corners), 3), np.nan), np.tile(np.eye(3), (len(corners), 1, 1))
    middle = corners.mean(axis=1)
    for second, third in ((2, 3), (2, 4), (3, 4)):
        sides = np.take_along_axis(away, order[:, [1, second, third], None], axis=1)  # [n, 3, 3]
        length = np.linalg.norm(sides, axis=2)
        unit = sides / np.maximum(length, 1e-12)[:, :, None]
        unit[:, 2] *= np.sign(np.linalg.det(unit))[:, None]
        skew = np.abs(np.einsum("nid,njd->nij", unit, unit) - np.eye(3)).max(axis=(1, 2))
        local = np.abs(np.einsum("ncd,nid->nci", corners - middle[:, None], unit)) - length[:, None] / 2
        box = (skew < 1e-6) & (np.abs(local).max(axis=(1, 2)) < FLAT_M) & (length.min(axis=1) > PRISM_M)
        half[box], axes[box] = length[box] / 2, unit[box].transpose(0, 2, 1)
    repeated = (corners == corners[:, -1:]).all(axis=2).sum(axis=1) - 1
    return Pieces(corners, corners.shape[1] - repeated, half, axes)


def _thin(polygons: Floats, insets: Floats) -> Pieces:
    """Prisms of convex polygons [n, C, 3], narrower below where their edges [n, C] have insets."""
    sides = np.roll(polygons, -1, axis=1) - polygons
    length = np.linalg.norm(sides, axis=2)
    along = sides / np.maximum(length, 1e-12)[:, :, None]
    normal = np.cross(sides, np.roll(sides, -1, axis=1)).sum(axis=1)
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
    below = polygons - PRISM_M * normal[:, None] + _moved_in(polygons, along, normal, insets)
    spare = [below[:, -1:]] * (CORNERS - 2 * polygons.shape[1])
    corners = np.concatenate([polygons, below, *spare], axis=1)
    half, axes = np.full((len(polygons), 3), np.nan), np.tile(np.eye(3), (len(polygons), 1, 1))
    if polygons.shape[1] == 4:
        box = is_rectangle(polygons) & (length.min(axis=1) > MIN_ALTITUDE_M) & ~insets.any(axis=1)
        half[box] = np.stack([length[box, 0], length[box, 1], np.full(int(box.sum()), PRISM_M)], axis=1) / 2
        across = np.cross(normal[box], along[box, 0])
        axes[box] = np.stack([along[box, 0], across, normal[box]], axis=2)
    count = np.full(len(polygons), 2 * polygons.shape[1])
    return Pieces(corners, count, half, axes)


def _moved_in(polygons: Floats, along: Floats, normal: Floats, insets: Floats) -> Floats:
    """How the corners [n, C, 3] move when the edges move in by `insets` [n, C], as far as there is room."""
    inward = np.cross(np.broadcast_to(normal[:, None], along.shape), along)
    middle = polygons.mean(axis=1, keepdims=True)
    room = ((middle - polygons) * inward).sum(axis=2)
    worst = (insets / np.maximum(room, 1e-12)).max(axis=1, initial=0.0)
    insets = insets * np.minimum(1.0, _MOST_INSET / np.maximum(worst, 1e-12))[:, None]
    before, width = np.roll(inward, 1, axis=1), np.roll(insets, 1, axis=1)
    # The corner's move x lies in the plane, with x . before = width and x . inward = inset.
    cos = (before * inward).sum(axis=2)
    scale = 1.0 / np.maximum(1 - cos**2, 1e-6)
    a, b = (width - cos * insets) * scale, (insets - cos * width) * scale
    return np.asarray(a[:, :, None] * before + b[:, :, None] * inward)
