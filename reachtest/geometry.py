"""Geometry kernels that several stages need: all vectorised, all exact up to rounding.

Shape legend: n queries, F triangles. Coordinates are metres, z up, float64.
"""

from __future__ import annotations

import numpy as np

from reachtest.records import Bools, Floats, Ints

_MAX_COLUMNS = 4_000_000  # keeps the dense column table of a 5 km level below 32 MB
_CHILDREN = np.array([[i, j, k] for i in (0, 1) for j in (0, 1) for k in (0, 1)])  # [8, 3]
_PAIRS_AT_ONCE = 1 << 20  # bounds the memory of one vectorised pass to about 100 MB


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
    a, b, c = triangles[:, 0], triangles[:, 1], triangles[:, 2]
    best = np.minimum(
        np.minimum(_segment_distance(points, a, b), _segment_distance(points, b, c)),
        _segment_distance(points, c, a),
    )
    normal = np.cross(b - a, c - a)
    square = np.einsum("ij,ij->i", normal, normal)
    inside = square > 0
    for start, end in ((a, b), (b, c), (c, a)):
        inside &= np.einsum("ij,ij->i", np.cross(end - start, points - start), normal) >= 0
    plane = np.abs(np.einsum("ij,ij->i", points - a, normal)) / np.sqrt(np.where(square > 0, square, 1.0))
    return np.where(inside, np.minimum(plane, best), best)


def _segment_distance(points: Floats, start: Floats, end: Floats) -> Floats:
    along = end - start
    square = np.einsum("ij,ij->i", along, along)
    share = np.einsum("ij,ij->i", points - start, along) / np.where(square > 0, square, 1.0)
    nearest = start + np.clip(share, 0.0, 1.0)[:, None] * along
    return np.asarray(np.linalg.norm(points - nearest, axis=1), dtype=np.float64)


def inside_closed_surface(points: Floats, triangles: Floats) -> Bools:
    """Whether `points` [n, 3] lie inside the closed surface `triangles` [F, 3, 3], whatever its orientation.

    Generalised winding number, summed solid angles: Van Oosterom & Strackee, IEEE TBME 30(2), 1983;
    Jacobson et al., SIGGRAPH 2013. Robust to small gaps, unlike counting crossings of a ray.
    """
    result = np.zeros(len(points), dtype=np.bool_)
    low, high = triangles.min(axis=(0, 1)), triangles.max(axis=(0, 1))
    candidates = np.flatnonzero(((points >= low) & (points <= high)).all(axis=1))
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


def _expand(counts: Ints) -> tuple[Ints, Ints]:
    """For ragged rows of `counts` items: the row of every item, and its place within the row."""
    row = np.repeat(np.arange(len(counts)), counts)
    place = np.arange(len(row)) - np.repeat(np.cumsum(counts) - counts, counts)
    return row, place


