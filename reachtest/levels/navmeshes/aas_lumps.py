"""The lumps of Quake III's area files (`.aas`): where they lie, what their records are."""

from __future__ import annotations

from typing import NoReturn

import numpy as np

from reachtest.levels.meshes.scene import Unreadable
from reachtest.levels.navmeshes.sections import Array, Section
from reachtest.records import Ints

_DAMAGED = "the file is damaged or cut off: compile it again"
MAGIC, _HEADER_BYTES, LUMPS_AT, _LUMPS = b"EAAS", 124, 12, 14
_PLAIN, _SCRAMBLED = 4, 5  # versions; the second hides its header from byte 8 on

_LUMP = {  # number and record of every lump that is read
    "vertexes": (1, np.dtype(("<f4", (3,)))),
    "edges": (3, np.dtype(("<i4", (2,)))),
    "edge index": (4, np.dtype("<i4")),  # negative: the edge runs backwards
    "faces": (
        5,
        np.dtype([(name, "<i4") for name in ("plane", "flags", "count", "first", "front", "back")]),
    ),
    "face index": (6, np.dtype("<i4")),  # negative: the back of the face
    "areas": (
        7,
        np.dtype([("number", "<i4"), ("count", "<i4"), ("first", "<i4"), ("box_and_centre", "<f4", (9,))]),
    ),
    "area settings": (8, np.dtype([("contents", "<i4"), ("flags", "<i4"), ("rest", "<i4", (5,))])),
    "reachability": (
        9,
        np.dtype(
            [("to", "<i4", (3,)), ("ends", "<f4", (2, 3)), ("kind", "<i4"), ("time", "<u2"), ("pad", "<u2")]
        ),
    ),
}
_PRESENCES = (1, 2, 4)  # none, standing, crouching
_BOX_FIELDS = [("presence", "<i4"), ("flags", "<i4"), ("corners", "<f4", (2, 3))]
_BOXES = (np.dtype(_BOX_FIELDS), np.dtype([_BOX_FIELDS[0], _BOX_FIELDS[2]]))  # lump 0 has one or the other


class Lumps:
    """The lumps of a file, whose places and sizes have been checked."""

    def __init__(self, data: bytes) -> None:
        self._data = data
        self._lumps = _lumps(data)

    def section(self, name: str) -> Section:
        """Where a lump lies and how many records it holds."""
        number, dtype = _LUMP[name]
        at, size = self._lumps[number].tolist()
        if size % dtype.itemsize:
            refuse(f"has {size} bytes of {name} at byte {at}, no multiple of {dtype.itemsize}")
        return Section(at, dtype, size // dtype.itemsize)

    def boxes(self) -> Array:
        """The boxes of a player by posture; none where they have neither size that is known."""
        at, size = self._lumps[0].tolist()
        for dtype in _BOXES:
            if size and size % dtype.itemsize == 0:
                boxes = Section(at, dtype, size // dtype.itemsize).read(self._data)
                if np.isin(boxes["presence"], _PRESENCES).all():
                    return boxes
        return np.zeros(0, _BOXES[0])

    def read(self, name: str) -> Array:
        """All records of a lump."""
        return self.section(name).read(self._data)

    def refuse(self, wrong: Array, name: str, found: str, rows: Array | None = None) -> None:
        """Raise Unreadable for the first of `rows` (of all, by default) that is `wrong`."""
        self.section(name).refuse(wrong, name, found, _DAMAGED, rows)


def refuse(found: str) -> NoReturn:
    """Raise Unreadable for a damaged file."""
    raise Unreadable(found, _DAMAGED)


def _lumps(data: bytes) -> Ints:
    """Start and size [bytes] of all lumps [14, 2], each of them within the file."""
    if data[:4] != MAGIC:
        found = f"starts with {data[:4]!r}, which is no area file ({MAGIC!r}) at byte 0"
        raise Unreadable(found, "name a Quake III .aas file, or export the nav-mesh as OBJ or GLB")
    if len(data) < _HEADER_BYTES:
        refuse(f"ends at byte {len(data)}, within its header of {_HEADER_BYTES} bytes")
    version = int.from_bytes(data[4:8], "little", signed=True)
    if version not in (_PLAIN, _SCRAMBLED):
        raise Unreadable(f"has version {version} at byte 4", f"versions {_PLAIN} and {_SCRAMBLED} are read")
    header = np.frombuffer(data, np.uint8, _HEADER_BYTES).copy()
    if version == _SCRAMBLED:
        header[8:] ^= (np.arange(_HEADER_BYTES - 8) * 119 & 0xFF).astype(np.uint8)
    lumps = header[LUMPS_AT:].view("<i4").reshape(_LUMPS, 2).astype(np.int64)
    outside = (lumps[:, 1] < 0) | (lumps[:, 1] > 0) & ((lumps[:, 0] < 0) | (lumps.sum(axis=1) > len(data)))
    if outside.any():
        number = int(np.argmax(outside))
        at, size = lumps[number].tolist()
        place = f"lump {number} of {size} bytes from byte {at} on"
        refuse(f"states {place} at byte {LUMPS_AT + 8 * number}, where the file has {len(data)} bytes")
    return lumps
