"""Closed triangle meshes of the pieces, one each; the rest is the kit's."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))  # for the kit

import numpy as np
from kit import mesh as kit_mesh
from kit.mesh import Floats, Ints, Mesh, y_up
from layout import STEP_RISE_M, STEP_TREAD_M, Piece

__all__ = ["Floats", "Ints", "Mesh", "glb", "prism", "y_up"]


def profile(piece: Piece, run: float) -> list[tuple[float, float]]:
    """The outline (way uphill, height) [m]; its first corner, low at the top end, sees all of it."""
    rise = piece.high[2] - piece.low[2]
    if piece.kind == "ramp":
        return [(run, 0), (run, rise), (0, 0)]
    if piece.kind == "stairs":
        steps = round(rise / STEP_RISE_M)
        corners = [(k * STEP_TREAD_M, (k + up) * STEP_RISE_M) for k in range(steps) for up in (0, 1)]
        return [(run, 0), (run, rise), *reversed(corners)]
    return [(run, 0), (run, rise), (0, rise), (0, 0)]


def prism(piece: Piece) -> Mesh:
    """The closed surface of `piece`, outward normals by the right-hand rule."""
    low, high = np.array(piece.low, float), np.array(piece.high, float)
    along = 0 if piece.uphill[1] == "x" else 1
    size = high - low
    outline = profile(piece, size[along])
    n = len(outline)
    local = np.zeros((2 * n, 3))
    for side in (0, 1):
        for k, (way, up) in enumerate(outline):
            local[side * n + k, along] = way if piece.uphill[0] == "+" else size[along] - way
            local[side * n + k, 1 - along] = side * size[1 - along]
            local[side * n + k, 2] = up
    near = [(0, k, k + 1) for k in range(1, n - 1)]
    far = [(n, n + k + 1, n + k) for k in range(1, n - 1)]
    ring = [(k, (k + 1) % n) for k in range(n)]
    around = [face for a, b in ring for face in ((a, n + a, b), (b, n + a, n + b))]
    faces = np.array(near + far + around)
    corners = local[faces]
    volume = np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2]))
    origin = np.array([*(low + high)[:2] / 2, low[2]])
    return Mesh(piece.name, local + low - origin, faces if volume > 0 else faces[:, ::-1], origin)


def glb(meshes: Sequence[Mesh]) -> bytes:
    """A y-up binary glTF with one named node a mesh."""
    return kit_mesh.glb(meshes, "maps/small/make.py")
