"""Hills with rocks, trees, trenches and terraces inside a wall: slopes on both sides of every limit."""

from __future__ import annotations

import numpy as np
import trimesh
from shapes import mesh, surface, walls, waves

WALL_M, THICK_M, CELL_M, CLEAR_M = 8.0, 0.5, 1.0, 4.0


def make(rng: np.random.Generator) -> tuple[list[trimesh.Trimesh], np.ndarray]:
    """The pieces, and a place to start from [3]."""
    n = int(rng.integers(30, 56))
    height = waves(rng, n)
    if rng.random() < 0.5:
        row, width = int(rng.integers(8, n - 10)), int(rng.integers(2, 5))
        height[row : row + width] -= rng.uniform(1.0, 4.0)  # a trench
    if rng.random() < 0.5:
        step, part = rng.choice([0.4, 0.8, 1.5]), int(n * rng.random())
        height[:part] = np.round(height[:part] / step) * step  # terraces
    at = rng.integers(6, n - 6, 2)
    height[at[0] - 2 : at[0] + 3, at[1] - 2 : at[1] + 3] = height[tuple(at)]
    side, pieces = (n - 1) * CELL_M, [mesh(surface(height, CELL_M))]
    for _ in range(int(rng.integers(5, 30))):
        where = rng.uniform(2, side - 2, 2)
        if np.linalg.norm(where - at * CELL_M) > CLEAR_M:
            ground = height[tuple(np.round(where / CELL_M).astype(int))]
            pieces.append(_thing(rng, np.append(where, ground)))
    top = max(piece.bounds[1][2] for piece in pieces) + WALL_M
    pieces += walls((side, side), THICK_M, height.min() - 2, top)
    return pieces, np.append(at * CELL_M, height[tuple(at)] + 0.05)


def _thing(rng: np.random.Generator, ground: np.ndarray) -> trimesh.Trimesh:
    """A tree or a rock that stands a little in the ground."""
    if rng.random() < 0.4:
        tree = trimesh.creation.cylinder(rng.uniform(0.15, 0.5), 7.0, sections=8)
        return tree.apply_translation(ground + [0, 0, 2.0])
    size, points = rng.uniform(0.4, 2.2), rng.normal(size=(24, 3))
    points *= size * rng.uniform(0.7, 1.0, (24, 1)) / np.linalg.norm(points, axis=1)[:, None]
    return trimesh.convex.convex_hull(points).apply_translation(
        ground + [0, 0, size * rng.uniform(-0.3, 0.4)]
    )
