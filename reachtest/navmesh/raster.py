"""The nav-mesh's surface as points on a horizontal grid, and which of them are next to each other.

Shape legend: F faces, N samples, M pairs.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from reachtest.geometry import expand, triangle_normals
from reachtest.navmesh.faces import height_above
from reachtest.records import Floats, Ints, NavMesh

SPACING_M = 0.25  # half of what one sample every 0.5 m asks for: passages are narrow after erosion
MOST_SAMPLES = 100_000  # a surface larger than 6,250 m2 is sampled more coarsely
_RAMP_M = 1.0  # of rise from one sample to the next at the most: more may be another storey
_ACROSS = ((0, 1), (1, 0), (1, 1), (1, -1))  # to half of the eight cells around


@dataclass(frozen=True)
class Samples:
    """A nav-mesh's surface, point by point."""

    spacing_m: float
    positions: Floats  # [N, 3]
    face: Ints  # [N]
    cell: Ints  # [N, 2] on the grid

    def pairs(self, climb_m: float) -> Ints:
        """Neighbours [M, 2]: in cells next to each other, no farther apart in height than one climbs."""
        return _pairs(self.cell, self.positions[:, 2], climb_m + self.ramp_m)

    @property
    def ramp_m(self) -> float:
        """How far the surface itself rises from one sample to the next."""
        return min(self.spacing_m, _RAMP_M)


def rasterise(navmesh: NavMesh, most: int = MOST_SAMPLES) -> Samples:
    """Samples `SPACING_M` apart, or as far as it takes to have about `most` of them."""
    triangles = navmesh.triangles
    area = float(np.abs(triangle_normals(triangles)[1]).sum())
    spacing = max(SPACING_M, float(np.sqrt(area / most)))
    grid = (triangles[:, :, :2] - navmesh.vertices[:, :2].min(axis=0)) / spacing
    first = np.ceil(grid.min(axis=1)).astype(np.int64)
    span = np.maximum(np.floor(grid.max(axis=1)).astype(np.int64) - first + 1, 0)
    face, place = expand(span.prod(axis=1))
    cell = first[face] + np.stack([place // span[face, 1], place % span[face, 1]], axis=1)
    points = np.zeros((len(cell), 3))
    points[:, :2] = navmesh.vertices[:, :2].min(axis=0) + cell * spacing
    inside, above = height_above(points, triangles[face])
    points[:, 2] = -above
    return Samples(spacing, points[inside], face[inside], cell[inside])


def _pairs(cell: Ints, z: Floats, rise_m: float) -> Ints:
    """Pairs [M, 2] of samples in the same or neighbouring cells, nearer in height than `rise_m`."""
    if not len(cell):
        return np.empty((0, 2), dtype=np.int64)
    width = int(cell[:, 1].max()) + 3
    key = (cell[:, 0] + 1) * width + cell[:, 1] + 1
    order = np.argsort(key, kind="stable")
    ordered = key[order]
    found = []
    for across, along in ((0, 0), *_ACROSS):
        wanted = key + across * width + along
        begin = np.searchsorted(ordered, wanted)
        row, place = expand(np.searchsorted(ordered, wanted, side="right") - begin)
        other = order[begin[row] + place]
        keep = (np.abs(z[row] - z[other]) <= rise_m) & ((row < other) | ((across, along) != (0, 0)))
        found.append(np.stack([row[keep], other[keep]], axis=1))
    return np.concatenate(found)
