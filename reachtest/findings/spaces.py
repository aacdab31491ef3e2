"""One way into a space is one bug, though within the 3 m in which a character is expected paths spread.

Behind a gap in a wall they still count as expected for a few metres, and leave the expected far apart. So two areas
that touch are one bug where the ways to both left the nav-mesh itself at one place; those ways are simulated again.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial import cKDTree

from reachtest.findings.evidence import Evidence
from reachtest.records import Floats, Ints
from reachtest.surface import SurfaceIndex

_TOUCH_M = 4.0  # cached standing places of one area are hardly farther apart
_ON_MESH_M = 1.0  # erosion and float of a nav-mesh, and little else


def join_spaces(evidence: Evidence, areas: Sequence[Ints], link_m: float) -> list[int]:
    """For areas of standing points, indices [k] of cached points, the smallest index of an area of the same bug.

    Empty areas stay by themselves.
    """
    positions = evidence.exploration.points.positions
    trees = [cKDTree(positions[area].reshape(-1, 3)) for area in areas]
    label, exits = list(range(len(areas))), _Exits(evidence)
    for one in range(len(areas)):
        for other in range(one + 1, len(areas)):
            first, second = label[one], label[other]
            if first == second or not len(areas[one]) or not len(areas[other]):
                continue
            if not trees[one].count_neighbors(trees[other], _TOUCH_M):
                continue
            # NaN, where a way never was on the nav-mesh, is near to nothing.
            if np.linalg.norm(exits.of(areas[one]) - exits.of(areas[other])) <= link_m:
                label = [min(first, second) if mine in (first, second) else mine for mine in label]
    return label


class _Exits:
    """Where the shortest ways to areas left the nav-mesh itself; each is simulated once."""

    def __init__(self, evidence: Evidence) -> None:
        self._evidence = evidence
        self._known: dict[int, Floats] = {}
        self._surface: SurfaceIndex | None = None

    def of(self, area: Ints) -> Floats:
        """The place [3] for an area, indices [k] of cached points; NaN if the way never was on the nav-mesh."""
        index = int(area[self._evidence.steps_from_spawn[area].argmin()])
        if index not in self._known:
            if self._surface is None:
                self._surface = SurfaceIndex(self._evidence.level.navmesh.triangles, _ON_MESH_M)
            way = self._evidence.replayer.path_to_point(index).positions
            on_mesh = np.flatnonzero(self._surface.within(way))
            self._known[index] = way[on_mesh[-1]] if len(on_mesh) else np.full(3, np.nan)
        return self._known[index]
