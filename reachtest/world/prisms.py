"""Prisms: what a triangle, or two of one plane, collide as.

Shape legend: n polygons of C corners each.
"""

from __future__ import annotations

import numpy as np

from reachtest.records import Floats
from reachtest.world.coplanar import is_rectangle
from reachtest.world.pieces import CORNERS, PRISM_M, Pieces

MIN_ALTITUDE_M = 1e-3  # thinner slivers make no convex hull; the gap they leave is as thin
_MOST_INSET = 0.8  # of the way to a polygon's middle: its prism keeps some width below


def prisms(polygons: Floats, insets: Floats) -> Pieces:
    """Prisms of convex polygons [n, C, 3], narrower below where their edges [n, C] have insets."""
    sides = np.roll(polygons, -1, axis=1) - polygons
    length = np.linalg.norm(sides, axis=2)
    along = sides / np.maximum(length, 1e-12)[:, :, None]
    normal = np.cross(sides, np.roll(sides, -1, axis=1)).sum(axis=1)
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
    below = polygons - PRISM_M * normal[:, None] + _moved_in(polygons, along, normal, insets)
    spare = [below[:, -1:]] * (CORNERS - 2 * polygons.shape[1])
    corners = np.concatenate([polygons, below, *spare], axis=1)
    half, axes = np.full((len(polygons), 3), np.nan), np.tile(np.eye(3), (len(polygons), 1, 1))
    if polygons.shape[1] == 4:
        box = is_rectangle(polygons) & (length.min(axis=1) > MIN_ALTITUDE_M) & ~insets.any(axis=1)
        half[box] = np.stack([length[box, 0], length[box, 1], np.full(int(box.sum()), PRISM_M)], axis=1) / 2
        across = np.cross(normal[box], along[box, 0])
        axes[box] = np.stack([along[box, 0], across, normal[box]], axis=2)
    count = np.full(len(polygons), 2 * polygons.shape[1])
    return Pieces(corners, count, half, axes)


def _moved_in(polygons: Floats, along: Floats, normal: Floats, insets: Floats) -> Floats:
    """How the corners [n, C, 3] move when the edges move in by `insets` [n, C], as far as there is room."""
    inward = np.cross(np.broadcast_to(normal[:, None], along.shape), along)
    middle = polygons.mean(axis=1, keepdims=True)
    room = ((middle - polygons) * inward).sum(axis=2)
    worst = (insets / np.maximum(room, 1e-12)).max(axis=1, initial=0.0)
    insets = insets * np.minimum(1.0, _MOST_INSET / np.maximum(worst, 1e-12))[:, None]
    before, width = np.roll(inward, 1, axis=1), np.roll(insets, 1, axis=1)
    # The corner's move x lies in the plane, with x . before = width and x . inward = inset.
    cos = (before * inward).sum(axis=2)
    scale = 1.0 / np.maximum(1 - cos**2, 1e-6)
    a, b = (width - cos * insets) * scale, (insets - cos * width) * scale
    return np.asarray(a[:, :, None] * before + b[:, :, None] * inward)
