"""Geometry kernels that several stages need: all vectorised, all exact up to rounding.

Shape legend: n queries, F triangles. Coordinates are metres, z up, float64.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from reachtest.records import Bools, Character, Floats, Ints

PAIRS_AT_ONCE = 1 << 20  # bounds the memory of one vectorised pass to about 100 MB
_REST_M = 0.02
_SLIVER = 1e-12  # height over length: no plane at all


def indices(mask: Bools | np.bool_) -> Ints:
    """Where `mask` [n] is true: `np.flatnonzero` without its three wrappers, for loops that call it often."""
    return np.asarray(mask).nonzero()[0]


def at_rest(moved: Floats) -> Bools:
    """Whether bodies that `moved` so far in each step [T, ...] [m] lie still in it: wedged in, they need not stand.

    Still is who moved hardly in this step and the one before; the top of a jump is one such step at most.
    """
    still: Bools = np.asarray(moved < _REST_M)  # NaN is not
    still[1:] &= still[:-1].copy()
    return still


def grid_surface(points: Floats) -> Floats:
    """Two triangles for each cell of `points` [R, C, 3], seen from above: [2 (R - 1) (C - 1), 3, 3].

    A cell is split from (-x, -y) to (+x, +y), as MuJoCo 4.0 splits its height fields.
    """
    near, far = points[:-1], points[1:]
    right = np.stack([near[:, :-1], near[:, 1:], far[:, 1:]], axis=2)
    left = np.stack([near[:, :-1], far[:, 1:], far[:, :-1]], axis=2)
    return np.stack([right, left], axis=2).reshape(-1, 3, 3)


def triangle_normals(triangles: Floats) -> tuple[Floats, Floats]:
    """Unit normals [F, 3] (right-hand rule; zero where degenerate) and areas [F] [m2]."""
    cross = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    length = np.linalg.norm(cross, axis=1)
    safe = np.where(length > 0, length, 1.0)
    return cross / safe[:, None], length / 2


def point_triangle_distance(points: Floats, triangles: Floats) -> Floats:
    """Distance [n] from `points` [n, 3] to `triangles` [n, 3, 3], pair by pair [m].

    The nearest point lies in the interior (then the plane distance counts) or on one of the edges.
    """
    corners = np.ascontiguousarray(triangles.transpose(1, 2, 0))  # [3, 3, n]: whole rows are fast
    point = np.ascontiguousarray(points.T)
    a, b, c = corners
    edges, aways = (b - a, c - b, a - c), (point - a, point - b, point - c)
    best = np.minimum.reduce(
        [_square_to_segment(away, along) for away, along in zip(aways, edges, strict=True)]
    )
    normal = _cross(edges[0], -edges[2])
    square = _dot(normal, normal)
    longest = np.maximum.reduce([_dot(along, along) for along in edges])
    inside = square > (_SLIVER * longest) ** 2  # a sliver's normal is rounding, and its edges are all of it
    for away, along in zip(aways, edges, strict=True):
        inside &= _dot(_cross(along, away), normal) >= 0
    plane = np.abs(_dot(aways[0], normal)) / np.sqrt(np.where(square > 0, square, 1.0))
    best = np.sqrt(best)
    return np.asarray(np.where(inside, np.minimum(plane, best), best), dtype=np.float64)


def _square_to_segment(away: Floats, along: Floats) -> Floats:
    """Squared distance [n] to segments [3, n] from points at `away` [3, n] of their start."""
    square = _dot(along, along)
    share = np.clip(_dot(away, along) / np.where(square > 0, square, 1.0), 0.0, 1.0)
    left = away - share * along
    return _dot(left, left)


def _dot(u: Floats, v: Floats) -> Floats:
    return np.asarray(u[0] * v[0] + u[1] * v[1] + u[2] * v[2])


def _cross(u: Floats, v: Floats) -> Floats:
    return np.stack([u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]])


def inside_closed_surface(points: Floats, triangles: Floats) -> Bools:
    """Whether `points` [n, 3] lie inside the closed surface `triangles` [F, 3, 3], whatever its orientation.

    Generalised winding number, summed solid angles: Van Oosterom & Strackee, IEEE TBME 30(2), 1983;
    Jacobson et al., SIGGRAPH 2013. Robust to small gaps, unlike counting crossings of a ray.
    """
    result = np.zeros(len(points), dtype=np.bool_)
    low, high = triangles.min(axis=(0, 1)), triangles.max(axis=(0, 1))
    candidates = indices(((points >= low) & (points <= high)).all(axis=1))
    step = max(1, PAIRS_AT_ONCE // len(triangles))
    for begin in range(0, len(candidates), step):
        chosen = candidates[begin : begin + step]
        corners = triangles[None] - points[chosen][:, None, None, :]
        length = np.linalg.norm(corners, axis=3)
        a, b, c = corners[:, :, 0], corners[:, :, 1], corners[:, :, 2]
        la, lb, lc = length[:, :, 0], length[:, :, 1], length[:, :, 2]
        volume = np.einsum("nfi,nfi->nf", a, np.cross(b, c))
        dots = (
            la * lb * lc
            + np.einsum("nfi,nfi->nf", a, b) * lc
            + np.einsum("nfi,nfi->nf", b, c) * la
            + np.einsum("nfi,nfi->nf", c, a) * lb
        )
        winding = np.arctan2(volume, dots).sum(axis=1) / (2 * np.pi)
        result[chosen] = np.abs(winding) > 0.5
    return result


def body_inside(feet: Floats, who: Character, triangles: Floats) -> Bools:
    """Whether characters at `feet` [n, 3] are inside the closed surface `triangles` [F, 3, 3].

    They are when the middle of the body or the centre of its lower sphere is: both are a radius away from any
    surface that it could merely touch.
    """
    inside = np.zeros(len(feet), dtype=np.bool_)
    for height in (who.radius_m, who.height_m / 2):
        inside |= inside_closed_surface(feet + np.array([0.0, 0.0, height]), triangles)
    return inside


def near_from_above(triangles: Floats, ways: Iterable[Floats], within_m: float) -> Bools:
    """Which of `triangles` [F, 3, 3] have their box, seen from above, within `within_m` of one of the ways' [n, 3]."""
    low, high = triangles.min(axis=1)[:, :2], triangles.max(axis=1)[:, :2]
    near = np.zeros(len(triangles), dtype=np.bool_)
    for way in ways:
        from_, to = way[:, :2].min(axis=0) - within_m, way[:, :2].max(axis=0) + within_m
        near |= ((low <= to) & (high >= from_)).all(axis=1)
    return near


def expand(counts: Ints) -> tuple[Ints, Ints]:
    """For ragged rows of `counts` items: the row of every item, and its place within the row."""
    row = np.repeat(np.arange(len(counts)), counts)
    return row, np.arange(len(row)) - np.repeat(np.cumsum(counts) - counts, counts)


def pack_cells(cells: Ints) -> Ints:
    """One integer [n] for each cell [n, 3] of a grid, from -2^20 to 2^20 along each axis: 1,000 km at 1 m."""
    whole = cells + (1 << 20)
    return np.asarray((whole[:, 0] << 42) | (whole[:, 1] << 21) | whole[:, 2], dtype=np.int64)


def unpack_heights(keys: Ints) -> Ints:
    """The cells' third index [n] again."""
    return np.asarray((keys & ((1 << 21) - 1)) - (1 << 20), dtype=np.int64)
