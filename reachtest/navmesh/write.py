"""Writes a nav-mesh as a file that the same level file can name under `navmesh.mesh`, without further keys."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from reachtest.files import write_whole
from reachtest.records import Floats, Frame, NavMesh

TYPES = (".glb", ".obj")


def write_navmesh(navmesh: NavMesh, frame: Frame, path: Path) -> None:
    """Write `navmesh` in the level's units: glTF with y up, as its standard asks, OBJ with the level's own axes.

    The file is written whole or not at all. Raises ValueError for a type that is not in TYPES.
    """
    import trimesh

    kind = path.suffix.lower()
    if kind not in TYPES:
        raise ValueError(f"{path.name} is of type {kind!r}, not one of {', '.join(TYPES)}")
    points = _y_up(navmesh.vertices, frame) if kind == ".glb" else frame.to_source(navmesh.vertices)
    mesh = trimesh.Trimesh(points, navmesh.faces, process=False)
    data = mesh.export(file_type=kind[1:])
    write_whole(
        path, lambda part: part.write_bytes(data if isinstance(data, bytes) else data.encode("utf-8"))
    )


def _y_up(points: Floats, frame: Frame) -> Floats:
    unit_m = np.linalg.norm(frame.matrix[:, 0])
    return np.asarray(points[:, [0, 2, 1]] * [1.0, 1.0, -1.0] / unit_m)
