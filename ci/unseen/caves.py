"""Caves: a rough floor and a rough ceiling that meet in wedges, halls joined by passages."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import trimesh
from shapes import mesh, surface, waves

CELL_M, CLEAR_M = 0.5, 1.4


def make(rng: np.random.Generator) -> tuple[list[trimesh.Trimesh], np.ndarray]:
    """The pieces, and a place to start from [3]."""
    n = int(rng.integers(60, 100))
    halls = rng.uniform(6, n * CELL_M - 6, (int(rng.integers(4, 9)), 2))
    room = _room(rng, n, halls)
    floor = waves(rng, n) * rng.uniform(0.1, 0.6) + rng.normal(size=(n, n)) * rng.choice([0.0, 0.04, 0.1])
    clear = np.minimum(room, rng.uniform(3, 5)) * rng.uniform(0.9, 1.6) + rng.normal(size=(n, n)) * 0.1
    clear[[0, -1]] = clear[:, [0, -1]] = -1.0
    at = np.round(halls[0] / CELL_M).astype(int)
    near = np.hypot(*(np.indices((n, n)) * CELL_M - halls[0][:, None, None])) < CLEAR_M
    floor[near], clear[near] = floor[tuple(at)], np.maximum(clear[near], 3.0)
    open_ = (surface(clear, CELL_M)[:, :, 2] > -0.5).any(axis=1)  # both end where the rock is solid
    ceiling = surface(floor + clear, CELL_M)[open_, ::-1]
    pieces = [mesh(surface(floor, CELL_M)[open_]), mesh(ceiling)]
    return pieces, np.append(at * CELL_M, floor[tuple(at)] + 0.05)


def _room(rng: np.random.Generator, n: int, halls: np.ndarray) -> np.ndarray:
    """How far from the rock [n, n]: less than nothing in it."""
    x, y = np.indices((n, n)) * CELL_M
    room = np.full((n, n), -10.0)
    for hall in halls:
        room = np.maximum(room, 1.5 * (rng.uniform(2.5, 5) - np.hypot(x - hall[0], y - hall[1])))
    for a, b in pairwise(halls):
        way = b - a
        along = np.clip(((x - a[0]) * way[0] + (y - a[1]) * way[1]) / (way @ way), 0, 1)
        away = np.hypot(x - a[0] - along * way[0], y - a[1] - along * way[1])
        room = np.maximum(room, 2.0 * (rng.uniform(1.2, 2.2) - away))
    return room
