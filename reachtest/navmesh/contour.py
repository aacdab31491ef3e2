"""Walkable places to a few flat patches: rows of places become runs, runs above each other trapezoids.

A run or a trapezoid goes on as long as one straight line from its first to its last place follows the heights, and
for trapezoids also the two ends, within a tolerance: the swing filter for piecewise linear approximation
(Elmeleegy et al., VLDB 2009), which needs one look at each place. Shape legend: M places, R runs, Q patches.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from reachtest.geometry import expand
from reachtest.navmesh.walkable import Places
from reachtest.records import Bools, Floats, Ints

END_TOLERANCE = 0.75  # [cells] of a patch's side; Recast's maxSimplificationError is 1.3 by default
END_STEP = (
    2.0  # [cells] a side may move from one row to the next: patches reach half a step beyond their rows
)


@dataclass(frozen=True)
class Patches:
    """Trapezoids with two sides along x: corners in cells (x, y) and metres (z)."""

    corners: Floats  # [Q, 4, 3] counter-clockwise from the left end of the lower row
    label: Ints  # [Q] of the island


def patches(
    places: Places, floor: Floats, label: Ints, rows: int, tolerance_m: float, step_m: float
) -> Patches:
    """Cover the places, whose `floor` [M] [m] is known, within `tolerance_m` of it; `rows` is shape[1].

    Where the floor rises by more than `step_m` from one cell to the next a patch ends: that is a step, no slope.
    """
    i, j = places.column // rows, places.column % rows
    run, first, last = _runs(places, i, floor, tolerance_m, step_m)
    length = i[last] - i[first]
    rate = (floor[last] - floor[first]) / np.maximum(length, 1)
    ends = np.stack([i[first], i[last] + 1, floor[first] - rate / 2, floor[last] + rate / 2], axis=1)
    seam = np.stack([places.neighbour[0, first], places.neighbour[2, last]], axis=1) >= 0
    below = _run_below(places, run, len(first))
    below = np.where((seam == seam[below]).all(axis=1), below, -1)
    sides = np.where(seam, 0.0, END_TOLERANCE)  # two patches that meet have one straight border, and no gap
    tolerance = np.concatenate([sides, np.full_like(sides, tolerance_m)], axis=1)
    step = np.where(seam, 0.0, END_STEP)
    bottom, top = _stacks(ends, j[first], below, tolerance, step, step_m)
    return _split(_trapezoids(ends, j[first], bottom, top), label[first[bottom]], tolerance_m)


def _slices(sorted_values: Ints) -> list[slice]:
    """The stretches of equal values."""
    if not len(sorted_values):
        return []
    border = np.flatnonzero(np.diff(sorted_values)) + 1
    return [slice(a, b) for a, b in zip([0, *border], [*border, len(sorted_values)], strict=True)]


def _runs(places: Places, i: Ints, floor: Floats, tolerance: float, step: float) -> tuple[Ints, Ints, Ints]:
    """The run of each place [M], and each run's first and last place [R]."""
    start = np.arange(len(i))
    back = places.neighbour[0]
    low, high = np.full(len(i), -np.inf), np.full(len(i), np.inf)
    goes_on = np.zeros(len(i), dtype=np.bool_)
    for now in _slices(i):
        left = back[now]
        begin = start[left]
        steps = np.maximum(i[now] - i[begin], 1)
        rise = floor[now] - floor[begin]
        fits = (left >= 0) & (np.abs(floor[now] - floor[left]) <= step)
        fits &= (rise >= low[left] * steps) & (rise <= high[left] * steps)
        start[now] = np.where(fits, begin, start[now])
        low[now] = np.where(fits, np.maximum(low[left], (rise - tolerance) / steps), -np.inf)
        high[now] = np.where(fits, np.minimum(high[left], (rise + tolerance) / steps), np.inf)
        goes_on[left[fits]] = True
    first = np.unique(start)
    run = np.searchsorted(first, start)
    last = np.empty(len(first), dtype=np.int64)
    ends = np.flatnonzero(~goes_on)
    last[run[ends]] = ends
    return run, first, last


