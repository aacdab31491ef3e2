"""Finds the tiles of a Detour nav-mesh file and their layout: nothing is read of a tile that does not add up."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import NoReturn

import numpy as np

from reachtest.levels.meshes.scene import Unreadable
from reachtest.levels.navmeshes.detour_layout import (
    LAYOUTS,
    SIZES,
    TILE_MAGIC,
    TILE_VERSION,
    Layout,
    field_offset,
)
from reachtest.levels.navmeshes.sections import Section

DAMAGED = "the file is damaged or cut off: export it again"

SET_MAGIC, SET_HEADER_BYTES, SETTINGS_BYTES = b"TESM", 40, 56
SLOPE_AT = 20  # of the settings: cell size and height, then height, radius, climb and slope of the agent
_FIRST_TILE = {  # by version of the set: where the first tile may stand
    1: (SET_HEADER_BYTES,),
    2: (SET_HEADER_BYTES + SETTINGS_BYTES, SET_HEADER_BYTES),  # Habitat's build settings; others have none
}
OTHER_FILES = {
    b"MSET": ("is a big-endian tile set", "export it on a little-endian machine"),
    b"TEST": ("is a tile cache, whose tiles are compressed", "export the nav-mesh itself (dtNavMesh)"),
}


@dataclass(frozen=True)
class Tile:
    """Where one tile lies in the file, and the sections it consists of."""

    at: int  # [bytes]
    header: np.void
    sections: dict[str, Section]


def find_tiles(data: bytes) -> tuple[Layout, list[Tile]]:
    """The tiles of a tile set, or of a file that is one bare tile. Raises Unreadable with the byte."""
    if data[:4] == TILE_MAGIC:
        return _fitting(LAYOUTS, lambda layout: iter([_tile(data, 0, len(data), layout)]))
    count, version = _set_header(data)
    at, layouts = _first_entry(data, version)
    return _fitting(layouts, lambda layout: _walk(data, at, count, layout))


def _fitting(
    layouts: Sequence[Layout], read: Callable[[Layout], Iterator[Tile]]
) -> tuple[Layout, list[Tile]]:
    """The first layout in which the sections of every tile add up; else the problem of what came farthest."""
    problems: list[tuple[int, Unreadable]] = []
    for layout in layouts:
        tiles: list[Tile] = []
        try:
            for tile in read(layout):
                tiles.append(tile)  # not extend: what was found before a problem counts
        except Unreadable as error:
            problems.append((len(tiles), error))
        else:
            return layout, tiles
    raise max(problems, key=lambda problem: problem[0])[1]


def _set_header(data: bytes) -> tuple[int, int]:
    """Number of tiles and version that the set states."""
    if data[:4] in OTHER_FILES:
        found, remedy = OTHER_FILES[data[:4]]
        raise Unreadable(f"{found} ({data[:4]!r} at byte 0)", remedy)
    if data[:4] != SET_MAGIC:
        found = f"starts with {data[:4]!r}, which is no Detour tile set ({SET_MAGIC!r}) at byte 0"
        raise Unreadable(found, "save the nav-mesh as Recast's demo does, or export it as OBJ or GLB")
    if len(data) < SET_HEADER_BYTES:
        _bad(f"ends at byte {len(data)}, within its header of {SET_HEADER_BYTES} bytes")
    _, version, count = np.frombuffer(data, "<i4", 3).tolist()
    if version not in _FIRST_TILE:
        valid = " or ".join(map(str, _FIRST_TILE))
        raise Unreadable(f"has version {version} at byte 4", f"versions {valid} are read")
    if count < 1:
        raise Unreadable(f"states {count} tiles at byte 8", "build the nav-mesh before it is exported")
    return count, version


def _first_entry(data: bytes, version: int) -> tuple[int, list[Layout]]:
    """Where the first tile's entry stands, and the layouts with an entry of that size."""
    places = []
    for at in _FIRST_TILE[version]:
        for size in sorted({layout.entry.itemsize for layout in LAYOUTS}):
            if data[at + size : at + size + 4] == TILE_MAGIC:
                return at, [layout for layout in LAYOUTS if layout.entry.itemsize == size]
            places.append(at + size)
    _bad(f"has no tile ({TILE_MAGIC!r}) at byte {' or '.join(map(str, places))}")


def _walk(data: bytes, at: int, count: int, layout: Layout) -> Iterator[Tile]:
    """All tiles of a set whose first entry stands at byte `at`."""
    for number in range(count):
        if at + layout.entry.itemsize > len(data):
            _bad(f"ends at byte {len(data)}, after {number} of the {count} tiles it states")
        entry = np.frombuffer(data, layout.entry, 1, at)[0]
        at += layout.entry.itemsize
        if not entry["ref"] or not entry["size"]:  # Detour's mark for the end of the list
            break
        yield _tile(data, at, int(entry["size"]), layout)
        at += int(entry["size"])
    if data[at:].strip(b"\0"):
        _bad(f"has {len(data) - at} bytes after its last tile, from byte {at} on")


def _tile(data: bytes, at: int, size: int, layout: Layout) -> Tile:
    """The tile of `size` bytes at byte `at`, after its sizes have been checked."""
    if not layout.header.itemsize <= size <= len(data) - at:
        _bad(f"has a tile of {size} bytes at byte {at}, where {len(data) - at} bytes are left")
    if data[at : at + 4] != TILE_MAGIC:
        _bad(f"has no tile ({TILE_MAGIC!r}) at byte {at}")
    header = np.frombuffer(data, layout.header, 1, at)[0]
    if header["version"] != TILE_VERSION:
        found = f"has a tile of version {header['version']} at byte {at + 4}"
        raise Unreadable(found, f"version {TILE_VERSION} is read")
    counts = _counts(header, at)
    sections, end = layout.sections(counts, at)
    if end != at + size:
        _bad(f"has a tile of {size} bytes at byte {at} whose sections add up to {end - at} ({layout.name})")
    return Tile(at, header, sections)


def _counts(header: np.void, at: int) -> dict[str, int]:
    """The lengths of a tile's sections by name, none of them negative."""
    counts = {name: int(header[name]) for name in header.dtype.names or () if name in SIZES}
    for name, count in counts.items():
        if count < 0:
            _bad(f"states {count} {name} at byte {at + field_offset(header, name)}")
    return counts


def _bad(found: str) -> NoReturn:
    raise Unreadable(found, DAMAGED)
