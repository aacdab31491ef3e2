"""What became unreachable or reachable from one run to another, as areas: clusters of goals and standing places.

Shape legend: G goals, N standing places, n members of areas.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from reachtest.records import Floats, Ints
from reachtest.results import CoverageBefore

Cell = tuple[int, int, int]
_AROUND = tuple((i, j, k) for i in (-1, 0, 1) for j in (-1, 0, 1) for k in (-1, 0, 1))


@dataclass(frozen=True)
class Area:
    """A connected area that only one of two runs reached."""

    position: Floats  # [3] the member nearest to the middle
    low: Floats  # [3]
    high: Floats  # [3]
    goals: int
    cells: int  # of `cell_m`, where somebody stood
    on_navmesh: bool


def lost(before: CoverageBefore, after: CoverageBefore, spacing_m: float) -> list[Area]:
    """The areas that `before` reached and `after` did not, largest first.

    A standing place counts when nobody stood in its cell or any neighbouring one (4 m and more away), a goal when the
    same goal was not reached any more; where the nav-mesh has changed, its nearest goal within `spacing_m`.
    """
    goals = _lost_goals(before, after, spacing_m)
    stood = np.array(before.stood, dtype=np.float64).reshape(-1, 4)
    there = set(_cells(np.array(after.stood, dtype=np.float64).reshape(-1, 4), after.cell_m))
    gone = np.array([not _beside(cell, there) for cell in _cells(stood, before.cell_m)], dtype=np.bool_)
    places = stood[gone]
    points = np.concatenate([goals, places[:, :3]])
    # 0: a goal, 1: an expected place, 2: an unexpected one
    sort = np.concatenate([np.zeros(len(goals)), np.where(places[:, 3] > 0, 1, 2)])
    areas = [_area(points[group], sort[group]) for group in _groups(_cells(points, before.cell_m))]
    return sorted(areas, key=lambda area: (-area.goals - area.cells, *area.position.tolist()))


def _lost_goals(before: CoverageBefore, after: CoverageBefore, spacing_m: float) -> Floats:
    old = np.array(before.goals, dtype=np.float64).reshape(-1, 4)
    new = np.array(after.goals, dtype=np.float64).reshape(-1, 4)
    reached = old[old[:, 3] >= 0][:, :3]
    if not len(new) or not len(reached):
        return np.empty((0, 3))
    away, which = cKDTree(new[:, :3]).query(reached)
    missed = (away <= spacing_m) & (new[which, 3] < 0)
    # Of another goal nearby, not being reached says nothing where somebody stood beside the old one.
    there = set(_cells(np.array(after.stood, dtype=np.float64).reshape(-1, 4), after.cell_m))
    stood = np.array([cell in there for cell in _cells(reached, after.cell_m)], dtype=np.bool_)
    return reached[missed & ((away < 1e-2) | ~stood)]


def _cells(points: Floats, cell_m: float) -> list[Cell]:
    return [(x, y, z) for x, y, z in np.floor(points[:, :3] / cell_m).astype(np.int64).tolist()]


def _beside(cell: Cell, cells: set[Cell]) -> bool:
    x, y, z = cell
    return any((x + i, y + j, z + k) in cells for i, j, k in _AROUND)


def _groups(cells: list[Cell]) -> Iterable[Ints]:
    """Indices of members whose cells touch, group by group."""
    members: dict[Cell, list[int]] = {}
    for index, cell in enumerate(cells):
        members.setdefault(cell, []).append(index)
    while members:
        waiting, group = [next(iter(members))], []
        while waiting:
            x, y, z = waiting.pop()
            if (x, y, z) in members:
                group += members.pop((x, y, z))
                waiting += [near for i, j, k in _AROUND if (near := (x + i, y + j, z + k)) in members]
        yield np.array(sorted(group))


def _area(points: Floats, sort: Floats) -> Area:
    middle = points.mean(axis=0)
    nearest = int(np.linalg.norm(points - middle, axis=1).argmin())
    return Area(
        points[nearest],
        points.min(axis=0),
        points.max(axis=0),
        goals=int((sort == 0).sum()),
        cells=int((sort > 0).sum()),
        on_navmesh=bool((sort < 2).any()),
    )