def _run_below(places: Places, run: Ints, count: int) -> Ints:
    """The run one row below that each run [R] has its middle over, if that holds the other way round; else -1."""
    order = np.argsort(run, kind="stable")
    begin = np.searchsorted(run[order], np.arange(count))
    size = np.diff(np.append(begin, len(run)))
    middle = order[begin + size // 2]
    down, up = (
        np.where((there := places.neighbour[direction][middle]) >= 0, run[there], -1) for direction in (3, 1)
    )
    return np.where((down >= 0) & (up[down] == np.arange(count)), down, -1)


def _stacks(
    ends: Floats, row: Ints, below: Ints, tolerance: Floats, step: Floats, step_m: float
) -> tuple[Ints, Ints]:
    """Stacks of runs that one trapezoid follows: the lowest and the highest run of each."""
    start = np.arange(len(row))
    low, high = np.full(ends.shape, -np.inf), np.full(ends.shape, np.inf)
    goes_on = np.zeros(len(row), dtype=np.bool_)
    order = np.argsort(row, kind="stable")
    for piece in _slices(row[order]):
        now = order[piece]
        under = below[now]
        begin = start[under]
        steps = np.maximum(row[now] - row[begin], 1)[:, None]
        change = ends[now] - ends[begin]
        moved = np.abs(ends[now] - ends[under])
        fits = (under >= 0) & (moved[:, :2] <= step[now]).all(axis=1)
        fits &= (moved[:, 2:] <= step_m * (1 + moved[:, :2])).all(axis=1)
        fits &= ((change >= low[under] * steps) & (change <= high[under] * steps)).all(axis=1)
        start[now] = np.where(fits, begin, now)
        chosen = fits[:, None]
        low[now] = np.where(chosen, np.maximum(low[under], (change - tolerance[now]) / steps), -np.inf)
        high[now] = np.where(chosen, np.minimum(high[under], (change + tolerance[now]) / steps), np.inf)
        goes_on[under[fits]] = True
    top = np.flatnonzero(~goes_on)
    return start[top], top


def _trapezoids(ends: Floats, row: Ints, bottom: Ints, top: Ints) -> Floats:
    """Corners [Q, 4, 3]: the ends are known in the middle of the first and last row, and go on half a row."""
    count = row[top] - row[bottom]
    rate = (ends[top] - ends[bottom]) / np.maximum(count, 1)[:, None]
    sides = []
    for run, factor, y in ((bottom, -0.5, row[bottom]), (top, 0.5, row[top] + 1)):
        left, right, z_left, z_right = (ends[run] + factor * rate).T
        middle = (left + right) / 2
        left, right = np.minimum(left, middle), np.maximum(right, middle)
        sides.append((np.stack([left, y, z_left], axis=1), np.stack([right, y, z_right], axis=1)))
    (low_left, low_right), (high_left, high_right) = sides
    return np.stack([low_left, low_right, high_right, high_left], axis=1)


def _split(corners: Floats, label: Ints, tolerance: float) -> Patches:
    """Cut twisted trapezoids into strips that two triangles follow within the tolerance."""
    z = corners[:, :, 2]
    twist = np.abs(z[:, 0] - z[:, 1] + z[:, 2] - z[:, 3]) / 4
    count = np.clip(np.ceil(twist / tolerance), 1, np.ceil(corners[:, 2, 1] - corners[:, 1, 1])).astype(
        np.int64
    )
    patch, strip = expand(count)
    share = np.stack([strip, strip + 1], axis=1) / count[patch][:, None]
    low, high = corners[patch][:, [0, 1]], corners[patch][:, [3, 2]]
    first, second = (low + share[:, k, None, None] * (high - low) for k in (0, 1))
    return Patches(np.stack([first[:, 0], first[:, 1], second[:, 1], second[:, 0]], axis=1), label[patch])


def some(found: Patches, keep: Bools) -> Patches:
    """Only the patches to keep [Q]."""
    return Patches(found.corners[keep], found.label[keep])
