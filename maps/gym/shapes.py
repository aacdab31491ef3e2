"""The pieces of the exercises, by extents, and the shapes that no piece can be."""

from __future__ import annotations

import numpy as np
from kit.mesh import prism
from kit.pieces import Piece, Rect, box

from gym.exercise import Floats

WIDE_M = 3.0  # half the width of a lane


def floor(x0: float, x1: float, thick_m: float = 1.0, half_m: float = WIDE_M) -> Piece:
    """The floor of a lane at height 0."""
    return box("floor", "platform", Rect(x0, -half_m, x1, half_m), -thick_m, 0.0)


def block(x0: float, x1: float, y0: float, y1: float, top: float, base: float = 0.0) -> Piece:
    """An obstacle."""
    return box("block", "block", Rect(x0, y0, x1, y1), base, top)


def stage(x0: float, x1: float, top: float, half_m: float = WIDE_M, base: float = 0.0) -> Piece:
    """A box across the lane to stand on."""
    return box("stage", "platform", Rect(x0, -half_m, x1, half_m), base, top)


def ramp(x0: float, length: float, degrees: float, half_m: float = WIDE_M, uphill: str = "+x") -> Piece:
    """A solid ramp across the lane, `length` [m] along its slope."""
    run, rise = length * np.cos(np.radians(degrees)), length * np.sin(np.radians(degrees))
    return Piece("ramp", "ramp", (x0, -half_m, 0.0), (x0 + float(run), half_m, float(rise)), uphill)


def end_of(piece: Piece) -> tuple[float, float]:
    """Where a ramp ends: x and height [m]."""
    return piece.high[0], piece.high[2]


def triangles_of(piece: Piece) -> Floats:
    """The closed surface of a piece [F, 3, 3], normals outwards."""
    vertices, faces = prism(piece)
    return vertices[faces]


def column(outline: Floats, top: float) -> Floats:
    """The closed surface [F, 3, 3] over a convex outline [n, 2], anticlockwise, from height 0 to `top` [m]."""
    n = len(outline)
    low, high = np.pad(outline, ((0, 0), (0, 1))), np.pad(outline, ((0, 0), (0, 1)), constant_values=top)
    high[:, :2] = outline
    faces = []
    for k in range(n):
        j = (k + 1) % n
        faces += [(low[k], low[j], high[j]), (low[k], high[j], high[k])]
    for k in range(1, n - 1):
        faces += [(high[0], high[k], high[k + 1]), (low[0], low[k + 1], low[k])]
    return np.array(faces)


def tiled_floor(x0: float, x1: float, half_m: float, cell_m: float) -> Floats:
    """A one-sided floor at height 0 [F, 3, 3] of small triangles."""
    xs, ys = np.arange(x0, x1, cell_m), np.arange(-half_m, half_m, cell_m)
    x, y = (side.ravel() for side in np.meshgrid(xs, ys))
    a, b = np.stack([x, y], axis=1), np.stack([x + cell_m, y], axis=1)
    c, d = np.stack([x + cell_m, y + cell_m], axis=1), np.stack([x, y + cell_m], axis=1)
    flat = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    return np.pad(flat, ((0, 0), (0, 0), (0, 1)))
