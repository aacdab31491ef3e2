"""Floors that no nav-mesh shows: tops of crates, ledges, stepping stones, roofs. Whoever leaves the nav-mesh by a jump
lands on one, and few of them are met by chance. Who stands on one may leap on from it.

Shape legend: I islands of floors, f faces of floors.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from reachtest.columns import ColumnIndex
from reachtest.geometry import triangle_normals
from reachtest.navmesh.build import BUILT_BOTH, build_navmesh, turned_over
from reachtest.navmesh.faces import FaceIndex
from reachtest.navmesh.islands import Islands, islands
from reachtest.navmesh.settings import settings_for
from reachtest.records import Bools, Floats, Level, NavMesh
from reachtest.surface import SurfaceIndex

BESIDE_M = (
    0.7  # a floor that comes nearer to the nav-mesh is its own, less what erosion took, or is walked onto
)
ABOVE_M = 0.3  # cells lie a little over or under their floor
LEAST_M2 = 0.1  # smaller ones are no wider than a foot
MOST_CELLS, MOST_TRIANGLES = 1 << 21, 1 << 17  # a quarter of a kilometre: what is more takes longer than 10 s


def floors_off(level: Level, own: Islands) -> Islands:
    """The floors off the nav-mesh, whose islands are `own`; none where there is no nav-mesh or the level is large.

    What lies under nothing but faces that face up counts as inside of a solid, and is none.
    """
    none = Islands(NavMesh("", np.empty((0, 3)), np.empty((0, 3), dtype=np.int64)))
    triangles, who = level.collision, level.character
    if not own.count or not 0 < len(triangles) <= MOST_TRIANGLES:
        return none
    cell_m, extent = who.radius_m / 2, np.ptp(triangles.reshape(-1, 3), axis=0)
    if extent[0] * extent[1] > MOST_CELLS * cell_m**2:
        return none
    both = own.navmesh.format == BUILT_BOTH or turned_over(triangles, who.slope_limit_deg)
    given = {"radius_m": 0.0, "cell_m": cell_m, "min_island_m2": LEAST_M2}
    floors = build_navmesh(triangles, settings_for(who, both_sides=both, **given))
    floors = replace(floors, faces=floors.faces[_off(floors, own.navmesh)])
    if not both:
        floors = replace(floors, faces=floors.faces[~_inside(floors.triangles, triangles)])
    return Islands(floors)


def _off(floors: NavMesh, navmesh: NavMesh) -> Bools:
    """Which faces [f] belong to floors that come nowhere near the nav-mesh."""
    if not len(floors.faces):
        return np.zeros(0, dtype=np.bool_)
    label, beside = islands(floors), np.zeros(len(floors.faces), dtype=np.bool_)
    near = SurfaceIndex(navmesh.triangles, BESIDE_M).within(_places(floors.triangles))
    beside |= near.reshape(-1, 4).any(axis=1)
    # A face may be larger than the nav-mesh on it.
    under, _ = FaceIndex(floors.triangles, BESIDE_M).below(_places(navmesh.triangles), BESIDE_M, BESIDE_M)
    beside[under[under >= 0]] = True
    return np.asarray(~np.isin(label, label[beside]), dtype=np.bool_)


def _places(triangles: Floats) -> Floats:
    """The corners and the middle of each of `triangles` [f, 3, 3], one after the other [4 f, 3]."""
    return np.concatenate([triangles, triangles.mean(axis=1, keepdims=True)], axis=1).reshape(-1, 3)


def _inside(triangles: Floats, collision: Floats) -> Bools:
    """Which of `triangles` [f, 3, 3] are inside of a solid [f]: the first surface above them faces up."""
    upwards = triangle_normals(collision)[0][:, 2] > 0
    mirror = [1.0, 1.0, -1.0]  # the lowest above is the highest below
    middles = (triangles.mean(axis=1) + [0.0, 0.0, ABOVE_M]) * mirror
    top, bottom = (
        ColumnIndex(collision[some] * mirror).highest(middles, np.inf, 0.0)[0] for some in (upwards, ~upwards)
    )
    return np.asarray(np.nan_to_num(-top, nan=np.inf) < np.nan_to_num(-bottom, nan=np.inf), dtype=np.bool_)
