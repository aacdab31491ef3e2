"""Triangles of a surface that is sampled on a grid, as height maps and MuJoCo's height fields are.

Shape legend: R rows, towards +y; C columns, towards +x.
"""

from __future__ import annotations

import numpy as np

from reachtest.records import Floats

MOST_SAMPLES = 1025 * 1025
"""2.1 million triangles, 0.15 GB a copy: a larger terrain is cut into tiles or sampled more coarsely."""


def too_large(rows: int, columns: int) -> tuple[str, str] | None:
    """What is wrong with a grid of this many samples, and the remedy; None if nothing is."""
    size = f"{columns} x {rows} samples"
    if min(rows, columns) < 2:
        return f"has {size}: no cell between them", "give at least 2 x 2 samples"
    if rows * columns > MOST_SAMPLES:
        remedy = f"sample it more coarsely or cut it into tiles: up to {MOST_SAMPLES:,} each"
        return f"has {size}, {rows * columns:,} in all", remedy
    return None


def grid_points(heights: Floats, size: tuple[float, float]) -> Floats:
    """Positions [R, C, 3] of `heights` [R, C], the first at x = y = 0, the last at x, y = `size`."""
    rows, columns = heights.shape
    x, y = np.meshgrid(np.linspace(0, size[0], columns), np.linspace(0, size[1], rows))
    return np.stack([x, y, heights], axis=2)


def skirt(points: Floats, bottom: float) -> Floats:
    """Walls and floor that close the surface of `points` [R, C, 3] down to z = `bottom`: [F, 3, 3]."""
    ring = np.concatenate([points[0, :-1], points[:-1, -1], points[-1, :0:-1], points[:0:-1, 0]])
    down = np.concatenate([ring[:, :2], np.full((len(ring), 1), bottom)], axis=1)
    ring_next, down_next = np.roll(ring, -1, axis=0), np.roll(down, -1, axis=0)
    middle = np.broadcast_to(down.mean(axis=0), down.shape)
    faces = [(down, down_next, ring_next), (down, ring_next, ring), (middle, down_next, down)]
    return np.concatenate([np.stack(corners, axis=1) for corners in faces])
