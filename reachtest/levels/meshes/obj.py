"""OBJ: one piece for every object and group; what trimesh would misread is refused first."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

from reachtest.levels.fields import FARTHEST, show
from reachtest.levels.meshes.scene import MOST_SHOWN, NavFile, Piece, Unreadable, read_scene, several
from reachtest.records import NavAgent

_AGAIN = "the file is damaged or cut off: export it again"
_SHORT_FACE = re.compile(rb"^f(?:[ \t]+\S+){0,2}[ \t\r]*$", re.MULTILINE)
_ZERO_INDEX = re.compile(rb"^f(?:[ \t]+\S+)*?[ \t]+0(?:/|\s|$)", re.MULTILINE)
_NUMBER = rb"[-+]?(?:\d+\.?\d*+|\.\d++)(?:[eE][-+]?\d++)?+"
# All but "v x y z", perhaps with a weight or a colour; a line that goes on in the next one is left to trimesh.
_BAD_VERTEX = re.compile(
    rb"^[ \t]*+v(?=[ \t\r\n])(?!(?<=^v)(?: ++" + _NUMBER + rb"){3,}+[ \r]*$)[^\n]*+(?<!\\)(?<!\\\r)$",
    re.MULTILINE,
)
_CORNER = re.compile(rb"[ \t](-?\d++)(?:/-?\d*+){0,2}(?=[\s\\]|$)")
_FACE_LINE = re.compile(rb"^f[ \t][^\n]*+", re.MULTILINE)
_RELATIVE = re.compile(rb"^f(?:[ \t]+\S+)*?[ \t]+-\d", re.MULTILINE)


def read_obj(data: bytes, path: Path) -> list[Piece]:
    """The objects and groups of an OBJ file."""
    _refuse_binary(data)
    # Only blanks part words for trimesh, and only a line's first byte starts it.
    data = data.removeprefix(b"\xef\xbb\xbf").replace(b"\t", b" ")
    _refuse_misread(data)
    try:
        pieces = read_scene(data, path, "obj", **_OPTIONS)
    except (IndexError, ValueError) as error:  # it does not say where
        _refuse_faces(data)
        raise Unreadable(f"has faces or vertices that are not understood: {error}", _AGAIN) from error
    return [_named(piece, path) for piece in pieces]


_AGENT = {b"agr": "radius_m", b"agh": "height_m", b"amc": "climb_m", b"ams": "slope_deg"}
_AGENT_LINE = re.compile(rb"^rd_(agr|agh|amc|ams)[ \t]+(\S+)", re.MULTILINE)
_FACE = re.compile(rb"^f[ \t]", re.MULTILINE)
_VERTEX = re.compile(rb"^v[ \t]+[-+.\d]", re.MULTILINE)


def is_obj(data: bytes) -> bool:
    """Whether a file is text with a line that states a vertex."""
    return b"\0" not in data[:4096] and _VERTEX.search(data) is not None


def read_obj_navmesh(data: bytes, path: Path) -> NavFile:
    """An OBJ with the `rd_*` lines in which Recast's exporters state the agent. Raises Unreadable."""
    pieces = read_obj(data, path)
    numbers: dict[str, float] = {}
    for match in _AGENT_LINE.finditer(data):
        try:
            number = float(match[2])
        except ValueError:
            number = -1.0
        if not 0 <= number <= FARTHEST:
            found = f"has 'rd_{match[1].decode()} {match[2][:40].decode(errors='replace')}'"
            raise Unreadable(
                f"{found} in line {_line(data, match.start())}", "write a number >= 0, or remove it"
            )
        if number:  # Unreal's exporter cuts the climb down to a whole number: 0 says nothing
            numbers[_AGENT[match[1]]] = number
    polygons = sum(1 for _ in _FACE.finditer(data))
    return NavFile(pieces, "OBJ with rd_ lines" if numbers else "OBJ", polygons, NavAgent(**numbers))


# A name for every `o` and `g`; materials would only split the pieces further.
_OPTIONS = {"skip_materials": True, "group_material": False, "split_objects": True, "split_groups": True}


def _named(piece: Piece, path: Path) -> Piece:
    """A piece without a name of its own gets the file's, not the reader's stand-in."""
    stand_in = piece.name in ("geometry", path.name) or piece.name.startswith(f"{path.name}_")
    return replace(piece, name=path.stem) if stand_in else piece


def _line(data: bytes, at: int) -> int:
    return data.count(b"\n", 0, at) + 1


def _refuse_binary(data: bytes) -> None:
    if (at := data.find(b"\0")) >= 0:
        raise Unreadable(f"is no text: it has a NUL at byte {at}", "name an OBJ file, in text")
    try:
        data.decode()
    except UnicodeDecodeError as error:
        found = f"is no text in UTF-8: byte {data[error.start]:#04x} in line {_line(data, error.start)}"
        raise Unreadable(found, "export it again with names in UTF-8 or ASCII") from error


def _refuse_misread(data: bytes) -> None:
    if wrong := list(_BAD_VERTEX.finditer(data)):
        raise Unreadable(_shown(data, wrong), "write 'v' and three finite numbers at the start of the line")
    if match := _SHORT_FACE.search(data):
        raise Unreadable(f"has a face with fewer than 3 corners in line {_line(data, match.start())}", _AGAIN)
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


def _refuse_faces(data: bytes) -> None:
    """Say which faces have corners that are no vertices of the file."""
    count, wrong = sum(1 for _ in _VERTEX.finditer(data)), []
    for match in _FACE_LINE.finditer(data):
        corners = match[0].split(b"\\")[0].split()[1:]
        numbers = _CORNER.findall(match[0])
        if len(numbers) < len(corners) or any(not 0 < abs(int(number)) <= count for number in numbers):
            wrong.append(match)
    if wrong:
        remedy = f"corners are whole numbers from 1 to {count}, the file's vertices"
        raise Unreadable(_shown(data, wrong), remedy)


def _shown(data: bytes, lines: list[re.Match[bytes]]) -> str:
    """The first few of these lines of the file, and how many more there are."""
    each = [
        f"line {_line(data, line.start())} is {show(line[0].decode(errors='replace').strip())}"
        for line in lines[:MOST_SHOWN]
    ]
    return f"cannot be read: {several(each, len(lines))}"
