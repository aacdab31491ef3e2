"""From one Detour tile to triangles, with what Detour knows about every polygon.

Shape legend: V vertices, F triangles, P polygons, C off-mesh connections.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from reachtest.levels.fields import FARTHEST
from reachtest.levels.navmeshes.detour_tiles import DAMAGED, Tile
from reachtest.levels.navmeshes.sections import Array
from reachtest.records import Bools, Floats, Ints

_GROUND = 0  # kind of polygon; the others stand for off-mesh connections and have no surface


@dataclass(frozen=True)
class OffMesh:
    """Links that are no surface: jumps, ladders, doors, teleporters."""

    ends: Floats  # [C, 2, 3] from, to
    radius: Floats  # [C]
    both_ways: Bools  # [C]
    area: Ints  # [C] 0 to 63
    flags: Ints  # [C] of the polygon that stands for the connection
    user_id: Ints  # [C]


@dataclass(frozen=True)
class Surface:
    """One tile or more, in the file's own units, y up."""

    vertices: Floats  # [V, 3]
    faces: Ints  # [F, 3] as the file winds them: Recast does so counter-clockwise from above
    polygon: Ints  # [F] the polygon of each triangle
    area: Ints  # [P] 0 to 63
    flags: Ints  # [P] 16 bits; what they mean is the game's to say
    off_mesh: OffMesh


def tile_surface(data: bytes, tile: Tile) -> Surface:
    """The ground polygons of a tile: their detail meshes, or fans where they have none.

    Raises Unreadable, with the byte, for numbers that are none or point out of their section.
    """
    polys, details, tris = (_read(data, tile, name) for name in ("polys", "detail_meshes", "detail_tris"))
    points = [_points(data, tile, name) for name in ("verts", "detail_verts")]
    _check_polys(polys, tile, len(points[0]))
    ground = np.flatnonzero(polys["area_and_kind"] >> 6 == _GROUND)
    detailed = ground[ground < len(details)]
    detailed = detailed[details["tri_count"][detailed] > 0]
    _check_details(details, detailed, tile, len(points[1]), len(tris))
    faces, owner = _detail_faces(polys, details, tris, detailed, tile)
    fan_faces, fan_owner = _fans(polys, np.setdiff1d(ground, detailed, assume_unique=True))
    owner = np.concatenate([owner, fan_owner])
    order = np.argsort(owner, kind="stable")
    used, faces = np.unique(np.concatenate([faces, fan_faces])[order], return_inverse=True)
    vertices = np.concatenate(points)[used].astype(np.float64)
    return Surface(
        vertices,
        faces.reshape(-1, 3),
        np.searchsorted(ground, owner[order]),
        (polys["area_and_kind"][ground] & 63).astype(np.int64),
        polys["flags"][ground].astype(np.int64),
        _off_mesh(_read(data, tile, "off_mesh"), polys, tile),
    )


def _read(data: bytes, tile: Tile, name: str) -> Array:
    return tile.sections[name].read(data)


def _refuse(wrong: Array, tile: Tile, section: str, found: str, rows: Array | None = None) -> None:
    tile.sections[section].refuse(wrong, section, found, DAMAGED, rows)


def _places(values: Array) -> Bools:
    """Which rows are finite numbers that can be places; False for NaN."""
    return np.asarray((np.abs(values) <= FARTHEST).all(axis=tuple(range(1, values.ndim))))


def _points(data: bytes, tile: Tile, name: str) -> Array:
    points = _read(data, tile, name)
    _refuse(~_places(points), tile, name, "that is NaN, infinite or too far away")
    return points


def _check_polys(polys: Array, tile: Tile, verts: int) -> None:
    kind: Array = polys["area_and_kind"] >> 6
    sides: Array = polys["sides"]
    _refuse(np.equal(kind, 3), tile, "polys", "of an unknown kind (3)")
    least = np.where(kind == _GROUND, 3, 2)
    _refuse(np.not_equal(sides, sides.clip(least, 6)), tile, "polys", "with a number of corners out of range")
    outside: Array = (polys["corners"] >= verts) & (np.arange(6) < sides[:, None])
    _refuse(np.any(outside, axis=1), tile, "polys", f"with a corner outside of the {verts} vertices")


def _check_details(details: Array, used: Ints, tile: Tile, verts: int, tris: int) -> None:
    mine = details[used]
    for start, count, most, what in (
        ("vert_base", "vert_count", verts, "vertices"),
        ("tri_base", "tri_count", tris, "triangles"),
    ):
        beyond = mine[start].astype(np.int64) + mine[count] > most
        _refuse(beyond, tile, "detail_meshes", f"beyond the {most} detail {what}", used)
    # Triangles shared by many polygons would make a small file a huge mesh.
    total = np.cumsum(mine["tri_count"], dtype=np.int64)
    _refuse(total > tris, tile, "detail_meshes", f"with more than the {tris} detail triangles in all", used)


def _detail_faces(polys: Array, details: Array, tris: Array, used: Ints, tile: Tile) -> tuple[Ints, Ints]:
    """Triangles [F, 3] of the polygons `used`, into vertices and then detail vertices; their polygons [F]."""
    counts = details["tri_count"][used].astype(np.int64)
    owner = np.repeat(used, counts)
    within = np.arange(len(owner)) - np.repeat(np.cumsum(counts) - counts, counts)
    rows = details["tri_base"][owner].astype(np.int64) + within
    corners = tris["corners"][rows].astype(np.int64)
    sides = polys["sides"][owner].astype(np.int64)[:, None]
    extra = details["vert_count"][owner].astype(np.int64)[:, None]
    outside = (corners >= sides + extra).any(axis=1)
    _refuse(outside, tile, "detail_tris", "with a corner that its polygon does not have", rows)
    own = np.take_along_axis(polys["corners"][owner].astype(np.int64), corners.clip(max=5), axis=1)
    base = tile.sections["verts"].count + details["vert_base"][owner].astype(np.int64)[:, None]
    return np.where(corners < sides, own, base + corners - sides), owner


def _fans(polys: Array, used: Ints) -> tuple[Ints, Ints]:
    """Triangles [F, 3] of the convex polygons `used`, and their polygons [F]."""
    corners = polys["corners"][used].astype(np.int64)
    fans = np.stack(
        [np.broadcast_to(corners[:, :1], (len(used), 4)), corners[:, 1:5], corners[:, 2:6]], axis=2
    )
    there = np.arange(2, 6) < polys["sides"][used][:, None]
    return fans[there], np.broadcast_to(used[:, None], there.shape)[there]


def _off_mesh(links: Array, polys: Array, tile: Tile) -> OffMesh:
    _refuse(~_places(links["ends"]), tile, "off_mesh", "with an end that is NaN, infinite or too far away")
    _refuse(~(np.abs(links["radius"]) <= FARTHEST), tile, "off_mesh", "with a radius that is no length")
    _refuse(links["poly"] >= len(polys), tile, "off_mesh", f"with a polygon outside of the {len(polys)}")
    mine = polys[links["poly"]]
    return OffMesh(
        links["ends"].astype(np.float64),
        links["radius"].astype(np.float64),
        links["flags"] & 1 == 1,
        (mine["area_and_kind"] & 63).astype(np.int64),
        mine["flags"].astype(np.int64),
        links["user_id"].astype(np.int64),
    )
