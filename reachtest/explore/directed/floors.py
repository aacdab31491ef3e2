"""Floors that no nav-mesh shows: tops of crates, ledges, stepping stones, roofs. Whoever leaves the nav-mesh by a jump
lands on one, and few of them are met by chance.

They are islands beside the nav-mesh's own: who stands on one may leap on from it.

Shape legend: F faces, I islands, f faces of floors.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from reachtest.columns import ColumnIndex
from reachtest.geometry import triangle_normals
from reachtest.navmesh.build import BUILT_BOTH, build_navmesh, turned_over
from reachtest.navmesh.islands import Islands, islands
from reachtest.navmesh.settings import settings_for
from reachtest.records import Bools, Floats, Level, NavMesh
from reachtest.surface import SurfaceIndex

BESIDE_M = 0.7  # what is nearer to the nav-mesh was taken from it by erosion, or is walked over
ABOVE_M = 0.3  # cells lie a little over or under their floor
LEAST_M2 = 0.1  # smaller ones are no wider than a foot
MOST_CELLS, MOST_TRIANGLES = 1 << 21, 1 << 17  # a quarter of a kilometre: what is more takes longer than 10 s


def with_floors(level: Level, own: Islands) -> Islands:
    """The nav-mesh's `own` islands [I], and behind them the floors off it; only the former where a level is large."""
    who = level.character
    cell_m = who.radius_m / 2
    low, high = level.collision.min(axis=(0, 1)), level.collision.max(axis=(0, 1))
    cells = float(np.prod((high - low)[:2])) / cell_m**2
    if cells > MOST_CELLS or len(level.collision) > MOST_TRIANGLES:
        return own
    both = own.navmesh.format == BUILT_BOTH or turned_over(level.collision, who.slope_limit_deg)
    given = {"radius_m": 0.0, "cell_m": cell_m, "min_island_m2": 0.0}
    floors = build_navmesh(level.collision, settings_for(who, both_sides=both, **given))
    floors = replace(floors, faces=floors.faces[_off(floors.triangles, own.navmesh)])
    if not both:
        floors = replace(floors, faces=floors.faces[~_inside(floors.triangles, level.collision)])
    floors = replace(floors, faces=floors.faces[_large(floors)])
    labels = islands(floors) + own.count
    joined = replace(
        own.navmesh,
        vertices=np.concatenate([own.navmesh.vertices, floors.vertices]),
        faces=np.concatenate([own.navmesh.faces, floors.faces + len(own.navmesh.vertices)]),
        areas=None,
        links=(),
    )
    return Islands(joined, np.concatenate([own.labels, labels]))


def _off(triangles: Floats, navmesh: NavMesh) -> Bools:
    """Which of `triangles` [f, 3, 3] have a corner or their middle off the nav-mesh [f]."""
    near = SurfaceIndex(navmesh.triangles, BESIDE_M)
    places = np.concatenate([triangles, triangles.mean(axis=1, keepdims=True)], axis=1)
    return np.asarray(~near.within(places.reshape(-1, 3)).reshape(-1, 4).all(axis=1), dtype=np.bool_)


def _inside(triangles: Floats, collision: Floats) -> Bools:
    """Which of `triangles` [f, 3, 3] are inside of a solid [f]: the first surface above them faces up."""
    upwards = triangle_normals(collision)[0][:, 2] > 0
    mirror = [1.0, 1.0, -1.0]  # the lowest above is the highest below
    middles = (triangles.mean(axis=1) + [0.0, 0.0, ABOVE_M]) * mirror
    top, bottom = (
        ColumnIndex(collision[some] * mirror).highest(middles, np.inf, 0.0)[0] for some in (upwards, ~upwards)
    )
    return np.asarray(np.nan_to_num(-top, nan=np.inf) < np.nan_to_num(-bottom, nan=np.inf), dtype=np.bool_)


def _large(floors: NavMesh) -> Bools:
    """Which faces [f] belong to a floor one can stand on."""
    labels = islands(floors)
    area = np.bincount(labels, weights=triangle_normals(floors.triangles)[1])
    return np.asarray(area[labels] >= LEAST_M2, dtype=np.bool_)
