"""The formats of nav-mesh files, and how to tell which of them a file is: by what it holds, not by its name."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from reachtest.levels.meshes.gltf import external_files, is_glb, is_gltf, read_glb_navmesh, read_gltf_navmesh
from reachtest.levels.meshes.obj import is_obj, read_obj_navmesh
from reachtest.levels.meshes.scene import NavFile
from reachtest.levels.navmeshes.aas import is_aas, read_aas
from reachtest.levels.navmeshes.detour import is_detour, read_detour
from reachtest.levels.navmeshes.godot import is_godot, read_godot

AUTO = "auto"


def _none(data: bytes, path: Path) -> list[Path]:
    return []


@dataclass(frozen=True)
class NavFormat:
    """One format: its reader raises Unreadable, `sniff` looks at the content only."""

    read: Callable[[bytes, Path], NavFile]
    sniff: Callable[[bytes], bool]
    suffixes: tuple[str, ...]  # what its files are usually called
    up_axis: str | None = None  # where the format fixes it; else the frame's
    units: str | None = None
    attached: Callable[[bytes, Path], list[Path]] = _none  # files that a file names


NAVMESH_FORMATS: dict[str, NavFormat] = {
    "detour": NavFormat(read_detour, is_detour, (".bin", ".navmesh"), "y"),  # Recast, whatever the engine
    "glb": NavFormat(read_glb_navmesh, is_glb, (".glb",), "y", attached=external_files),
    "aas": NavFormat(read_aas, is_aas, (".aas",), "z"),  # a Quake unit is what its level says
    "godot": NavFormat(read_godot, is_godot, (".tres", ".tscn"), "y", "m"),
    "gltf": NavFormat(read_gltf_navmesh, is_gltf, (".gltf",), "y", attached=external_files),
    "obj": NavFormat(read_obj_navmesh, is_obj, (".obj",)),
}
"""One new file and one line to add one; asked in this order."""

NAVMESH_SUFFIXES = tuple(suffix for each in NAVMESH_FORMATS.values() for suffix in each.suffixes)


def format_of(data: bytes, path: Path) -> str | None:
    """The name of a file's format: by content, else (a damaged file) by its suffix; None if by neither."""
    for name, each in NAVMESH_FORMATS.items():
        if each.sniff(data):
            return name
    suffix = path.suffix.lower()
    return next((name for name, each in NAVMESH_FORMATS.items() if suffix in each.suffixes), None)
