"""Geometry kernels that several stages need: all vectorised, all exact up to rounding.

Shape legend: n queries, F triangles. Coordinates are metres, z up, float64.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from contextlib import nullcontext

import numpy as np

from reachtest.records import Bools, Floats, Ints

_MAX_COLUMNS = 4_000_000  # keeps the dense column table of a 5 km level below 32 MB
_PAIRS_AT_ONCE = 1 << 20  # bounds the memory of one vectorised pass to about 100 MB
_PAIRS_IN_CACHE = 1 << 13  # a pass that stays in a core's second-level cache is three times as fast
_POINTS_AT_ONCE = 1 << 12  # likewise, with a few neighbours a point
_BLOCKS_ALONE = 8  # of points; more are worth threads
_MOST_PIECES = 1 << 18  # beside the triangles themselves: a second of preparation
_FIRST_NEIGHBOURS = 4  # most points need no more; the others ask again for four times as many
_SIZES, _SIZE_STEP = 4, float(np.log(3.0))  # pieces of one tree differ by this factor; the smallest share one
_SLIVER, _THIN = 1e-12, 1e-5  # height over length: no plane at all; a plane that is off by rounding
_ROUNDING_M = 1e-9  # of the bounds: far above that of coordinates, far below any distance that counts


def indices(mask: Bools | np.bool_) -> Ints:
    """Where `mask` [n] is true: `np.flatnonzero` without its three wrappers, for loops that call it often."""
    return np.asarray(mask).nonzero()[0]


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
        low, high = (points[:, 2] - down_m)[row], (points[:, 2] + up_m)[row]
        edge = -1e-9  # so that a point on a shared edge belongs to one of the two at least
        hit = (s >= edge) & (t >= edge) & (s + t <= 1 - edge) & (z >= low) & (z <= high)
        np.maximum.at(found, row[hit], z[hit])
        best = hit & (z == found[row])
        slope[row[best]] = self._slope[tri[best]]
        return np.where(np.isfinite(found), found, np.nan), slope


def _cross2(a: Floats, b: Floats) -> Floats:
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


class SurfaceIndex:
    """Exact distances to a triangle surface up to a limit.

    Triangles are cut into small pieces whose centres lie in k-d trees, one for each size of piece. A centre's
    distance bounds that of its triangle from above, and less the piece's radius from below: only triangles that
    can be the nearest are measured.
    """

    def __init__(self, triangles: Floats, limit_m: float) -> None:
        """Prepare for `limit_m` or less over `triangles` [F, 3, 3]."""
        self.limit_m = limit_m
        self._triangles = triangles
        self._low = triangles.min(axis=(0, 1)) - limit_m
        self._high = triangles.max(axis=(0, 1)) + limit_m
        pieces, owner = _cut(triangles, _piece_radius(triangles, limit_m))
        centre, radius = _centres(pieces)
        normal = _sure_normals(triangles)[owner]
        sizes = np.ceil(np.log(np.maximum(radius, _ROUNDING_M)) / _SIZE_STEP).astype(np.int64)
        sizes = np.maximum(sizes, sizes.max() - _SIZES + 1)
        members = [indices(sizes == size) for size in np.unique(sizes)]
        members.sort(key=len, reverse=True)  # most likely the nearest first: the others have less to measure
        self._groups = [_Pieces(centre[m], radius[m], normal[m], owner[m]) for m in members]

    def within(self, points: Floats, limit_m: float | None = None) -> Bools:
        """Whether each point [n, 3] lies within `limit_m` (default: the index's own limit) of the surface."""
        limit = self.limit_m if limit_m is None else limit_m
        if limit > self.limit_m:
            raise ValueError(f"limit {limit} m is beyond the index's {self.limit_m} m")
        return np.asarray(self.distance(points) <= limit, dtype=np.bool_)

    def distance(self, points: Floats) -> Floats:
        """Distance [n] of each point [n, 3] to the surface [m]; infinite beyond the limit."""
        result = np.full(len(points), np.inf)
        near = indices(((points >= self._low) & (points <= self._high)).all(axis=1))  # false for NaN
        if (
            len(near) > _POINTS_AT_ONCE
        ):  # neighbours in space one after the other: they share the trees' leaves
            near = near[np.argsort(_pack(points[near] - self._low, self.limit_m), kind="stable")]
        blocks = [near[begin : begin + _POINTS_AT_ONCE] for begin in range(0, len(near), _POINTS_AT_ONCE)]
        with ThreadPoolExecutor() if len(blocks) > _BLOCKS_ALONE else nullcontext() as pool:
            each = pool.map if pool else map
            for some, found in zip(blocks, each(self._nearest, [points[b] for b in blocks]), strict=True):
                result[some] = np.where(found <= self.limit_m, found, np.inf)
        return result

    def _nearest(self, points: Floats) -> Floats:
        """Distance [n] to the nearest triangle; infinite, or beyond the limit, where none is within it."""
        best = np.full(len(points), np.inf)
        for group in self._groups:
            count, seen = _FIRST_NEIGHBOURS, None
            ask = np.arange(len(points))
            while len(ask):
                away, piece = group.query(points[ask], count, self.limit_m)
                bound = np.minimum(np.minimum(best[ask], self.limit_m), away[:, 0]) + _ROUNDING_M
                row, owner = group.possible(points[ask], away, piece, bound, seen)
                self._measure(points, ask[row], owner, best)
                last = away[:, -1]
                more = last - group.widest <= np.minimum(best[ask], self.limit_m) + _ROUNDING_M
                ask, seen, count = ask[more], last[more], 4 * count
        return best

    def _measure(self, points: Floats, row: Ints, owner: Ints, best: Floats) -> None:
        """Lower `best` [n] of points [n, 3] to the distances of pairs of a point and a triangle."""
        for begin in range(0, len(row), _PAIRS_IN_CACHE):
            some, which = row[begin : begin + _PAIRS_IN_CACHE], owner[begin : begin + _PAIRS_IN_CACHE]
            np.minimum.at(best, some, point_triangle_distance(points[some], self._triangles[which]))


class _Pieces:
    """Pieces of about one size, found by their centres."""

    def __init__(self, centre: Floats, radius: Floats, normal: Floats, owner: Ints) -> None:
        from scipy.spatial import cKDTree

        self.widest = float(radius.max())
        self._centre, self._radius, self._normal, self._owner = centre, radius, normal, owner
        self._tree = cKDTree(centre)

    def query(self, points: Floats, count: int, limit_m: float) -> tuple[Floats, Ints]:
        """Distances and indices [n, count] of the nearest centres; infinite where no piece within the limit."""
        reach = limit_m + self.widest + _ROUNDING_M
        away, piece = self._tree.query(points, np.arange(1, count + 1), distance_upper_bound=reach)
        return np.asarray(away), np.asarray(piece, dtype=np.int64)

    def possible(
        self, points: Floats, away: Floats, piece: Ints, bound: Floats, seen: Floats | None
    ) -> tuple[Ints, Ints]:
        """The pairs of a row and a triangle that can be nearer than `bound`, not `seen` at a smaller distance.

        A piece lies in the disc about its centre: a point h above its plane and w beside the centre is no nearer
        than (h, w - radius).
        """
        asked = away - self.widest <= bound[:, None]  # false where there is no neighbour
        if seen is not None:
            asked &= away >= seen[:, None]
        row, column = np.nonzero(asked)
        which, far = piece[row, column], away[row, column]
        above = np.einsum("ij,ij->i", points[row] - self._centre[which], self._normal[which])
        beside = np.sqrt(np.maximum(far**2 - above**2, 0.0)) - self._radius[which]
        near = np.hypot(above, np.maximum(beside, 0.0)) <= bound[row]
        return row[near], self._owner[which[near]]


def _piece_radius(triangles: Floats, limit_m: float) -> float:
    """Largest radius of a piece [m]: small beside the limit, but for few enough pieces."""
    edges = np.linalg.norm(triangles - np.roll(triangles, 1, axis=1), axis=2).max(axis=1)
    _, areas = triangle_normals(triangles)
    radius = limit_m / 1.5
    while (2 * areas / radius**2 + edges / radius).sum() > _MOST_PIECES + len(triangles):
        radius *= 1.5
    return radius


def _cut(triangles: Floats, radius_m: float) -> tuple[Floats, Ints]:
    """Halves triangles [F, 3, 3] at their longest edges until none is wider; the pieces, and whose they are."""
    done: list[tuple[Floats, Ints]] = []
    wide, owner = triangles, np.arange(len(triangles))
    while len(wide):
        narrow = _centres(wide)[1] <= radius_m
        done.append((wide[narrow], owner[narrow]))
        wide, owner = wide[~narrow], np.repeat(owner[~narrow], 2)
        rows = np.arange(len(wide))
        first = np.linalg.norm(wide - np.roll(wide, -1, axis=1), axis=2).argmax(axis=1)
        a, b, c = (wide[rows, (first + turn) % 3] for turn in range(3))
        middle = (a + b) / 2
        wide = np.stack([a, middle, c, middle, b, c], axis=1).reshape(-1, 3, 3)
    return np.concatenate([some for some, _ in done]), np.concatenate([whose for _, whose in done])


def _sure_normals(triangles: Floats) -> Floats:
    """Unit normals [F, 3]; zero where a triangle is so thin that rounding turns them."""
    normals, areas = triangle_normals(triangles)
    longest = np.linalg.norm(triangles - np.roll(triangles, 1, axis=1), axis=2).max(axis=1)
    return np.where((areas > _THIN * longest**2)[:, None], normals, 0.0)


def _centres(triangles: Floats) -> tuple[Floats, Floats]:
    """The middle of every triangle [F, 3], and the distance of its farthest corner [F]."""
    centre = triangles.mean(axis=1)
    return centre, np.linalg.norm(triangles - centre[:, None], axis=2).max(axis=1)


def _pack(points: Floats, cell_m: float) -> Ints:
    """A sortable integer [n] for the cell of every point [n, 3] >= 0; far ones may share it."""
    cell = np.minimum(points / cell_m, (1 << 20) - 1).astype(np.int64)
    return np.asarray((cell[:, 0] << 40) | (cell[:, 1] << 20) | cell[:, 2], dtype=np.int64)
