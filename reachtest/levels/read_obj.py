"""OBJ: one piece for every object and group; what trimesh would misread is refused first."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

from reachtest.levels.scene import Piece, Unreadable, read_scene

_SHORT_FACE = re.compile(rb"^f(?:[ \t]+\S+){0,2}[ \t\r]*$", re.MULTILINE)
_ZERO_INDEX = re.compile(rb"^f(?:[ \t]+\S+)*?[ \t]+0(?:/|\s|$)", re.MULTILINE)
_RELATIVE = re.compile(rb"^f(?:[ \t]+\S+)*?[ \t]+-\d", re.MULTILINE)


def read_obj(data: bytes, path: Path) -> list[Piece]:
    """The objects and groups of an OBJ file."""
    _refuse_misread(data)
    pieces = read_scene(data, path, "obj", **_OPTIONS)
    return [_named(piece, path) for piece in pieces]


# A name for every `o` and `g`; materials would only split the pieces further.
_OPTIONS = {"skip_materials": True, "group_material": False, "split_objects": True, "split_groups": True}


def _named(piece: Piece, path: Path) -> Piece:
    """A piece without a name of its own gets the file's, not the reader's stand-in."""
    stand_in = piece.name in ("geometry", path.name) or piece.name.startswith(f"{path.name}_")
    return replace(piece, name=path.stem) if stand_in else piece


def _line(data: bytes, at: int) -> int:
    return data.count(b"\n", 0, at) + 1


def _refuse_misread(data: bytes) -> None:
    if match := _SHORT_FACE.search(data):
        remedy = "the file is damaged or cut off: export it again"
        raise Unreadable(f"has a face with fewer than 3 corners in line {_line(data, match.start())}", remedy)
    if match := _ZERO_INDEX.search(data):
        raise Unreadable(
            f"has vertex number 0 in line {_line(data, match.start())}", "OBJ numbers start at 1"
        )
    # Relative numbers count from the vertices read so far; trimesh counts them from the file's last vertex.
    match = _RELATIVE.search(data)
    if match and data.rfind(b"\nv ") > match.start():
        found = (
            f"has relative vertex numbers between its vertices, first in line {_line(data, match.start())}"
        )
        raise Unreadable(found, "export with absolute vertex numbers, or as GLB")
