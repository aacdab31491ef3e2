"""Floors that no nav-mesh shows: tops of crates, ledges, stepping stones, roofs. Whoever leaves the nav-mesh by a jump
lands on one, and few of them are met by chance. Who stands on one may leap on from it.

Shape legend: I islands of floors, f faces of floors.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import trimesh

from reachtest.columns import ColumnIndex
from reachtest.geometry import triangle_normals
from reachtest.navmesh.build import BUILT_BOTH, build_navmesh, turned_over
from reachtest.navmesh.islands import Islands
from reachtest.navmesh.settings import settings_for
from reachtest.records import Bools, Character, Floats, Level, NavMesh
from reachtest.surface import SurfaceIndex

BESIDE = 1.5 * float(np.sqrt(2.0))  # radii: erosion takes one and up to half of one more, into a corner
PIECE_M = 2.0  # longest side of a face
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
    try:
        built = build_navmesh(triangles, settings_for(who, both_sides=both, **given))
    except ValueError:  # too high for its layers
        return none
    floors = _in_pieces(built)
    floors = replace(floors, faces=floors.faces[_off(floors, own.navmesh, who)])
    if not both:
        floors = replace(floors, faces=floors.faces[~_inside(floors.triangles, triangles)])
    return Islands(floors)


def _in_pieces(floors: NavMesh) -> NavMesh:
    """The same in faces that are no longer than a piece: those of a yard are larger than the nav-mesh in it."""
    if not len(floors.faces):
        return floors
    vertices, faces = trimesh.remesh.subdivide_to_size(floors.vertices, floors.faces, PIECE_M, max_iter=32)
    return replace(floors, vertices=vertices, faces=faces.astype(np.int64))


def _off(floors: NavMesh, navmesh: NavMesh, who: Character) -> Bools:
    """Which faces [f] are off the nav-mesh with a corner: the others of theirs are where a leap arrives first."""
    beside_m = BESIDE * max(who.radius_m, navmesh.agent.radius_m or 0.0)
    near = SurfaceIndex(navmesh.triangles, beside_m).within(floors.vertices)
    return np.asarray(~near[floors.faces].all(axis=1), dtype=np.bool_)


def _inside(triangles: Floats, collision: Floats) -> Bools:
    """Which of `triangles` [f, 3, 3] are inside of a solid [f]: the first surface above them faces up."""
    upwards = triangle_normals(collision)[0][:, 2] > 0
    mirror = [1.0, 1.0, -1.0]  # the lowest above is the highest below
    middles = (triangles.mean(axis=1) + [0.0, 0.0, ABOVE_M]) * mirror
    top, bottom = (
        ColumnIndex(collision[some] * mirror).highest(middles, np.inf, 0.0)[0] for some in (upwards, ~upwards)
    )
    return np.asarray(np.nan_to_num(-top, nan=np.inf) < np.nan_to_num(-bottom, nan=np.inf), dtype=np.bool_)
