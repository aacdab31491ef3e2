"""The formats of mesh files, by suffix."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from reachtest.levels.meshes.gltf import read_glb, read_gltf
from reachtest.levels.meshes.mjcf import read_mjcf
from reachtest.levels.meshes.obj import read_obj
from reachtest.levels.meshes.plain import read_ply, read_stl
from reachtest.levels.meshes.scene import Piece

MeshReader = Callable[[bytes, Path], list[Piece]]

MESH_READERS: dict[str, MeshReader] = {
    ".obj": read_obj,
    ".glb": read_glb,
    ".gltf": read_gltf,
    ".ply": read_ply,
    ".stl": read_stl,
    ".xml": read_mjcf,
}
"""One new file and one line to add one."""

FORMAT_UP_AXIS = {
    ".glb": "y",  # glTF 2.0, section 3.4
    ".gltf": "y",
    ".xml": "z",  # MuJoCo
}
"""What a format fixes; other files have the frame's axes."""

FORMAT_UNITS = {".xml": "m"}
"""Likewise: SI in MuJoCo's defaults."""
