"""Whether anything is in between: segments against the collision triangles.

Shape legend: s segments, F triangles.
"""

from __future__ import annotations

import numpy as np

from reachtest.connected import grouped
from reachtest.records import Bools, Character, Floats

_PAIRS_AT_ONCE = 1 << 18
_CELL_M = 8.0  # segments that begin in one cell are looked at together
_OVER_M = 0.5  # of the body, above the highest that one jumps: there is a wall, or nothing


class Walls:
    """The triangles of a level."""

    def __init__(self, triangles: Floats) -> None:
        """Prepare `triangles` [F, 3, 3]."""
        self._triangles = triangles
        self._low, self._high = triangles.min(axis=1), triangles.max(axis=1)

    def between(self, starts: Floats, ends: Floats) -> Bools:
        """Whether each segment [s] from `starts` [s, 3] to `ends` [s, 3] meets a triangle (Möller & Trumbore, from
        both sides)."""
        result = np.zeros(len(starts), dtype=np.bool_)
        if not len(starts):
            return result
        low, high = np.minimum(starts, ends).min(axis=0), np.maximum(starts, ends).max(axis=0)
        triangles = self._triangles[((self._low <= high) & (self._high >= low)).all(axis=1)]
        size = max(1, _PAIRS_AT_ONCE // max(1, len(triangles)))
        for begin in range(0, len(starts) if len(triangles) else 0, size):
            some = slice(begin, begin + size)
            result[some] = _meets(starts[some], ends[some] - starts[some], triangles).any(axis=1)
        return result

    def behind(self, footings: Floats, places: Floats, who: Character) -> Bools:
        """Which of `places` [s, 3] nobody gets to straight from `footings` [s, 3], neither walking nor jumping."""
        apex = who.jump_speed_mps**2 / (2 * who.gravity_mps2)
        result = np.zeros(len(footings), dtype=np.bool_)
        known = np.flatnonzero(np.isfinite(places[:, 0]))
        _, cell = np.unique(np.floor(footings[known] / _CELL_M), axis=0, return_inverse=True)
        for group in grouped(cell.ravel()):
            rows = known[group]
            level = places[rows] * [1.0, 1.0, 0.0] + footings[rows] * [0.0, 0.0, 1.0]
            both = [[0.0, 0.0, up] for up in (who.step_height_m + 0.1, min(apex + _OVER_M, who.height_m))]
            result[rows] = np.logical_and.reduce(
                [self.between(footings[rows] + up, level + up) for up in both]
            )
        return result


def _meets(starts: Floats, along: Floats, triangles: Floats) -> Bools:
    """Whether each segment [s, 3] and each triangle [F, 3, 3] meet [s, F]."""
    u, v = triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    p = np.cross(along[:, None], v[None])
    determinant = np.einsum("sfi,fi->sf", p, u)
    with np.errstate(divide="ignore", invalid="ignore"):
        inverse = 1.0 / determinant
        away = starts[:, None] - triangles[None, :, 0]
        s = np.einsum("sfi,sfi->sf", away, p) * inverse
        q = np.cross(away, u[None])
        t = np.einsum("si,sfi->sf", along, q) * inverse
        at = np.einsum("sfi,fi->sf", q, v) * inverse
        inside = (s >= 0) & (t >= 0) & (s + t <= 1) & (at >= 0) & (at <= 1)
    return np.asarray(inside & (np.abs(determinant) > 1e-12), dtype=np.bool_)
