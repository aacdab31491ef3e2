"""Area files of Quake III's bots (`.aas`): the faces they stand on, z up.

Shape legend: F triangles.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from reachtest.levels.fields import FARTHEST
from reachtest.levels.meshes.scene import NavFile, Piece, Unreadable
from reachtest.levels.navmeshes.aas_lumps import LUMPS_AT, MAGIC, Lumps, refuse
from reachtest.levels.navmeshes.sections import Array
from reachtest.records import Bools, Ints, NavAgent, NavLink

_AREA_GROUNDED, _FACE_GROUND = 1, 4
_LOOSEST = 1.0  # gap between the edges of a face [units]; the compiler merges vertices within 0.1

_STANDING = 2  # PRESENCE_NORMAL

_TRAVEL_MASK = 0xFFFFFF  # above it are flags of the team that may use it
_TRAVEL = {
    4: "barrier jump",
    5: "jump",
    6: "ladder",
    7: "walk off ledge",
    8: "swim",
    9: "water jump",
    10: "teleport",
    11: "elevator",
    12: "rocket jump",
    13: "BFG jump",
    14: "grapple",
    15: "double jump",
    16: "ramp jump",
    17: "strafe jump",
    18: "jump pad",
    19: "moving platform",
}
"""Kinds of reachability that the surface does not show; 2 and 3, walking and crouching, it does."""


def is_aas(data: bytes) -> bool:
    """Whether a file is an area file."""
    return data[:4] == MAGIC


def read_aas(data: bytes, path: Path) -> NavFile:
    """The ground faces of the areas one can stand in, as one piece, wound to face up. Raises Unreadable."""
    file = Lumps(data)
    ground = _ground_faces(file)
    version = int.from_bytes(data[4:8], "little")
    return NavFile(
        [_surface(file, ground, path.stem)],
        f"Quake III AAS, version {version}",
        len(ground),
        _agent(file.boxes()),
        _links(file),
    )


def _agent(boxes: Array) -> NavAgent:
    """Of the box that a standing player is."""
    standing = boxes["corners"][boxes["presence"] == _STANDING]
    if not len(standing):
        return NavAgent()
    size = standing[0, 1].astype(np.float64) - standing[0, 0]
    if not ((size > 0) & (size < FARTHEST)).all():
        refuse(f"has a player of {' x '.join(f'{each:g}' for each in size)} (lump at byte {LUMPS_AT})")
    return NavAgent(radius_m=float(size[:2].max() / 2), height_m=float(size[2]))


def _links(file: Lumps) -> tuple[NavLink, ...]:
    records = file.read("reachability")
    kinds = records["kind"] & _TRAVEL_MASK
    chosen = np.flatnonzero(np.isin(kinds, list(_TRAVEL)))
    far = ~(np.abs(records["ends"][chosen]) <= FARTHEST).all(axis=(1, 2))
    file.refuse(far, "reachability", "with an end that is NaN, infinite or too far away", chosen)
    ends = records["ends"][chosen].astype(np.float64)
    return tuple(
        NavLink(_TRAVEL[kind], start, end, 0.0, False)
        for kind, (start, end) in zip(kinds[chosen].tolist(), ends, strict=True)
    )


def _surface(file: Lumps, ground: Ints, name: str) -> Piece:
    corners, sizes = _loops(file, ground)
    faces = _fans(corners, sizes)
    used, faces = np.unique(faces, return_inverse=True)
    vertices, faces = file.read("vertexes")[used].astype(np.float64), faces.reshape(-1, 3)
    a, b, c = (vertices[faces[:, corner], :2] for corner in range(3))
    first, second = b - a, c - a
    down = first[:, 0] * second[:, 1] < first[:, 1] * second[:, 0]
    faces[down] = faces[down, ::-1]
    return Piece(name, vertices, faces)


def _ground_faces(file: Lumps) -> Ints:
    """The faces to stand on, each of them once, in order."""
    areas, settings, index = file.read("areas"), file.read("area settings"), file.read("face index")
    if len(areas) != len(settings):
        refuse(f"has {len(areas)} areas but {len(settings)} area settings (bytes 68 to 83)")
    grounded = np.flatnonzero(settings["flags"] & _AREA_GROUNDED)
    rows, _ = _ranges(file, "areas", areas, grounded, len(index), "face index")
    numbers = np.abs(index[rows].astype(np.int64))
    faces = file.read("faces")
    file.refuse(numbers >= len(faces), "face index", f"outside of the {len(faces)} faces", rows)
    numbers = np.unique(numbers)
    ground: Ints = numbers[faces["flags"][numbers] & _FACE_GROUND != 0]
    if not len(ground):
        found = f"holds no triangles: none of its {len(faces)} faces (lump at byte 52) is ground to stand on"
        raise Unreadable(found, "compile it without bspc's -optimize, which leaves the ground faces out")
    return ground


def _ranges(file: Lumps, name: str, records: Array, used: Ints, most: int, target: str) -> tuple[Ints, Ints]:
    """The rows of `target` that the records `used` name, one after the other, and how many each names."""
    first, count = (records[field][used].astype(np.int64) for field in ("first", "count"))
    beyond = (first < 0) | (count < 0) | (first + count > most)
    file.refuse(beyond, name, f"beyond the {most} of the {target}", used)
    # Records shared by many would make a small file a huge mesh.
    file.refuse(np.cumsum(count) > most, name, f"with more than the {most} of the {target} in all", used)
    within = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)
    return np.repeat(first, count) + within, count


def _loops(file: Lumps, ground: Ints) -> tuple[Ints, Ints]:
    """The corners of all faces `ground`, one face after the other, and how many each has."""
    index, edges, vertexes = file.read("edge index"), file.read("edges"), file.read("vertexes")
    rows, sizes = _ranges(file, "faces", file.read("faces"), ground, len(index), "edge index")
    file.refuse(sizes < 3, "faces", "with fewer than 3 edges", ground)
    signed = index[rows].astype(np.int64)
    file.refuse(np.abs(signed) >= len(edges), "edge index", f"outside of the {len(edges)} edges", rows)
    ends = edges[np.abs(signed)].astype(np.int64)
    outside = _any(np.logical_or(ends < 0, ends >= len(vertexes)))
    file.refuse(outside, "edges", f"with an end outside of the {len(vertexes)} vertexes", np.abs(signed))
    far = _any(~(np.abs(vertexes) <= FARTHEST))  # true for NaN
    file.refuse(far, "vertexes", "that is NaN, infinite or too far away")
    backwards = (signed < 0).astype(np.int64)[:, None]
    start, end = (np.take_along_axis(ends, abs(side - backwards), axis=1)[:, 0] for side in (0, 1))
    following = np.arange(1, len(start) + 1)
    following[np.cumsum(sizes) - 1] = np.cumsum(sizes) - sizes
    gap = np.abs(vertexes[end].astype(np.float64) - vertexes[start[following]]).max(axis=1)
    file.refuse(gap > _LOOSEST, "faces", "whose edges are no closed loop", np.repeat(ground, sizes))
    return start, sizes


def _any(wrong: Bools) -> Bools:
    """Which rows have something wrong."""
    return np.asarray(wrong.any(axis=1))


def _fans(corners: Ints, sizes: Ints) -> Ints:
    """Triangles [F, 3] of convex polygons with `sizes` corners each, whose corners follow each other."""
    triangles = sizes - 2
    start = np.repeat(np.cumsum(sizes) - sizes, triangles)
    step = np.arange(triangles.sum()) - np.repeat(np.cumsum(triangles) - triangles, triangles)
    return np.stack([corners[start], corners[start + step + 1], corners[start + step + 2]], axis=1)
