"""Props of every convex kind thrown in a yard: leaning, floating, one inside another."""

from __future__ import annotations

import numpy as np
import trimesh
from shapes import box, walls

CLEAR_M, WALL_M, THICK_M = 1.5, 8.0, 0.5


def make(rng: np.random.Generator) -> tuple[list[trimesh.Trimesh], np.ndarray]:
    """The pieces, and a place to start from [3]."""
    side = float(rng.uniform(16, 32))
    pieces = [box([0, 0, -0.5], [side, side, 0])]
    for _ in range(int(rng.integers(20, 70))):
        prop = _prop(rng)
        turn = trimesh.transformations.rotation_matrix(rng.uniform(0, 2 * np.pi), [0, 0, 1])
        if rng.random() < 0.6:
            turn = trimesh.transformations.random_rotation_matrix(rng.random(3))
        prop.apply_transform(turn)
        lifted = (rng.random() < 0.25) * rng.uniform(0.5, 3) - rng.uniform(0, 0.3)
        prop.apply_translation([*rng.uniform(1, side - 1, 2), lifted - prop.bounds[0][2]])
        low, high = prop.bounds[:, :2] - side / 2
        if not ((low < CLEAR_M) & (high > -CLEAR_M)).all():
            pieces.append(prop)
    top = max(piece.bounds[1][2] for piece in pieces) + WALL_M
    return pieces + walls((side, side), THICK_M, -0.5, top), np.array([side / 2, side / 2, 0.05])


def _prop(rng: np.random.Generator) -> trimesh.Trimesh:
    kind, sides = rng.integers(0, 6), int(rng.integers(5, 20))
    if kind == 0:
        return trimesh.creation.box(extents=rng.uniform(0.3, 3, 3))
    if kind == 1:
        return trimesh.creation.cylinder(rng.uniform(0.2, 1.2), rng.uniform(0.3, 4), sections=sides)
    if kind == 2:
        return trimesh.creation.cone(rng.uniform(0.4, 2), rng.uniform(0.5, 3), sections=sides)
    if kind == 3:
        return trimesh.creation.icosphere(2, rng.uniform(0.3, 1.5))
    if kind == 4:  # a plank
        return trimesh.creation.box(
            extents=[rng.uniform(2, 5), rng.uniform(0.3, 1.2), rng.uniform(0.05, 0.2)]
        )
    return trimesh.convex.convex_hull(rng.uniform(-1.5, 1.5, (sides, 3)))
