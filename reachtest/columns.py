"""Triangles by the columns of a horizontal grid: what is near a point seen from above, and how high.

Shape legend: n queries, F triangles. Coordinates are metres, z up, float64.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from reachtest.geometry import PAIRS_AT_ONCE, expand, indices, triangle_normals
from reachtest.records import Bools, Floats, Ints

_MAX_COLUMNS = 4_000_000  # keeps the dense column table of a 5 km level below 32 MB
_MAX_MEMBERS = 1 << 25  # likewise of its entries, where many triangles span many columns: below 1 GB


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
            end = max(begin + 1, int(np.searchsorted(total, done + PAIRS_AT_ONCE)))
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
