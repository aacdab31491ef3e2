"""Pieces that the kinds of levels share, z up, in metres."""

from __future__ import annotations

import numpy as np
import trimesh

from reachtest.geometry import grid_surface


def box(low: object, high: object) -> trimesh.Trimesh:
    """An axis-aligned box."""
    low, high = np.asarray(low, dtype=float), np.asarray(high, dtype=float)
    piece = trimesh.creation.box(extents=high - low)
    piece.apply_translation((low + high) / 2)
    return piece


def walls(size: tuple[float, float], half_m: float, bottom: float, top: float) -> list[trimesh.Trimesh]:
    """Along the sides of [0, size x] x [0, size y], `half_m` to either side of them."""
    (x, y), t = size, half_m
    return [
        box([-t, -t, bottom], [t, y + t, top]),
        box([x - t, -t, bottom], [x + t, y + t, top]),
        box([-t, -t, bottom], [x + t, t, top]),
        box([-t, y - t, bottom], [x + t, y + t, top]),
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


def surface(height: np.ndarray, cell_m: float) -> np.ndarray:
    """The triangles [F, 3, 3] of heights [n, n], the first index along x; they face up."""
    x, y = np.indices(height.shape) * cell_m
    return grid_surface(np.stack([x, y, height], -1).swapaxes(0, 1))


def mesh(triangles: np.ndarray) -> trimesh.Trimesh:
    """Triangles [F, 3, 3] as a piece."""
    return trimesh.Trimesh(**trimesh.triangles.to_kwargs(triangles), process=False)
