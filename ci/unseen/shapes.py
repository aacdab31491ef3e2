"""Pieces that the kinds of levels share, z up, in metres."""

from __future__ import annotations

import numpy as np
import trimesh

THICK_M = 0.5  # a wall, to either side


def box(low: object, high: object) -> trimesh.Trimesh:
    """An axis-aligned box."""
    low, high = np.asarray(low, dtype=float), np.asarray(high, dtype=float)
    piece = trimesh.creation.box(extents=high - low)
    piece.apply_translation((low + high) / 2)
    return piece


def walls(side: float, bottom: float, top: float) -> list[trimesh.Trimesh]:
    """Around a square of [0, side] x [0, side]."""
    t, far = THICK_M, side + THICK_M
    return [
        box([-t, -t, bottom], [t, far, top]),
        box([side - t, -t, bottom], [far, far, top]),
        box([-t, -t, bottom], [far, t, top]),
        box([-t, side - t, bottom], [far, far, top]),
    ]


def waves(rng: np.random.Generator, n: int) -> np.ndarray:
    """Heights [n, n] of hills and hollows 6 to 40 cells long, the long ones higher."""
    x, y = np.meshgrid(np.arange(n), np.arange(n), indexing="ij")
    result = np.zeros((n, n))
    for _ in range(14):
        length, way = rng.uniform(6, 40), rng.uniform(0, 2 * np.pi)
        along = (x * np.cos(way) + y * np.sin(way)) * 2 * np.pi / length + rng.uniform(0, 2 * np.pi)
        result += np.sin(along) * length * 0.035 * rng.uniform(0.3, 1.0)
    return result


def surface(height: np.ndarray, cell_m: float, *, down: bool = False) -> trimesh.Trimesh:
    """Two triangles a cell through heights [n, n], facing up, or down."""
    n = len(height)
    x, y = np.meshgrid(np.arange(n) * cell_m, np.arange(n) * cell_m, indexing="ij")
    index = np.arange(n * n).reshape(n, n)
    a, b, c, d = index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]
    faces = np.concatenate([np.stack(corners, -1).reshape(-1, 3) for corners in ([a, b, c], [a, c, d])])
    vertices = np.stack([x, y, height], -1).reshape(-1, 3)
    return trimesh.Trimesh(vertices, faces[:, ::-1] if down else faces, process=False)
