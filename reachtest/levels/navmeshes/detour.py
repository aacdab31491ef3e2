"""Nav-meshes of Recast and Detour: tile sets of Recast's demo, of Habitat and of Unreal Engine 4, bare tiles.

Which of them a file is, its content says. `navmesh_layout` has the bytes, `navmesh_tiles` the way from one
tile to the next, `navmesh_surface` what a tile holds.

Shape legend: V vertices, F triangles, P polygons.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from reachtest.levels.fields import FARTHEST
from reachtest.levels.meshes.scene import NavFile, Piece, Unreadable
from reachtest.levels.navmeshes.detour_layout import TILE_MAGIC, Layout, field_offset
from reachtest.levels.navmeshes.detour_surface import OffMesh, Surface, tile_surface
from reachtest.levels.navmeshes.detour_tiles import (
    DAMAGED,
    OTHER_FILES,
    SET_HEADER_BYTES,
    SET_MAGIC,
    SETTINGS_BYTES,
    SLOPE_AT,
    Tile,
    find_tiles,
)
from reachtest.records import Floats, Ints, NavAgent, NavLink


@dataclass(frozen=True)
class DetourMesh:
    """Everything that was read of a file, in its units, y up, right-handed."""

    layout: str
    tiles: int
    surface: Surface
    agent_height: float  # what the mesh was built for
    agent_radius: float
    agent_climb: float
    agent_slope: float | None  # [deg] only Habitat's settings have it


def is_detour(data: bytes) -> bool:
    """Whether a file is a tile set, a bare tile, or something that is told apart from them by name."""
    return data[:4] in (SET_MAGIC, TILE_MAGIC, *OTHER_FILES)


def read_detour(data: bytes, path: Path) -> NavFile:
    """The walkable surface of a Detour nav-mesh, as one piece, and its off-mesh links. Raises Unreadable."""
    mesh = detour_mesh(data)
    surface, off_mesh = mesh.surface, mesh.surface.off_mesh
    piece = Piece(path.stem, surface.vertices, surface.faces, surface.area[surface.polygon])
    # A builder that was told nothing writes 0: no agent is that small.
    numbers = (mesh.agent_radius, mesh.agent_height, mesh.agent_climb, mesh.agent_slope)
    links = tuple(
        NavLink("off-mesh", start, end, float(radius), bool(both))
        for (start, end), radius, both in zip(off_mesh.ends, off_mesh.radius, off_mesh.both_ways, strict=True)
    )
    agent = NavAgent(*(number or None for number in numbers))
    return NavFile([piece], mesh.layout, len(surface.area), agent, links)


def detour_mesh(data: bytes) -> DetourMesh:
    """The tiles of a Detour nav-mesh file, put together. Raises Unreadable, with the byte.

    A mesh of Unreal Engine is turned by half about the vertical: Recast has (-X, Z, -Y) of Unreal's (X, Y, Z),
    Unreal's own exporters of geometry write (X, Z, Y) to y-up files, and the two must lie on each other.
    """
    layout, tiles = find_tiles(data)
    agent = _agent(tiles)
    surface = _joined([tile_surface(data, tile) for tile in tiles])
    if not len(surface.faces):
        found = f"holds no triangles in {len(tiles)} tiles, the first at byte {tiles[0].at if tiles else 40}"
        raise Unreadable(found, "build the nav-mesh before it is exported")
    name, slope = _habitat(data, layout, tiles)
    return DetourMesh(name, len(tiles), _turned(surface) if layout.unreal else surface, *agent, slope)


def _habitat(data: bytes, layout: Layout, tiles: list[Tile]) -> tuple[str, float | None]:
    """The name of the layout, and the steepest slope [deg], where Habitat's settings precede the tiles."""
    if tiles[0].at != SET_HEADER_BYTES + SETTINGS_BYTES + layout.entry.itemsize:
        return layout.name, None
    at = SET_HEADER_BYTES + SLOPE_AT
    slope = float(np.frombuffer(data, "<f4", 1, at)[0])
    if not 0 <= slope <= 90:
        raise Unreadable(f"states a slope of {slope:g} degrees at byte {at}", DAMAGED)
    return f"Habitat 2 ({layout.name})", slope


def _agent(tiles: list[Tile]) -> tuple[float, float, float]:
    """Height, radius and climb of the agent, as the first tile has them: Detour builds all tiles for one."""
    found = [(0.0, 0.0, 0.0)]
    for tile in reversed(tiles):
        height, radius, climb = (float(tile.header[name]) for name in ("height", "radius", "climb"))
        if not all(0 <= number <= FARTHEST for number in (height, radius, climb)):
            at = tile.at + field_offset(tile.header, "height")
            numbers = f"{height:g}, {radius:g}, {climb:g}"
            raise Unreadable(f"states height, radius, climb of {numbers} at byte {at}", DAMAGED)
        found.append((height, radius, climb))
    return found[-1]


def _joined(parts: list[Surface]) -> Surface:
    """One surface of all tiles, its indices moved on accordingly."""
    vertex_start = np.cumsum([0, *(len(part.vertices) for part in parts)])
    polygon_start = np.cumsum([0, *(len(part.area) for part in parts)])
    return Surface(
        np.concatenate([np.zeros((0, 3)), *(part.vertices for part in parts)]),
        _shifted([part.faces for part in parts], vertex_start, (0, 3)),
        _shifted([part.polygon for part in parts], polygon_start, (0,)),
        np.concatenate([np.zeros(0, np.int64), *(part.area for part in parts)]),
        np.concatenate([np.zeros(0, np.int64), *(part.flags for part in parts)]),
        _joined_links([part.off_mesh for part in parts]),
    )


def _shifted(indices: list[Ints], starts: Ints, empty: tuple[int, ...]) -> Ints:
    moved = [index + start for index, start in zip(indices, starts, strict=False)]
    return np.concatenate([np.zeros(empty, np.int64), *moved])


def _joined_links(parts: list[OffMesh]) -> OffMesh:
    return OffMesh(
        np.concatenate([np.zeros((0, 2, 3)), *(part.ends for part in parts)]),
        np.concatenate([np.zeros(0), *(part.radius for part in parts)]),
        np.concatenate([np.zeros(0, np.bool_), *(part.both_ways for part in parts)]),
        np.concatenate([np.zeros(0, np.int64), *(part.area for part in parts)]),
        np.concatenate([np.zeros(0, np.int64), *(part.flags for part in parts)]),
        np.concatenate([np.zeros(0, np.int64), *(part.user_id for part in parts)]),
    )


def _turned(surface: Surface) -> Surface:
    off_mesh = replace(surface.off_mesh, ends=_half_turn(surface.off_mesh.ends))
    return replace(surface, vertices=_half_turn(surface.vertices), off_mesh=off_mesh)


def _half_turn(points: Floats) -> Floats:
    return points * [-1.0, 1.0, -1.0]
