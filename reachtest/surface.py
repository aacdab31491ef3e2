"""Distances to a triangle surface, exact up to a limit.

Shape legend: n queries, F triangles. Coordinates are metres, z up, float64.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from contextlib import nullcontext

import numpy as np

from reachtest.geometry import indices, point_triangle_distance, triangle_normals
from reachtest.records import Bools, Floats, Ints

_PAIRS_IN_CACHE = 1 << 13  # a pass that stays in a core's second-level cache is three times as fast
_POINTS_AT_ONCE = 1 << 12  # likewise, with a few neighbours a point
_BLOCKS_ALONE = 8  # of points; more are worth threads
_MOST_PIECES = 1 << 18  # beside the triangles themselves: a second of preparation
_FIRST_NEIGHBOURS = 4  # most points need no more; the others ask again for as many as are likely to do
_RESERVE, _MOST_POWER = 1.2, 6  # of that guess
_SIZES, _SIZE_STEP = 4, float(np.log(3.0))  # pieces of one tree differ by this factor; the smallest share one
_THIN = 1e-5  # height over length: a plane that is off by rounding
_ROUNDING_M = 1e-9  # of the bounds: far above that of coordinates, far below any distance that counts


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
            asking: list[tuple[Ints, int, Floats | None]] = [
                (np.arange(len(points)), _FIRST_NEIGHBOURS, None)
            ]
            while asking:
                ask, count, seen = asking.pop()
                away, piece = group.query(points[ask], count, self.limit_m)
                bound = np.minimum(np.minimum(best[ask], self.limit_m), away[:, 0]) + _ROUNDING_M
                row, owner = group.possible(points[ask], away, piece, bound, seen)
                self._measure(points, ask[row], owner, best)
                bound, last = np.minimum(best[ask], self.limit_m) + _ROUNDING_M, away[:, -1]
                more = np.flatnonzero(last - group.widest <= bound)
                times = _times_as_many(bound[more], last[more], group.widest)
                for factor in np.unique(times).tolist():
                    some = more[times == factor]
                    asking.append((ask[some], factor * count, last[some]))
        return best

    def _measure(self, points: Floats, row: Ints, owner: Ints, best: Floats) -> None:
        """Lower `best` [n] of points [n, 3] to the distances of pairs of a point and a triangle."""
        for begin in range(0, len(row), _PAIRS_IN_CACHE):
            some, which = row[begin : begin + _PAIRS_IN_CACHE], owner[begin : begin + _PAIRS_IN_CACHE]
            np.minimum.at(best, some, point_triangle_distance(points[some], self._triangles[which]))


def _times_as_many(bound: Floats, last: Floats, widest: float) -> Ints:
    """How many times as many neighbours to ask for [n], a power of two, where the last one was `last` away and those
    up to `bound` + `widest` count: as if they lay evenly in a plane at `bound`."""
    square = np.maximum(bound, 0.0) ** 2
    ratio = ((bound + widest) ** 2 - square) / np.maximum(last**2 - square, _ROUNDING_M)
    power = np.ceil(np.log2(np.maximum(_RESERVE * ratio, 1.0)))
    return np.asarray(2 ** np.clip(power, 1, _MOST_POWER).astype(np.int64))


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
    """Halves triangles [F, 3, 3] at their longest edges until none is wider; the pieces, and whose they are.

    A sliver comes apart into three halves of its length at a time, many more pieces than its area and length say:
    where there would be too many they stay wider, which is slower but no less exact.
    """
    most = 4 * (_MOST_PIECES + len(triangles))
    done: list[tuple[Floats, Ints]] = []
    wide, owner = triangles, np.arange(len(triangles))
    while len(wide):
        narrow = _centres(wide)[1] <= radius_m
        if sum(len(some) for some, _ in done) + 2 * len(wide) > most:
            narrow[:] = True
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
