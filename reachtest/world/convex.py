"""A level's triangles as convex pieces, as few as cover exactly the same space.

A triangle is a thin prism, extruded against its normal. Two triangles of one plane that make a convex quadrilateral
are one piece, and if it is a rectangle, a box. A closed convex part is one solid piece.

Shape legend: F triangles, n pieces, C corners of a piece.
"""

from __future__ import annotations

import numpy as np

from reachtest.geometry import triangle_normals
from reachtest.records import Floats
from reachtest.world.coplanar import CommonEdges
from reachtest.world.pieces import PRISM_M, Pieces, joined
from reachtest.world.prisms import MIN_ALTITUDE_M, prisms
from reachtest.world.solids import FLAT_M, convex_solids, weld


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
    made += [prisms(quads, insets), prisms(triangles[rest[single]], edges.inset[single])]
    return joined(made).take(np.argsort(np.concatenate(first), kind="stable"))


def usable_triangles(triangles: Floats) -> Floats:
    """The triangles [F, 3, 3] that are not slivers."""
    _, area = triangle_normals(triangles)
    longest = np.linalg.norm(triangles - np.roll(triangles, 1, axis=1), axis=2).max(axis=1)
    return triangles[2 * area > MIN_ALTITUDE_M * np.maximum(longest, 1e-12)]


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
