"""Upright boxes turned about the vertical, and triangles cut by them exactly.

Shape legend: F triangles, n points.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from reachtest.records import Bools, Floats

_SIDES = ("back", "front", "right", "left", "bottom", "top")
_THICKEST_M = 3.0  # floor or wall that is cut through
_SHEETS_APART_M = 1.6
_THIN_M2 = 1e-10  # pieces of less area than that are rounding


@dataclass(frozen=True)
class Box:
    """A box with its own axes: x is `yaw` from the level's x, z stays up."""

    centre: Floats  # [3] m
    half: Floats  # [3] m
    yaw: float = 0.0  # rad

    @property
    def axes(self) -> Floats:
        """Unit vectors [3, 3] of its x, y and z, row by row."""
        c, s = np.cos(self.yaw), np.sin(self.yaw)
        return np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])

    @property
    def bounds(self) -> tuple[Floats, Floats]:
        """The axis-aligned box around it: low [3], high [3]."""
        reach = np.abs(self.axes * self.half[:, None]).sum(axis=0)
        return self.centre - reach, self.centre + reach

    def contains(self, points: Floats, margin_m: float = 0.0) -> Bools:
        """Which of `points` [n, 3] lie in it, or within a margin of its sides."""
        local = (points - self.centre) @ self.axes.T
        return np.asarray((np.abs(local) <= self.half + margin_m).all(axis=1), dtype=np.bool_)

    def faces(self, names: Sequence[str] = _SIDES, inwards: bool = False) -> Floats:
        """Triangles [2 * names, 3, 3] of the named sides: back and front (x), right and left (y), bottom, top."""
        triangles = []
        for name in names:
            axis, sign = divmod(_SIDES.index(name), 2)[0], 1.0 if _SIDES.index(name) % 2 else -1.0
            u, v = np.roll(np.eye(3), -1, axis=0)[axis], np.roll(np.eye(3), -2, axis=0)[axis]
            middle = np.eye(3)[axis] * sign
            corners = [middle - u - v, middle + u - v, middle + u + v, middle - u + v]
            if (sign < 0) != inwards:
                corners = corners[::-1]
            quad = self.centre + (np.array(corners) * self.half) @ self.axes
            triangles += [quad[[0, 1, 2]], quad[[0, 2, 3]]]
        return np.array(triangles)


def cut_out(triangles: Floats, box: Box) -> Floats:
    """What of triangles [F, 3, 3] lies outside the box, exactly; orientation is kept."""
    local = (triangles - box.centre) @ box.axes.T
    touched = ((local.min(axis=1) < box.half) & (local.max(axis=1) > -box.half)).all(axis=1)
    pieces = [piece for triangle in local[touched] for piece in _outside(triangle, box.half)]
    back = np.array(pieces).reshape(-1, 3, 3) @ box.axes + box.centre
    return np.concatenate([triangles[~touched], back])


def _outside(triangle: Floats, half: Floats) -> list[Floats]:
    """Triangles [3, 3] that cover what of one lies outside a box about the origin.

    Side by side: what is beyond it is kept, what is not goes on to the next. If nothing is left at the end, the
    triangle only passed the box by, and stays whole.
    """
    inside, kept = triangle, []
    for axis in range(3):
        for sign in (-1.0, 1.0):
            height = sign * inside[:, axis] - half[axis]
            kept.append(_half(inside, height))
            inside = _half(inside, -height)
            if len(inside) < 3:
                return [triangle]
    fans = [polygon[[0, i, i + 1]] for polygon in kept for i in range(1, len(polygon) - 1)]
    return [fan for fan in fans if np.linalg.norm(np.cross(fan[1] - fan[0], fan[2] - fan[0])) > 2 * _THIN_M2]


def _half(polygon: Floats, height: Floats) -> Floats:
    """The part [m, 3] of a convex polygon [n, 3] where `height` [n] is not negative (Sutherland and Hodgman)."""
    corners = []
    for i in range(len(polygon)):
        j = (i + 1) % len(polygon)
        if height[i] >= 0:
            corners.append(polygon[i])
        if (height[i] > 0 > height[j]) or (height[i] < 0 < height[j]):
            share = height[i] / (height[i] - height[j])
            corners.append(polygon[i] + share * (polygon[j] - polygon[i]))
    return np.array(corners).reshape(-1, 3)


def ray_hits(triangles: Floats, origin: Floats, direction: Floats, reach_m: float) -> tuple[Floats, Floats]:
    """Where a ray meets triangles [F, 3, 3]: distances [n] [m], nearest first, and normal times direction [n].

    Moeller and Trumbore, JGT 2(1), 1997.
    """
    a, u, v = triangles[:, 0], triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    across = np.cross(direction, v)
    det = np.einsum("fi,fi->f", u, across)
    safe = np.where(np.abs(det) > 1e-12, det, np.inf)
    away = origin - a
    s = np.einsum("fi,fi->f", away, across) / safe
    turned = np.cross(away, u)
    t = turned @ direction / safe
    distance = np.einsum("fi,fi->f", v, turned) / safe
    hit = np.isfinite(safe) & (s >= 0) & (t >= 0) & (s + t <= 1) & (distance > 0) & (distance <= reach_m)
    order = np.flatnonzero(hit)[np.argsort(distance[hit], kind="stable")]
    return distance[order], -det[order]  # det = -(normal . direction) up to length


def thickness(collision: Floats, origin: Floats, direction: Floats, reach_m: float) -> float | None:
    """How thick what a ray meets is [m]: from its first face within reach to where it has left all it entered.

    0 for a single sheet, None if there is nothing or it is too thick.
    """
    distance, against = ray_hits(collision, origin, direction, reach_m + _THICKEST_M)
    if not len(distance) or distance[0] > reach_m:
        return None
    depth = np.cumsum(np.where(against < 0, 1, -1))
    out = np.flatnonzero(depth <= 0)
    if depth[0] < 0 or not len(out):  # seen from behind, or never left: a sheet, as far as one can tell
        alone = len(distance) == 1 or distance[1] - distance[0] > _SHEETS_APART_M
        return 0.0 if alone or depth[0] < 0 else None
    return float(distance[out[0]] - distance[0])
