"""Geometry kernels that several stages need: all vectorised, all exact up to rounding.

Shape legend: n queries, F triangles. Coordinates are metres, z up, float64.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from reachtest.records import Bools, Floats, Ints

_MAX_COLUMNS = 4_000_000  # keeps the dense column table of a 5 km level below 32 MB
_MAX_MEMBERS = 1 << 25  # likewise of its entries, where many triangles span many columns: below 1 GB
_PAIRS_AT_ONCE = 1 << 20  # bounds the memory of one vectorised pass to about 100 MB
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
    step = max(1, _PAIRS_AT_ONCE // len(triangles))
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


class Columns:
    """Triangles by the cells of a horizontal grid: each stands in every cell within `reach_m` of its box."""

    def __init__(self, triangles: Floats, reach_m: float, cell_m: float) -> None:
        """Index triangles [F, 3, 3]; the cells are as small as `cell_m` where that is not too many of them."""
        flat = triangles[:, :, :2]
        low, high = flat.min(axis=1) - reach_m, flat.max(axis=1) + reach_m
        self._low = low.min(axis=0) if len(flat) else np.zeros(2)
        extent = high.max(axis=0) - self._low if len(flat) else np.zeros(2)
        # Along one axis the grid may be a single cell: then the other one alone must not be too long.
        cell_m = max(cell_m, float(np.sqrt(extent.prod() / _MAX_COLUMNS)), float(extent.max()) / _MAX_COLUMNS)
        first, span = self._grid(low, high, extent, cell_m)
        while span.prod(axis=1).sum() > _MAX_MEMBERS + 4 * len(flat):
            cell_m *= 2
            first, span = self._grid(low, high, extent, cell_m)
        row, place = expand(span.prod(axis=1))
        key = (first[row, 0] + place // span[row, 1]) * self._shape[1] + first[row, 1] + place % span[row, 1]
        order = np.argsort(key, kind="stable")
        self._members = row[order].astype(np.int32)
        self._start = np.searchsorted(key[order], np.arange(self._shape.prod() + 1))

    def _grid(self, low: Floats, high: Floats, extent: Floats, cell_m: float) -> tuple[Ints, Ints]:
        """Lay the grid in cells of `cell_m`: the first cell of every triangle [F, 2], and how many it spans [F, 2]."""
        self._per_m = 1.0 / cell_m
        self._shape = self._place(extent + self._low).astype(np.int64) + 1
        first = self._place(low).astype(np.int64)
        return first, self._place(high).astype(np.int64) - first + 1

    def near(self, points: Floats) -> tuple[Ints, Ints]:
        """The pairs of a point [n, 3] and a triangle in its cell: rows, triangles."""
        begin, counts = self._cells(points)
        row = np.arange(len(points)).repeat(counts)
        return row, self._members[np.arange(len(row)) + (begin - counts.cumsum() + counts)[row]]

    def pairs(self, points: Floats) -> Iterator[tuple[int, int, Ints, Ints]]:
        """The same of many points [n, 3], a slice at a time: begin, end, rows within the slice, triangles."""
        starts, counts = self._cells(points)
        total, begin = np.cumsum(counts), 0
        while begin < len(points):
            done = total[begin - 1] if begin else 0
            end = max(begin + 1, int(np.searchsorted(total, done + _PAIRS_AT_ONCE)))
            row, place = expand(counts[begin:end])
            yield begin, end, row, self._members[starts[begin:end][row] + place]
            begin = end

    def _place(self, flat: Floats) -> Floats:
        """Where `flat` [n, 2] lie in the grid; the whole part is the cell."""
        return np.asarray((flat - self._low) * self._per_m, dtype=np.float64)

    def _cells(self, points: Floats) -> tuple[Ints, Ints]:
        """Where the members of each point's cell begin [n], and how many they are [n]."""
        place = self._place(points[:, :2])
        known: Bools = np.asarray(((place >= 0) & (place < self._shape)).all(axis=1))
        if not known.all():
            place = np.where(known[:, None], place, 0.0)
        cell = place.astype(np.int64)
        key = cell[:, 0] * self._shape[1] + cell[:, 1]
        begin = self._start[key]
        return begin, (self._start[key + 1] - begin) * known


class ColumnIndex:
    """Finds the surface above or below a point: triangles by the columns of a horizontal grid."""

    def __init__(self, triangles: Floats, cell_m: float = 1.0, min_normal_z: float = 0.05) -> None:
        """Index the triangles [F, 3, 3] that are not walls: |normal z| >= `min_normal_z`."""
        normals, areas = triangle_normals(triangles)
        keep = (np.abs(normals[:, 2]) >= min_normal_z) & (areas > 0)
        kept = triangles[keep]
        self._columns = Columns(kept, 0.0, cell_m)
        # Solved once: two of the barycentric weights and the height are linear in (x, y). One row a triangle, so
        # that a lookup gathers once.
        origin = kept[:, 0]
        u, v = (kept[:, corner] - origin for corner in (1, 2))
        inverse = 1.0 / _cross2(u, v)
        s_xy = np.stack([v[:, 1], -v[:, 0]], axis=1) * inverse[:, None]
        t_xy = np.stack([-u[:, 1], u[:, 0]], axis=1) * inverse[:, None]
        z_xy = s_xy * u[:, 2:] + t_xy * v[:, 2:]
        slope = np.abs(normals[keep, 2:])
        self._solved = np.concatenate([origin, s_xy, t_xy, z_xy, slope], axis=1)  # [F, 10]

    def highest(self, points: Floats, down_m: float | Floats, up_m: float | Floats) -> tuple[Floats, Floats]:
        """Highest surface at (x, y) of each point [n, 3] with z in [z - down_m, z + up_m].

        Returns its z [n] [m], NaN where there is none, and the absolute z of its unit normal [n].
        """
        found, slope = np.full(len(points), np.nan), np.zeros(len(points))
        row, tri = self._columns.near(points)
        solved = self._solved.take(tri, axis=0).T
        x, y, _ = (points.take(row, axis=0) - solved[:3].T).T
        s, t = x * solved[3] + y * solved[4], x * solved[5] + y * solved[6]
        z = solved[2] + x * solved[7] + y * solved[8]
        low, high = (points[:, 2] - down_m)[row], (points[:, 2] + up_m)[row]
        edge = -1e-9  # so that a point on a shared edge belongs to one of the two at least
        hit = indices((s >= edge) & (t >= edge) & (s + t <= 1 - edge) & (z >= low) & (z <= high))
        upwards = hit[z[hit].argsort(kind="stable")]
        found[row[upwards]], slope[row[upwards]] = (
            z[upwards],
            solved[9, upwards],
        )  # the last one written stays
        return found, slope


def _cross2(a: Floats, b: Floats) -> Floats:
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
