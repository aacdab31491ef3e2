"""How Detour writes a tile: the headers and sections of Recast's own files and of Unreal Engine 4's.

All of it is little-endian. A file does not say which of the layouts it has: the sizes of the sections of a
tile add up to the tile's size in one of them only.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from reachtest.levels.navmeshes.sections import Section

TILE_MAGIC, TILE_VERSION = b"VAND", 7  # DT_NAVMESH_MAGIC as it lies on disk, DT_NAVMESH_VERSION

_COUNTS = ("polys", "verts", "links", "detail_meshes", "detail_verts", "detail_tris", "bv_nodes", "off_mesh")
_START = [(name, "<i4") for name in ("magic", "version", "x", "y", "layer", "user_id", *_COUNTS)]
SIZES = (*_COUNTS, "segments", "clusters")
"""Numbers of a header that are the lengths of sections."""

_AGENT = [("height", "<f4"), ("radius", "<f4"), ("climb", "<f4")]
_BOX = [("low", "<f4", (3,)), ("high", "<f4", (3,)), ("cells_per_unit", "<f4")]

_RECAST_HEADER = np.dtype([*_START, ("off_mesh_base", "<i4"), *_AGENT, *_BOX])
_UNREAL_HEADER = np.dtype(
    [
        *_START,
        ("segments", "<i4"),
        ("off_mesh_base", "<i4"),
        ("segment_poly_base", "<i4"),
        ("segment_vert_base", "<i4"),
        *_AGENT,
        *_BOX,
        ("clusters", "<i4"),
    ]
)

POINT = np.dtype(("<f4", (3,)))
POLY = np.dtype(
    [
        ("first_link", "<u4"),
        ("corners", "<u2", (6,)),
        ("neighbours", "<u2", (6,)),
        ("flags", "<u2"),
        ("sides", "u1"),
        ("area_and_kind", "u1"),  # area in the low 6 bits, kind in the high 2
    ]
)
DETAIL_MESH = np.dtype(
    [
        ("vert_base", "<u4"),
        ("tri_base", "<u4"),
        ("vert_count", "u1"),
        ("tri_count", "u1"),
        ("padding", "u1", (2,)),
    ]
)
DETAIL_TRI = np.dtype([("corners", "u1", (3,)), ("edge_flags", "u1")])

_ENDS = [("ends", "<f4", (2, 3)), ("radius", "<f4")]
_REST = [("poly", "<u2"), ("flags", "u1"), ("side", "u1"), ("user_id", "<u4")]
_OFF_MESH = np.dtype([*_ENDS, *_REST])
_OFF_MESH_SNAP = np.dtype([*_ENDS, ("snap_height", "<f4"), *_REST])  # later releases of Unreal Engine 4


def field_offset(record: np.void, name: str) -> int:
    """Where a field starts within its record [bytes]."""
    fields = record.dtype.fields
    return int(fields[name][1]) if fields else 0


@dataclass(frozen=True)
class Layout:
    """One way to write a tile."""

    name: str
    unreal: bool
    entry: np.dtype[Any]  # what stands before every tile in a tile set
    header: np.dtype[Any]
    link_bytes: int
    off_mesh: np.dtype[Any]
    segment_bytes: int = 0  # an off-mesh connection between two edges

    def sections(self, header: Mapping[str, int], at: int) -> tuple[dict[str, Section], int]:
        """The sections of a tile that starts at byte `at`, by name, and the byte after the last one."""
        arrays = [
            ("verts", POINT, header["verts"]),
            ("polys", POLY, header["polys"]),
            ("links", np.dtype((np.void, self.link_bytes)), header["links"]),
            ("detail_meshes", DETAIL_MESH, header["detail_meshes"]),
            ("detail_verts", POINT, header["detail_verts"]),
            ("detail_tris", DETAIL_TRI, header["detail_tris"]),
            ("bv_nodes", np.dtype((np.void, 16)), header["bv_nodes"]),
            ("off_mesh", self.off_mesh, header["off_mesh"]),
        ]
        if self.unreal:
            arrays += [
                ("segments", np.dtype((np.void, self.segment_bytes)), header["segments"]),
                ("clusters", np.dtype((np.void, 20)), header["clusters"]),
                ("poly_clusters", np.dtype("<u2"), header["polys"]),
            ]
        found, at = {}, at + self.header.itemsize
        for name, dtype, count in arrays:
            found[name] = Section(at, dtype, count)
            at += -(-dtype.itemsize * count // 4) * 4  # every section starts at a multiple of 4 bytes
        return found, at


_ENTRY_32 = np.dtype([("ref", "<u4"), ("size", "<i4")])
_ENTRY_64 = np.dtype([("ref", "<u8"), ("size", "<i4"), ("padding", "<u4")])

LAYOUTS = (
    Layout("Recast, 32-bit references", False, _ENTRY_32, _RECAST_HEADER, 12, _OFF_MESH),
    Layout("Recast, 64-bit references", False, _ENTRY_64, _RECAST_HEADER, 16, _OFF_MESH),
    Layout("Unreal Engine 4", True, _ENTRY_64, _UNREAL_HEADER, 16, _OFF_MESH, 60),
    Layout("Unreal Engine 4, snap heights", True, _ENTRY_64, _UNREAL_HEADER, 16, _OFF_MESH_SNAP, 64),
)
"""One entry to read another variant."""
