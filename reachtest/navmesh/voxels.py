"""Triangles to solid spans in the columns of a horizontal grid: Recast's rcRasterizeTriangles, vectorised.

Conservative: a span covers everything of a triangle that lies in its column, in whole cells of height.
Shape legend: F triangles, S (triangle, strip) pairs, P (triangle, column) pairs, N spans.
Inside this package x and y are counted in cells, heights of spans in cell heights; only `floor` is in metres.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from reachtest.geometry import expand, triangle_normals
from reachtest.navmesh.clip import TOUCH, across, cut_heights, holds
from reachtest.records import Bools, Floats, Ints

TOP_BITS = 24  # of sort keys: heights of up to 16 million cells
STEEPEST = 1e-6  # normal z below which a plane has no height over a point


@dataclass(frozen=True)
class Grid:
    """A block of columns: column (i, j) of `shape` covers [i, i + 1) x [j, j + 1) cells from `low`."""

    low: Floats  # [3] [m]
    cell_m: float
    cell_height_m: float
    shape: tuple[int, int]


@dataclass(frozen=True)
class Spans:
    """Solid spans, in order of column and height; they neither overlap nor touch within a column."""

    column: Ints  # [N] i * shape[1] + j
    bottom: Ints  # [N] [cell heights]
    top: Ints  # [N] [cell heights]
    floor: Floats  # [N] height of the surface at the column's centre, as far as it lies in the column [m]
    rate: Floats  # [N, 2] how that surface rises along i and j [m a cell]
    walkable: Bools  # [N] whether the top is less steep than the slope limit

    def __len__(self) -> int:
        return len(self.column)


def rasterise(triangles: Floats, slope_deg: float, climb: int, grid: Grid, both_sides: bool = False) -> Spans:
    """The spans of `triangles` [F, 3, 3] [m] in the grid's columns.

    Surfaces that face up, or down if `both_sides` count, and are less steep than `slope_deg` are walkable
    (rcMarkWalkableTriangles). Spans that overlap or touch become one; it is walkable if a walkable one of them
    ends at most `climb` cells below its top (rcAddSpan's flagMergeThreshold).
    """
    normals, areas = triangle_normals(triangles)
    upwards = np.abs(normals[:, 2]) if both_sides else normals[:, 2]
    walkable = (upwards > np.cos(np.radians(slope_deg))) & (areas > 0)
    cells = (triangles - grid.low) / [grid.cell_m, grid.cell_m, 1.0]
    tri, i, j, inside = _columns(cells, grid.shape)
    rate, steep = _rates(cells)
    low, high, middle, sure = _heights(cells, rate, steep, tri, i, j, inside)
    bottom = np.floor(low / grid.cell_height_m + TOUCH).astype(np.int64)
    top = np.maximum(np.ceil(high / grid.cell_height_m - TOUCH).astype(np.int64), bottom + 1)
    middle = middle + grid.low[2]
    return _merge(i * grid.shape[1] + j, bottom, top, middle, rate[tri], sure, walkable[tri], climb)


def _columns(cells: Floats, shape: tuple[int, int]) -> tuple[Ints, Ints, Ints, Bools]:
    """Every column that a triangle comes into: triangle [P], i [P], j [P], and whether it covers it all [P]."""
    first, last = _whole(cells[:, :, 0].min(axis=1), cells[:, :, 0].max(axis=1), shape[0])
    tri, place = expand(np.maximum(last - first + 1, 0))
    strip = first[tri] + place
    low, high, full_low, full_high = across(cells[tri, :, :2], strip)
    first, last = _whole(low, high, shape[1])
    row, place = expand(np.maximum(last - first + 1, 0))
    j = first[row] + place
    return tri[row], strip[row], j, (j >= full_low[row]) & (j + 1 <= full_high[row])


def _whole(low: Floats, high: Floats, count: int) -> tuple[Ints, Ints]:
    """First and last cell of intervals; an interval of no length on a border is in the cells on both sides.
    Where low is above high there is nothing: the last cell is -1."""
    inner_low, inner_high = low + TOUCH, high - TOUCH
    first = np.clip(np.floor(np.minimum(inner_low, inner_high)), 0, count)
    last = np.clip(np.floor(np.maximum(inner_low, inner_high)), -1, count - 1)
    return first.astype(np.int64), np.where(low <= high, last, -1).astype(np.int64)


def _rates(cells: Floats) -> tuple[Floats, Bools]:
    """How each triangle rises along i and j [F, 2] [m a cell], and whether it is too steep to tell [F]."""
    normal = np.cross(cells[:, 1] - cells[:, 0], cells[:, 2] - cells[:, 0])
    steep: Bools = np.asarray(
        np.abs(normal[:, 2]) <= STEEPEST * np.linalg.norm(normal, axis=1), dtype=np.bool_
    )
    return np.where(steep[:, None], 0.0, -normal[:, :2] / np.where(steep, 1.0, normal[:, 2])[:, None]), steep


def _heights(
    cells: Floats, rate: Floats, steep: Bools, tri: Ints, i: Ints, j: Ints, inside: Bools
) -> tuple[Floats, Floats, Floats, Bools]:
    """Lowest and highest point of each triangle in its column, its height nearest to the centre [P] [m over low],
    and whether it lies over the centre itself [P]."""
    origin = cells[:, 0, 2] - np.einsum("fi,fi->f", rate, cells[:, 0, :2])
    half = np.abs(rate).sum(axis=1) / 2
    middle = origin[tri] + rate[tri, 0] * (i + 0.5) + rate[tri, 1] * (j + 0.5)
    low, high = middle - half[tri], middle + half[tri]
    sure = ~steep[tri]
    part = ~inside
    slopes = ((half > 0) | steep)[tri]
    flat = np.flatnonzero(part & ~slopes)
    sure[flat] = holds(cells[tri[flat], :, :2], np.stack([i[flat], j[flat]], axis=1) + 0.5)
    cut = np.flatnonzero(part & slopes)
    some = tri[cut]
    low[cut], high[cut], sure[cut] = cut_heights(
        cells[some], np.stack([i[cut], j[cut]], axis=1), rate[some], steep[some]
    )
    np.clip(low, cells[:, :, 2].min(axis=1)[tri], None, out=low)
    np.clip(high, None, cells[:, :, 2].max(axis=1)[tri], out=high)
    high = np.maximum(low, high)
    return low, high, np.where(steep[tri], high, np.clip(middle, low, high)), sure


def _merge(
    column: Ints,
    bottom: Ints,
    top: Ints,
    floor: Floats,
    rate: Floats,
    sure: Bools,
    walkable: Bools,
    climb: int,
) -> Spans:
    """One span for every heap of spans that overlap or touch."""
    if not len(column):
        none = np.zeros(0, dtype=np.int64)
        return Spans(none, none, none, np.zeros(0), np.zeros((0, 2)), np.zeros(0, dtype=np.bool_))
    lowest = int(bottom.min())  # keys are of positive numbers
    order = np.argsort((column << TOP_BITS) + bottom - lowest, kind="stable")
    column, bottom, top = column[order], bottom[order], top[order]
    floor, rate, sure, walkable = floor[order], rate[order], sure[order], walkable[order]
    key = (column << TOP_BITS) + top - lowest
    highest = np.maximum.accumulate(key)  # of later columns always higher
    new = np.ones(len(column), dtype=np.bool_)
    new[1:] = ((column[1:] << TOP_BITS) + bottom[1:] - lowest) > highest[:-1]
    start, heap = np.flatnonzero(new), np.cumsum(new) - 1
    merged = np.maximum.reduceat(top, start)
    near_top = walkable & (top >= merged[heap] - climb)
    # The highest of those over the centre; else of those that are walkable; else of all.
    rank = near_top.astype(np.int64) + (near_top & sure)
    best = np.lexsort((floor, rank, heap))[np.append(start[1:], len(heap)) - 1]
    walked = np.logical_or.reduceat(near_top, start)
    return Spans(column[start], bottom[start], merged, floor[best], rate[best], walked)