class ColumnIndex:
    """Finds the surface above or below a point: triangles by the columns of a horizontal grid."""

    def __init__(self, triangles: Floats, cell_m: float = 1.0, min_normal_z: float = 0.05) -> None:
        """Index the triangles [F, 3, 3] that are not walls: |normal z| >= `min_normal_z`."""
        normals, areas = triangle_normals(triangles)
        keep = (np.abs(normals[:, 2]) >= min_normal_z) & (areas > 0)
        self._triangles = triangles[keep]
        self._slope = np.abs(normals[keep, 2])
        flat = self._triangles[:, :, :2]
        self._low = flat.min(axis=(0, 1)) if len(flat) else np.zeros(2)
        extent = (flat.max(axis=(0, 1)) if len(flat) else np.zeros(2)) - self._low
        self._cell = max(cell_m, float(np.sqrt(extent[0] * extent[1] / _MAX_COLUMNS)))
        self._shape = (extent // self._cell).astype(np.int64) + 1
        first = ((flat.min(axis=1) - self._low) // self._cell).astype(np.int64)
        last = ((flat.max(axis=1) - self._low) // self._cell).astype(np.int64)
        span = last - first + 1
        row, place = _expand(span.prod(axis=1))
        column = (
            (first[row, 0] + place // span[row, 1]) * self._shape[1] + first[row, 1] + place % span[row, 1]
        )
        order = np.argsort(column, kind="stable")
        self._members = row[order].astype(np.int32)
        self._start = np.searchsorted(column[order], np.arange(self._shape.prod() + 1))
        # Solved once: barycentric weights and height are linear in (x, y).
        a, b, c = flat[:, 0], flat[:, 1], flat[:, 2]
        self._origin, self._u, self._v = a, b - a, c - a
        self._inverse = 1.0 / _cross2(self._u, self._v)

    def highest(self, points: Floats, down_m: float | Floats, up_m: float | Floats) -> tuple[Floats, Floats]:
        """Highest surface at (x, y) of each point [n, 3] with z in [z - down_m, z + up_m].

        Returns its z [n] [m], NaN where there is none, and the absolute z of its unit normal [n].
        """
        found = np.full(len(points), -np.inf)
        slope = np.zeros(len(points))
        cell = ((points[:, :2] - self._low) // self._cell).astype(np.int64)
        ok = ((cell >= 0) & (cell < self._shape)).all(axis=1)
        key = np.where(ok, cell[:, 0] * self._shape[1] + cell[:, 1], 0)
        counts = np.where(ok, self._start[key + 1] - self._start[key], 0)
        row, place = _expand(counts)
        tri = self._members[self._start[key[row]] + place]
        away = points[row, :2] - self._origin[tri]
        s = _cross2(away, self._v[tri]) * self._inverse[tri]
        t = _cross2(self._u[tri], away) * self._inverse[tri]
        z0 = self._triangles[tri, 0, 2]
        z = z0 + s * (self._triangles[tri, 1, 2] - z0) + t * (self._triangles[tri, 2, 2] - z0)
        low = np.broadcast_to(points[:, 2] - down_m, len(points))[row]
        high = np.broadcast_to(points[:, 2] + up_m, len(points))[row]
        edge = -1e-9  # so that a point on a shared edge belongs to one of the two at least
        hit = (s >= edge) & (t >= edge) & (s + t <= 1 - edge) & (z >= low) & (z <= high)
        np.maximum.at(found, row[hit], z[hit])
        best = hit & (z == found[row])
        slope[row[best]] = self._slope[tri[best]]
        return np.where(np.isfinite(found), found, np.nan), slope


def _cross2(a: Floats, b: Floats) -> Floats:
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


class SurfaceIndex:
    """Distances to a triangle surface up to a limit: a sparse grid of cells of that size.

    A cell that lies within the limit as a whole answers at once; a cell that no triangle comes near is not
    stored; only cells between the two ask triangles.
    """

    def __init__(self, triangles: Floats, limit_m: float) -> None:
        """Prepare for `limit_m` or less over `triangles` [F, 3, 3]."""
        self.limit_m = limit_m
        self._triangles = triangles
        self._cell = limit_m
        self._low = triangles.min(axis=(0, 1)) - 2 * limit_m
        key, member, near = self._rasterise()
        order = np.lexsort((member, key))
        key, self._member = key[order], member[order]
        self._keys, self._start = np.unique(key, return_index=True)
        self._stop = np.append(self._start[1:], len(key))
        self._whole = np.minimum.reduceat(near[order], self._start) + self._half_diagonal <= limit_m

    @property
    def _half_diagonal(self) -> float:
        return self._cell * float(np.sqrt(3)) / 2

    def _rasterise(self) -> tuple[Ints, Ints, Floats]:
        """Every (cell, triangle) pair closer than the limit, with the distance from the cell's centre.

        From coarse cells to fine ones, keeping what the triangle comes near: the work grows with the area of a
        triangle, not with the box around it.
        """
        low = (self._triangles.min(axis=1) - self.limit_m - self._low) / self._cell
        high = (self._triangles.max(axis=1) + self.limit_m - self._low) / self._cell
        level = max(0, int(np.ceil(np.log2(max(1.0, (high - low).max())))))
        first = np.floor(low / 2**level).astype(np.int64)
        span = np.floor(high / 2**level).astype(np.int64) - first + 1
        row, place = _expand(span.prod(axis=1))
        cell = first[row] + np.stack(
            [
                place // (span[row, 1] * span[row, 2]),
                place // span[row, 2] % span[row, 1],
                place % span[row, 2],
            ],
            axis=1,
        )
        cell, row, near = self._keep_near(cell, row, 2.0**level)
        for halving in range(level - 1, -1, -1):
            cell = (2 * cell[:, None, :] + _CHILDREN).reshape(-1, 3)
            cell, row, near = self._keep_near(cell, np.repeat(row, 8), 2.0**halving)
        return _pack(cell), row, near

    def _keep_near(self, cell: Ints, row: Ints, size: float) -> tuple[Ints, Ints, Floats]:
        """The pairs of cells (of `size` times the finest) and triangles that come nearer than the limit."""
        reach = self.limit_m + size * self._half_diagonal
        pieces = []
        for begin in range(0, len(cell), _PAIRS_AT_ONCE):
            some, tri = cell[begin : begin + _PAIRS_AT_ONCE], row[begin : begin + _PAIRS_AT_ONCE]
            centre = self._low + (some + 0.5) * (size * self._cell)
            near = point_triangle_distance(centre, self._triangles[tri])
            keep = near <= reach
            pieces.append((some[keep], tri[keep], near[keep]))
        cells, rows, nears = zip(*pieces, strict=True)
        return np.concatenate(cells), np.concatenate(rows), np.concatenate(nears)

    def within(self, points: Floats, limit_m: float | None = None) -> Bools:
        """Whether each point [n, 3] lies within `limit_m` (default: the index's own limit) of the surface."""
        limit = self.limit_m if limit_m is None else limit_m
        if limit > self.limit_m:
            raise ValueError(f"limit {limit} m is beyond the index's {self.limit_m} m")
        place, known = self._lookup(points)
        result = (
            known & self._whole[place] if limit == self.limit_m else np.zeros(len(points), dtype=np.bool_)
        )
        ask = np.flatnonzero(known & ~result)
        result[ask] = self._nearest(points[ask], place[ask]) <= limit
        return result

    def distance(self, points: Floats) -> Floats:
        """Distance [n] of each point [n, 3] to the surface [m]; infinite beyond the limit."""
        result = np.full(len(points), np.inf)
        place, known = self._lookup(points)
        ask = np.flatnonzero(known)
        near = self._nearest(points[ask], place[ask])
        result[ask] = np.where(near <= self.limit_m, near, np.inf)
        return result

    def _lookup(self, points: Floats) -> tuple[Ints, Bools]:
        cell = np.floor((points - self._low) / self._cell)
        sane = (np.abs(cell) < 1 << 20).all(axis=1) & (cell >= 0).all(axis=1)
        key = _pack(np.where(sane[:, None], cell, 0).astype(np.int64))
        place = np.minimum(np.searchsorted(self._keys, key), len(self._keys) - 1)
        return place, sane & (self._keys[place] == key)

    def _nearest(self, points: Floats, place: Ints) -> Floats:
        result = np.full(len(points), np.inf)
        counts = self._stop[place] - self._start[place]
        total = np.cumsum(counts)
        begin = 0
        while begin < len(points):
            done = total[begin - 1] if begin else 0
            end = max(begin + 1, int(np.searchsorted(total, done + _PAIRS_AT_ONCE)))
            row, item = _expand(counts[begin:end])
            member = self._member[self._start[place[begin:end]][row] + item]
            near = point_triangle_distance(points[begin:end][row], self._triangles[member])
            np.minimum.at(result[begin:end], row, near)
            begin = end
        return result


def _pack(cell: Ints) -> Ints:
    """Cell indices [n, 3] in [0, 2^20) to one sortable integer each."""
    return np.asarray((cell[:, 0] << 40) | (cell[:, 1] << 20) | cell[:, 2], dtype=np.int64)
