"""Triangles cut by the strips and columns of a grid, pair by pair; x and y in cells.

Shape legend: S (triangle, strip) pairs, P (triangle, column) pairs, n numbers.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from reachtest.records import Bools, Floats, Ints

Reals = NDArray[np.floating[Any]]

STILL = 1e-12  # [cells] a segment this short along an axis does not move: its share would overflow
TOUCH = 1e-6  # [cells] what only touches a column is not in it: rounding of coordinates, well below any cell


def across(flat: Floats, strip: Ints) -> tuple[Floats, Floats, Floats, Floats]:
    """What of each triangle [S, 3, 2] lies in its strip x in [strip, strip + 1]: the y range [S], and the
    range that is in the triangle at every x of the strip (empty: low above high)."""
    low, full_low = np.full(len(flat), np.inf), np.full(len(flat), -np.inf)
    high, full_high = -low, -full_low
    left, right = strip.astype(np.float64), strip + 1.0
    sides = [(np.full(len(flat), np.inf), np.full(len(flat), -np.inf)) for _ in range(2)]
    for k in range(3):
        a, b = flat[:, k], flat[:, (k + 1) % 3]
        begin, end, valid = _clip_axis(a[:, 0], b[:, 0] - a[:, 0], left - 2 * TOUCH, right + 2 * TOUCH)
        for share in (begin, end):
            y = a[:, 1] + share * (b[:, 1] - a[:, 1])
            low = np.where(valid, np.minimum(low, y), low)
            high = np.where(valid, np.maximum(high, y), high)
        for side, x in enumerate((left, right)):
            meets = (np.minimum(a[:, 0], b[:, 0]) <= x) & (np.maximum(a[:, 0], b[:, 0]) >= x)
            run = b[:, 0] - a[:, 0]
            y = a[:, 1] + (x - a[:, 0]) / np.where(np.abs(run) < STILL, 1.0, run) * (b[:, 1] - a[:, 1])
            least, most = sides[side]
            sides[side] = (
                np.where(meets, np.minimum(least, y), least),
                np.where(meets, np.maximum(most, y), most),
            )
    for least, most in sides:  # a side that the triangle does not reach leaves nothing
        full_low, full_high = np.maximum(full_low, least), np.minimum(full_high, most)
    return low, high, full_low, full_high


def _clip_axis(start: Reals, along: Reals, low: Reals, high: Reals) -> tuple[Floats, Floats, Bools]:
    """Shares [0, 1] of segments between which start + share * along lies in [low, high]; and if there are any."""
    still = np.abs(along) < STILL
    safe = np.where(still, 1.0, along)
    one, two = (low - start) / safe, (high - start) / safe
    begin = np.where(still, 0.0, np.maximum(np.minimum(one, two), 0.0))
    end = np.where(still, 1.0, np.minimum(np.maximum(one, two), 1.0))
    return begin, end, np.where(still, (start >= low) & (start <= high), begin <= end)


def cut_heights(corners: Floats, cell: Ints, rate: Floats, steep: Bools) -> tuple[Floats, Floats, Bools]:
    """Heights of what of a triangle [P, 3, 3] lies in column `cell` [P, 2]: its corners are where the triangle's
    edges are cut by the column's sides, and the column's corners that lie in the triangle. And whether the
    column's centre does [P]."""
    low, high = np.full(len(cell), np.inf), np.full(len(cell), -np.inf)
    side = [(cell[:, axis] - 2 * TOUCH, cell[:, axis] + 1 + 2 * TOUCH) for axis in (0, 1)]
    for k in range(3):
        a, along = corners[:, k], corners[:, (k + 1) % 3] - corners[:, k]
        begin, end, valid = _clip_axis(a[:, 0], along[:, 0], *side[0])
        also_begin, also_end, also = _clip_axis(a[:, 1], along[:, 1], *side[1])
        begin, end = np.maximum(begin, also_begin), np.minimum(end, also_end)
        valid &= also & (begin <= end)
        for share in (begin, end):
            z = a[:, 2] + share * along[:, 2]
            low = np.where(valid, np.minimum(low, z), low)
            high = np.where(valid, np.maximum(high, z), high)
    for corner in ((0, 0), (0, 1), (1, 0), (1, 1)):
        point = (cell + corner).astype(np.float64)
        away = point - corners[:, 0, :2]
        z = corners[:, 0, 2] + np.einsum("pi,pi->p", rate, away)
        within = ~steep & holds(corners[:, :, :2], point)
        low = np.where(within, np.minimum(low, z), low)
        high = np.where(within, np.maximum(high, z), high)
    over_centre = ~steep & holds(corners[:, :, :2], cell + 0.5)
    nothing = low > high  # a sliver that only rounding puts into the column
    least, most = corners[:, :, 2].min(axis=1), corners[:, :, 2].max(axis=1)
    return np.where(nothing, least, low), np.where(nothing, most, high), over_centre


def holds(flat: Reals, point: Reals) -> Bools:
    """Whether triangles [P, 3, 2] of either orientation hold their point [P, 2], their edges included."""
    signs = []
    for k in range(3):
        along, away = flat[:, (k + 1) % 3] - flat[:, k], point - flat[:, k]
        signs.append(along[:, 0] * away[:, 1] - along[:, 1] * away[:, 0])
    return np.asarray((np.minimum.reduce(signs) >= 0) | (np.maximum.reduce(signs) <= 0))
