"""The free space of a capsule as voxels, and the places where it comes to rest: geometry only, no simulation.

Coordinates are cells; a foot at level k stands on something that ends there. Shape legend: N places, n queries;
I, J, K cells of the grid along x, y and z.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from reachtest.navmesh.voxels import Grid, rasterise
from reachtest.records import Bools, Character, Floats, Ints

Levels = NDArray[np.int16]
CELLS_PER_RADIUS = 2
CELLS_PER_STEP = 3
_MOST_CELLS = 120_000_000  # 120 MB for each array of the field
_SLACK = 1e-6


@dataclass(frozen=True)
class Field:
    """Where the capsule's feet can be, and where they rest."""

    grid: Grid
    free: Bools  # [I * J, K] the capsule fits with its feet there, but for steps
    land: Levels  # [I * J, K] level to which it falls from there; -1: out of the world
    column: Ints  # [N] of each place where it rests
    level: Ints  # [N]
    walkable: Bools  # [N] less steep than the slope limit
    positions: Floats  # [N, 3] m
    step: int  # [cells] what it steps up

    def find(self, column: Ints, level: Ints) -> Ints:
        """The place [n] at a level of a column; -1 where nothing rests there."""
        at, key = self.after(column, level), column * self.free.shape[1] + level
        known = np.append(self.column * self.free.shape[1] + self.level, -1)
        return np.where(known[at] == key, at, -1)

    def after(self, column: Ints, level: Ints) -> Ints:
        """The first place [n] at or above a level of a column, or of later columns; N for none."""
        keys = self.column * self.free.shape[1] + self.level
        return np.asarray(np.searchsorted(keys, column * self.free.shape[1] + level), dtype=np.int64)


def level_grid(collision: Floats, character: Character) -> Grid:
    """The grid of a whole level, with room around it to step out into."""
    cell = character.radius_m / CELLS_PER_RADIUS
    height = character.step_height_m / CELLS_PER_STEP if character.step_height_m > 0 else cell
    low, high = collision.min(axis=(0, 1)), collision.max(axis=(0, 1))
    low[:2] -= 8 * cell
    high[:2] += 8 * cell
    low[2] -= 2 * height
    layers = (high[2] - low[2] + 2 * character.height_m) / height
    extent = high - low
    most = _MOST_CELLS / max(layers, 1)
    cell = max(cell, float(np.sqrt(extent[0] * extent[1] / most)))
    columns = np.ceil(extent[:2] / cell).astype(int)
    return Grid(low, cell, height, (int(columns[0]), int(columns[1])))


def window(grid: Grid, low: Floats, high: Floats) -> Grid:
    """The part of a grid that covers a box, on the same cells; deeper, if the box is."""
    first = np.clip(np.floor((low - grid.low)[:2] / grid.cell_m), 0, np.array(grid.shape) - 1)
    last = np.clip(np.ceil((high - grid.low)[:2] / grid.cell_m), first + 1, grid.shape)
    deeper = max(0, int(np.ceil((grid.low[2] - low[2]) / grid.cell_height_m)) + 2)
    corner = grid.low + np.append(first * grid.cell_m, -deeper * grid.cell_height_m)
    return Grid(corner, grid.cell_m, grid.cell_height_m, (int((last - first)[0]), int((last - first)[1])))


def build_field(collision: Floats, character: Character, grid: Grid, kill_z_m: float, top_m: float) -> Field:
    """The field of triangles [F, 3, 3] in the columns of `grid`, up to the height `top_m`.

    Floors may face either way: the physics stops at both sides.
    """
    low, high = grid.low[:2], grid.low[:2] + np.array(grid.shape) * grid.cell_m
    near = (collision.min(axis=1)[:, :2] < high).all(axis=1) & (collision.max(axis=1)[:, :2] > low).all(
        axis=1
    )
    spans = rasterise(collision[near], character.slope_limit_deg, 1, grid, both_sides=True)
    step, tall = _cells(character, grid)
    layers = int(np.ceil((top_m - grid.low[2]) / grid.cell_height_m)) + 2 * tall
    columns = grid.shape[0] * grid.shape[1]
    edges = np.zeros((columns, layers + 1), dtype=np.int8)
    inside = (spans.bottom >= 0) & (spans.top < layers)
    edges[spans.column[inside], spans.bottom[inside]] += 1
    edges[spans.column[inside], spans.top[inside]] -= 1
    solid = np.cumsum(edges[:, :-1], axis=1, dtype=np.int8) > 0
    free = ~_blocked(solid, grid.shape, step, tall, round(character.radius_m / grid.cell_m))
    rests = inside & (spans.top > 0)
    rests[rests] = free[spans.column[rests], spans.top[rests]]
    column, level = spans.column[rests], spans.top[rests]
    i, j = np.divmod(column, grid.shape[1])
    flat = grid.low[:2] + (np.stack([i, j], axis=1) + 0.5) * grid.cell_m
    positions = np.column_stack([flat, spans.floor[rests]])
    return Field(
        grid, free, _landing(free, grid, kill_z_m), column, level, spans.walkable[rests], positions, step
    )


def _cells(character: Character, grid: Grid) -> tuple[int, int]:
    step = int(np.floor(character.step_height_m / grid.cell_height_m + _SLACK))
    return step, int(np.ceil(character.height_m / grid.cell_height_m - _SLACK))


def _blocked(solid: Bools, shape: tuple[int, int], step: int, tall: int, radius: int) -> Bools:
    """Where feet cannot be [I * J, K]: something in the capsule's way, above what it steps over."""
    body = _any_above(solid, step, tall).reshape(*shape, -1)
    result = _any_above(solid, 0, max(step, 1)).reshape(*shape, -1)
    for x in range(-radius, radius + 1):
        for y in range(-radius, radius + 1):
            if x * x + y * y <= radius * radius:
                here = tuple(slice(max(0, -d), n - max(0, d)) for d, n in zip((x, y), shape, strict=True))
                there = tuple(slice(max(0, d), n - max(0, -d)) for d, n in zip((x, y), shape, strict=True))
                result[here] |= body[there]
    return np.asarray(result.reshape(solid.shape))


def _any_above(solid: Bools, first: int, last: int) -> Bools:
    """Whether any of the cells k + first to k + last - 1 is solid [I * J, K]; above the grid is air."""
    result, width = solid.copy(), 1
    while width < last - first:  # doubling: a run of 2 w is two runs of w
        shift = min(width, last - first - width)
        result[:, :-shift] |= result[:, shift:].copy()
        width += shift
    if first:
        result[:, :-first] = result[:, first:].copy()
        result[:, -first:] = False
    return result


def _landing(free: Bools, grid: Grid, kill_z_m: float) -> Levels:
    """The level down to which everything is free [I * J, K]; -1 where that is out of the world."""
    levels = np.arange(free.shape[1], dtype=np.int16)
    result = np.maximum.accumulate(np.where(free, np.int16(-1), levels[None]), axis=1)
    fallen = (result < 0) | (grid.low[2] + (result + 1) * grid.cell_height_m < kill_z_m)
    return np.asarray(np.where(fallen, -1, result + 1), dtype=np.int16)
