"""Closed convex parts among triangles: what editors and generators write as boxes, wedges and pyramids.

Shape legend: F triangles, K closed runs of n triangles each.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from reachtest.geometry import triangle_normals
from reachtest.records import Bools, Floats, Ints
from reachtest.world.pieces import CORNERS

MOST_CORNERS = 64  # a pillar with 32 sides; more are better off as their sides, of which few are near
MOST_TRIANGLES = 2 * MOST_CORNERS - 4  # of a closed surface without holes: Euler's formula
FLAT_M = 1e-4  # how far a corner may be in front of a face: a tenth of the contact's own slack
THICK_M = 0.03  # thinner than a triangle's own prism a solid is better off as its sides


def weld(triangles: Floats) -> Ints:
    """Vertex numbers [F, 3]: equal ones lie at the very same place."""
    bits = np.ascontiguousarray(triangles + 0.0).reshape(-1, 3).view([("", np.float64)] * 3).ravel()
    return np.unique(bits, return_inverse=True)[1].reshape(-1, 3).astype(np.int64)


def convex_solids(triangles: Floats, vertex: Ints, hollow: Floats) -> Iterator[tuple[Ints, int, Floats]]:
    """The closed convex runs of `triangles` seen from outside: their first triangles [K], how many
    triangles each has, and corners [K, C, 3]. Those around one of the points `hollow` [m, 3] are left out.

    `vertex` [F, 3] are the triangles' vertex numbers. Where there are fewer than C corners the last is repeated.
    """
    begin, length = _closed_runs(vertex)
    for n in np.unique(length[(length >= 4) & (length <= MOST_TRIANGLES)]).tolist():
        starts = begin[length == n]
        runs = triangles[starts[:, None] + np.arange(n)]  # [K, n, 3, 3]
        names = vertex[starts[:, None] + np.arange(n)].reshape(len(starts), -1)
        good = np.flatnonzero(_convex(runs) & ~_around(runs, hollow))
        if len(good):
            yield starts[good], n, _corners(runs[good].reshape(len(good), -1, 3), names[good])


def _closed_runs(vertex: Ints) -> tuple[Ints, Ints]:
    """The shortest runs of triangles [F, 3] that are closed surfaces: first triangles [K] and lengths [K], ascending.

    Every edge gets a number that turns negative with its direction; a run is closed where the sum over its
    triangles is nothing. (A sum that vanishes by chance, once in 2^64, would not be convex.)
    """
    a, b = vertex, np.roll(vertex, -1, axis=1)
    rng = np.random.default_rng(0)
    key = rng.integers(-(2**63), 2**63 - 1, (2, int(vertex.max(initial=0)) + 1), dtype=np.int64)
    with np.errstate(over="ignore"):
        edge = key[0][a] * key[1][b] - key[0][b] * key[1][a]
        total = np.concatenate([[0], np.cumsum(edge.sum(axis=1))])
    order = np.argsort(total, kind="stable")
    same = total[order][1:] == total[order][:-1]
    begin, end = order[:-1][same], order[1:][same]
    by_place = np.argsort(begin)
    return begin[by_place], (end - begin)[by_place]


def _convex(runs: Floats) -> Bools:
    """Which runs [K, n, 3, 3] lie behind every one of their faces, and are no thin shells."""
    count, n = runs.shape[:2]
    normals = triangle_normals(runs.reshape(-1, 3, 3))[0].reshape(count, n, 3)
    points = runs.reshape(count, -1, 3)
    height = (
        np.einsum("kpd,knd->knp", points, normals)
        - np.einsum("knd,knd->kn", runs[:, :, 0], normals)[..., None]
    )
    behind = height.max(axis=(1, 2)) < FLAT_M
    return np.asarray(behind & (height.min(axis=2).max(axis=1) < -THICK_M))


def _around(runs: Floats, hollow: Floats) -> Bools:
    """Which convex runs [K, n, 3, 3] have one of the points [m, 3] in them."""
    count, n = runs.shape[:2]
    normals = triangle_normals(runs.reshape(-1, 3, 3))[0].reshape(count, n, 3)
    height = (
        np.einsum("md,knd->knm", hollow, normals)
        - np.einsum("knd,knd->kn", runs[:, :, 0], normals)[..., None]
    )
    inside: Bools = np.asarray((height < 0).all(axis=1))
    return np.asarray(inside.any(axis=1))


def _corners(points: Floats, names: Ints) -> Floats:
    """The distinct points [K, C, 3] of [K, p, 3], told apart by `names` [K, p]; the last is repeated."""
    order = np.argsort(names, axis=1, kind="stable")
    ordered = np.take_along_axis(names, order, axis=1)
    fresh = np.concatenate([np.ones((len(names), 1), dtype=np.bool_), np.diff(ordered, axis=1) > 0], axis=1)
    place = np.cumsum(fresh, axis=1) - 1
    result = np.empty((len(names), max(CORNERS, int(fresh.sum(axis=1).max())), 3))
    last = np.take_along_axis(order, fresh.shape[1] - 1 - fresh[:, ::-1].argmax(axis=1)[:, None], axis=1)
    result[:] = points[np.arange(len(names))[:, None], last]
    row, column = np.nonzero(fresh)
    result[row, place[row, column]] = points[row, order[row, column]]
    return result
