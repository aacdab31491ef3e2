"""PLY and STL: one mesh without nodes, named after its file."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from reachtest.levels.meshes.scene import Piece, read_scene


def read_ply(data: bytes, path: Path) -> list[Piece]:
    """The mesh of a PLY file."""
    return _named(read_scene(data, path, "ply"), path)


def read_stl(data: bytes, path: Path) -> list[Piece]:
    """The mesh of an STL file, text or binary."""
    return _named(read_scene(data, path, "stl"), path)


def _named(pieces: list[Piece], path: Path) -> list[Piece]:
    return [replace(piece, name=path.stem) for piece in pieces]
