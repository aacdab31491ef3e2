"""Which terrains collide as MuJoCo height fields; the others are pieces like everything else.

A height field costs what lies under the capsule, however large it is, so it stands whole in every tile: no crop to
make, and no rounding that differs from tile to tile. But MuJoCo's is solid from the surface down to its base, while
a terrain is open from below. So it stands in for the triangles only where nobody could be under there, and where
its float32 heights and MuJoCo's 50 contacts for two shapes are enough.

Shape legend: F triangles, R rows towards +y, C columns towards +x.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from reachtest.geometry import grid_surface
from reachtest.records import Character, Floats, HeightField, Level

MOST_RANGE_M = 1_000.0  # float32 shares of it are within 0.06 mm
LEAST_CELL_RADII = 0.25  # a capsule on flatter cells touches more of them at once than MuJoCo keeps contacts


def split_terrain(level: Level) -> tuple[Floats, tuple[HeightField, ...]]:
    """The collision triangles [F, 3, 3] that become pieces, and the terrains that stay height fields."""
    kept = np.ones(len(level.collision), dtype=np.bool_)
    fields = []
    for field in level.height_fields:
        rows = _rows(field)
        if _fits(field, level.character) and _intact(field, level.collision[rows]):
            others = np.concatenate([level.collision[: rows.start], level.collision[rows.stop :]])
            if not _open_below(field, others, level):
                kept[rows] = False
                fields.append(field)
    return level.collision[kept] if fields else level.collision, tuple(fields)


def _rows(field: HeightField) -> slice:
    rows, columns = field.heights.shape
    return slice(field.first, field.first + 2 * (rows - 1) * (columns - 1))


def _fits(field: HeightField, character: Character) -> bool:
    rows, columns = field.heights.shape
    cell = (field.high - field.low) / [columns - 1, rows - 1]
    return bool(np.ptp(field.heights) <= MOST_RANGE_M and cell.min() >= LEAST_CELL_RADII * character.radius_m)


def _intact(field: HeightField, triangles: Floats) -> bool:
    """Whether its triangles [F, 3, 3] are in the level still: mutants and crops change the collision alone."""
    return np.array_equal(triangles, grid_surface(field.points))


def _open_below(field: HeightField, others: Floats, level: Level) -> bool:
    """Whether a character may be under the terrain: it starts there, or something to stand on lies so low.

    Anything else of the collision counts, `others` [F, 3, 3], that leaves room for the character between it and the
    terrain above, or above what is within a capsule's width of the terrain's border: from a floor there it walks
    in under the border. In case of doubt (something on a steep slope) the answer is yes. Who jumps in from
    farther away falls out of the world, with a solid terrain in its way as without.
    """
    c = level.character
    starts = np.array([spawn.position for spawn in level.spawns])
    for height, top in zip(starts[:, 2], _tops(field, starts, starts, 0.0), strict=True):
        if height + c.height_m < top:
            return True
    beside = 2 * c.radius_m
    low, high = others.min(axis=1), others.max(axis=1)
    near = (low[:, :2] <= field.high + beside) & (high[:, :2] >= field.low - beside)
    some = np.flatnonzero(near.all(axis=1) & (low[:, 2] + c.height_m < field.heights.max()))
    tops = _tops(field, low[some], high[some], beside)
    return any(bottom + c.height_m < top for bottom, top in zip(low[some, 2], tops, strict=True))


def _tops(field: HeightField, low: Floats, high: Floats, beside: float) -> Iterator[float]:
    """Height of the terrain's highest sample around each box from `low` to `high` [n, 3]; -inf beyond its border."""
    rows, columns = field.heights.shape
    last = np.array([columns - 1, rows - 1])
    scale = last / (field.high - field.low)
    begin = np.floor((low[:, :2] - beside - field.low) * scale)
    end = np.ceil((high[:, :2] + beside - field.low) * scale)
    begin, end = np.maximum(begin, 0).astype(np.int64), np.minimum(end, last).astype(np.int64) + 1
    for (left, bottom), (right, top) in zip(begin.tolist(), end.tolist(), strict=True):
        yield float(field.heights[bottom:top, left:right].max(initial=-np.inf))
