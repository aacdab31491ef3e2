"""What triangles collide as: convex pieces, as few as cover exactly the same space.

A triangle is a thin prism, extruded against its normal. Two triangles of one plane that make a convex quadrilateral
are one piece, and if it is a rectangle, a box; the twelve triangles of a closed box are that box.

Shape legend: F triangles, N pieces, E candidate pairs.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from reachtest.geometry import triangle_normals
from reachtest.records import Bools, Floats, Ints

PRISM_M = 0.03  # thick enough to be hit by walking characters, thin enough for double-sided walls
MIN_ALTITUDE_M = 1e-3  # thinner slivers make no convex hull; the gap they leave is as thin
FLAT_M = (
    1e-4  # how far out of the plane, or of the rectangle, a corner may be: a tenth of the contact's own slack
)
CORNERS = 8


@dataclass(frozen=True)
class Pieces:
    """Convex pieces, each the hull of `corners`; a box where `half` says so."""

    corners: Floats  # [N, 8, 3] a prism of three sides repeats two of them
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
        return Pieces(self.corners[ids], self.half[ids], self.axes[ids])


def pieces_of(triangles: Floats, hollow: Floats | None = None) -> Pieces:
    """Convex pieces of `triangles` [F, 3, 3], in the order of their first triangle. Slivers are left out.

    A closed box around one of the points `hollow` [n, 3] keeps its six sides: somebody starts in there.
    """
    triangles = usable_triangles(triangles)
    boxes = closed_boxes(triangles)
    if hollow is not None:
        boxes = boxes[~_hold(triangles, boxes, hollow)]
    left = np.ones(len(triangles), dtype=np.bool_)
    left[_run(boxes)] = False
    rest = np.flatnonzero(left)
    quads, pairs = quadrilaterals(triangles[rest])
    single = np.setdiff1d(np.arange(len(rest)), pairs)
    made = [
        _solid_boxes(triangles, boxes),
        _thin(quads),
        _thin(triangles[rest[single]][:, [0, 1, 2, 2]]),
    ]
    first = np.concatenate([boxes, rest[pairs.min(axis=1)], rest[single]])
    every = Pieces(
        *(np.concatenate([getattr(p, name) for p in made]) for name in ("corners", "half", "axes"))
    )
    return every.take(np.argsort(first, kind="stable"))


def usable_triangles(triangles: Floats) -> Floats:
    """The triangles [F, 3, 3] that are not slivers."""
    _, area = triangle_normals(triangles)
    longest = np.linalg.norm(triangles - np.roll(triangles, 1, axis=1), axis=2).max(axis=1)
    return triangles[2 * area > MIN_ALTITUDE_M * np.maximum(longest, 1e-12)]


def closed_boxes(triangles: Floats) -> Ints:
    """First triangles [n] of the runs of twelve that are a closed box seen from outside.

    Generators and editors write a box's triangles one after the other. A room seen from inside is no box.
    """
    if len(triangles) < 12:
        return np.empty(0, dtype=np.int64)
    runs = np.lib.stride_tricks.sliding_window_view(triangles, 12, axis=0)  # [n, 3, 3, 12]
    low, high = runs.min(axis=(1, 3)), runs.max(axis=(1, 3))
    on_corner = (np.abs(runs - low[:, None, :, None]) < FLAT_M) | (
        np.abs(runs - high[:, None, :, None]) < FLAT_M
    )
    size = high - low
    likely = np.flatnonzero(on_corner.all(axis=(1, 2, 3)) & (size > PRISM_M).all(axis=1))
    chosen: list[int] = []
    following = 0
    for start in likely.tolist():
        if start >= following and _is_box(triangles[start : start + 12], size[start]):
            chosen.append(start)
            following = start + 12
    return np.array(chosen, dtype=np.int64)


def _is_box(run: Floats, size: Floats) -> bool:
    normals, area = triangle_normals(run)
    centre = run.reshape(-1, 3).mean(axis=0)
    outward = ((run.mean(axis=1) - centre) * normals).sum(axis=1) > 0
    axis = np.abs(normals).argmax(axis=1) * 2 + (normals.max(axis=1) > 0.5)
    each = np.bincount(axis, weights=area, minlength=6)
    faces = np.repeat([size[1] * size[2], size[0] * size[2], size[0] * size[1]], 2)
    return bool(
        outward.all() and np.allclose(each, faces, rtol=1e-3) and (np.bincount(axis, minlength=6) == 2).all()
    )


def _run(starts: Ints) -> Ints:
    """The twelve triangles [n, 12] of each box."""
    return starts[:, None] + np.arange(12)


def _extents(triangles: Floats, starts: Ints) -> tuple[Floats, Floats]:
    corners = triangles[_run(starts)].reshape(len(starts), 36, 3)
    return corners.min(axis=1, initial=np.inf), corners.max(axis=1, initial=-np.inf)


def _hold(triangles: Floats, starts: Ints, points: Floats) -> Bools:
    """Which boxes [n] have one of `points` [m, 3] in them."""
    low, high = (side[:, None] for side in _extents(triangles, starts))
    inside: Bools = np.asarray(((points > low) & (points < high)).all(axis=2))
    return np.asarray(inside.any(axis=1))


def _solid_boxes(triangles: Floats, starts: Ints) -> Pieces:
    low, high = _extents(triangles, starts)
    pick = np.array([[i, j, k] for i in (0, 1) for j in (0, 1) for k in (0, 1)])
    corners = np.where(pick[None] == 1, high[:, None], low[:, None])
    return Pieces(corners, (high - low) / 2, np.broadcast_to(np.eye(3), (len(starts), 3, 3)))


def quadrilaterals(triangles: Floats) -> tuple[Floats, Ints]:
    """Convex quadrilaterals [n, 4, 3] of two triangles of one plane, and those triangles [n, 2].

    Rectangles come first, then those with the longest common edge; what is paired is not paired again.
    """
    none = np.empty((0, 4, 3)), np.empty((0, 2), dtype=np.int64)
    if len(triangles) < 2:
        return none
    pairs, quads = _common_edges(triangles)
    good = _flat_and_convex(quads)
    pairs, quads = pairs[good], quads[good]
    if not len(pairs):
        return none
    length = np.linalg.norm(quads[:, 1] - quads[:, 3], axis=1)
    order = np.lexsort((pairs[:, 1], pairs[:, 0], -length.round(6), ~is_rectangle(quads)))
    pairs, quads = pairs[order], quads[order]
    chosen = _matching(pairs, len(triangles))
    return quads[chosen], pairs[chosen]


def _common_edges(triangles: Floats) -> tuple[Ints, Floats]:
    """Pairs [E, 2] of triangles that share an edge in opposite directions, and the quadrilaterals [E, 4, 3]."""
    _, vertex = np.unique(triangles.reshape(-1, 3), axis=0, return_inverse=True)
    corner = vertex.reshape(-1, 3)
    begin, end = corner.ravel(), np.roll(corner, -1, axis=1).ravel()
    apex = np.roll(triangles, -2, axis=1).reshape(-1, 3)  # opposite to the edge that begins at each corner
    owner = np.repeat(np.arange(len(triangles)), 3)
    count = int(corner.max()) + 1
    forward, backward = begin.astype(np.int64) * count + end, end.astype(np.int64) * count + begin
    order = np.argsort(forward, kind="stable")
    place = np.searchsorted(forward[order], backward)
    place = np.minimum(place, len(order) - 1)
    twin = order[place]
    mine = np.flatnonzero((forward[twin] == backward) & (owner < owner[twin]))
    other = twin[mine]
    points = triangles.reshape(-1, 3)
    quads = np.stack([apex[mine], points[mine], apex[other], points[other]], axis=1)
    return np.stack([owner[mine], owner[other]], axis=1), quads


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


def _thin(quads: Floats) -> Pieces:
    """Prisms of convex polygons [n, 4, 3] (the last corner of a triangle stands twice)."""
    sides = np.roll(quads, -1, axis=1) - quads
    normal = np.cross(sides[:, 0], quads[:, 2] - quads[:, 0]) + np.cross(
        quads[:, 2] - quads[:, 0], quads[:, 3] - quads[:, 0]
    )
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
    corners = np.concatenate([quads, quads - PRISM_M * normal[:, None]], axis=1)
    box = is_rectangle(quads) & (np.linalg.norm(sides, axis=2).min(axis=1) > MIN_ALTITUDE_M)
    half = np.full((len(quads), 3), np.nan)
    half[box, 0] = np.linalg.norm(sides[box, 0], axis=1) / 2
    half[box, 1] = np.linalg.norm(sides[box, 1], axis=1) / 2
    half[box, 2] = PRISM_M / 2
    axes = np.tile(np.eye(3), (len(quads), 1, 1))
    along = sides[box, 0] / np.maximum(2 * half[box, :1], 1e-12)
    across = np.cross(normal[box], along)
    axes[box] = np.stack([along, across, normal[box]], axis=2)
    return Pieces(corners, half, axes)
