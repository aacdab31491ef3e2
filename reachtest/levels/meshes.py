"""Reads mesh files into level coordinates, and says what is wrong with them.

Shape legend: V vertices, F triangles.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from pathlib import Path

import numpy as np

from reachtest.errors import BadInput, Problem
from reachtest.levels.fields import FARTHEST, nearest
from reachtest.levels.frames import make_frame
from reachtest.levels.read_gltf import external_files, read_glb, read_gltf
from reachtest.levels.read_mjcf import read_mjcf
from reachtest.levels.read_obj import read_obj
from reachtest.levels.read_plain import read_ply, read_stl
from reachtest.levels.scene import Piece, Unreadable
from reachtest.levels.schema import FrameSpec, MeshSpec
from reachtest.records import Bools, Floats, Frame

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

THINNEST_M = 1e-6  # below the resolution of 32-bit coordinates in any level: no surface, only rounding


@dataclass(frozen=True)
class Mesh:
    """A mesh file, read."""

    file: str
    digest_data: bytes  # what the file holds, with what is in the files it names
    frame: Frame
    pieces: tuple[Piece, ...]  # in level coordinates


def file_problem(
    name: str, folder: Path, readers: Collection[str], what_for: str = "mesh", typed: bool = True
) -> tuple[str, str] | None:
    """What is wrong with the file's name, and the remedy; None where it can be read.

    Of a file that is `typed`, the suffix must be one of `readers`.
    """
    path = folder / name
    if typed and path.suffix.lower() not in readers:
        what = f"of type {path.suffix!r}" if path.suffix else "without a type"
        return f"{name} is a file {what}", f"export it as one of {' '.join(sorted(readers))}"
    if path.is_file():
        return None
    if path.exists():
        return f"{name} is not a file", f"name the {what_for} file itself"
    if not path.parent.is_dir():
        return (
            f"{name} does not exist: there is no folder {Path(name).parent}",
            f"paths start at {folder.name}/",
        )
    names = sorted(other.name for other in path.parent.iterdir())
    near = nearest(path.name, names)
    valid = [other for other in names if Path(other).suffix.lower() in readers]
    there = f"{what_for} files there: {', '.join(valid[:8]) or 'none'}"
    return f"{name} does not exist", f"{near}{there}"


def read_mesh(
    spec: MeshSpec, folder: Path, frame: FrameSpec, readers: Mapping[str, MeshReader], where: str
) -> Mesh:
    """Read the file that `spec` names. Raises BadInput with every problem found in it."""
    name = str(spec.mesh)
    if problem := file_problem(name, folder, readers):
        raise BadInput([Problem(f"{where}.mesh", *problem)])
    path = folder / name
    suffix = path.suffix.lower()
    with guarded(name, where):
        data = read_bytes(path)
        pieces = readers[suffix](data, path)
    attached = _attached(data, path, pieces)
    up_axis = spec.up_axis or FORMAT_UP_AXIS.get(suffix, frame.up_axis)
    units = spec.units or FORMAT_UNITS.get(suffix) or frame.units
    own, found = placed(pieces, spec, (up_axis, units), name, where)
    return Mesh(name, data + attached, own, found)


@contextmanager
def guarded(name: str, where: str) -> Iterator[None]:
    """Whatever goes wrong while the file `name` is read becomes BadInput."""
    try:
        yield
    except BadInput:
        raise
    except Unreadable as error:
        raise BadInput([Problem(f"{where}.mesh", f"{name} {error.found}", error.remedy)]) from error
    except Exception as error:  # readers of other people's formats raise anything
        found = f"{name} cannot be read: {type(error).__name__}: {error}".rstrip(": ")
        remedy = "the file is damaged or cut off: export it again and check that it opens elsewhere"
        raise BadInput([Problem(f"{where}.mesh", found, remedy)]) from error


def read_bytes(path: Path) -> bytes:
    """What a file holds. Raises Unreadable where that is nothing."""
    if data := path.read_bytes():
        return data
    raise Unreadable("is empty: 0 bytes", "export or copy it again")


def placed(
    pieces: list[Piece], spec: MeshSpec, axes: tuple[str, str | float], name: str, where: str
) -> tuple[Frame, tuple[Piece, ...]]:
    """The frame of a file with this up axis and these units, and its chosen pieces in level coordinates.

    Raises BadInput for what makes them unusable.
    """
    pieces = _chosen(pieces, spec, where, name)
    if problems := [Problem(f"{where}.mesh", *bad) for bad in _defects(pieces, name)]:
        raise BadInput(problems)
    own = make_frame(*axes, spec.scale, spec.flip_x)
    result = tuple(_placed(piece, own) for piece in pieces)
    if all(degenerate(piece.triangles).all() for piece in result):
        found = f"all triangles of {name} are thinner than {THINNEST_M:g} m"
        raise BadInput([Problem(f"{where}.mesh", found, "check units and scale, or export it again")])
    return own, result


def _attached(data: bytes, path: Path, pieces: list[Piece]) -> bytes:
    """What the files hold that the file names."""
    suffix = path.suffix.lower()
    if suffix == ".xml":  # only MuJoCo knows which files it read; all that came of them is in the pieces
        return b"".join(array.tobytes() for piece in pieces for array in (piece.vertices, piece.faces))
    named = external_files(data, path) if suffix in (".glb", ".gltf") else []
    return b"".join(other.read_bytes() for other in named)


def _chosen(pieces: list[Piece], spec: MeshSpec, where: str, file: str) -> list[Piece]:
    """The pieces whose node names match `spec.nodes`. Raises BadInput for a pattern without a match."""
    if spec.nodes is None:
        return pieces
    names = sorted({piece.name for piece in pieces})
    problems = []
    for index, pattern in enumerate(spec.nodes):
        if not any(fnmatchcase(name, pattern) for name in names):
            some = ", ".join(names[:8]) + (f" and {len(names) - 8} more" if len(names) > 8 else "")
            remedy = f"{nearest(pattern, names)}nodes with a mesh: {some or 'none'}"
            problems.append(
                Problem(f"{where}.nodes[{index}]", f"{pattern!r} matches no node of {file}", remedy)
            )
    if problems:
        raise BadInput(problems)
    return [piece for piece in pieces if any(fnmatchcase(piece.name, pattern) for pattern in spec.nodes)]


def _defects(pieces: list[Piece], file: str) -> list[tuple[str, str]]:
    """What makes a mesh unusable, as found and remedy."""
    found: list[tuple[str, str]] = []
    if not any(len(piece.faces) for piece in pieces):
        found.append(
            (f"{file} holds no triangles", "export the mesh's faces, not only points, lines or empties")
        )
    for piece in pieces:
        count = len(piece.vertices)
        bad = ~(np.abs(piece.vertices) <= FARTHEST).all(axis=1)  # also NaN
        if bad.any():
            first = int(np.argmax(bad))
            text = f"{file}: {bad.sum()} of {count} vertices of {piece.name!r} are NaN, infinite or beyond {FARTHEST:g}"
            place = ", ".join(f"{value:g}" for value in piece.vertices[first])
            remedy = (
                "repair the mesh (in Blender: Mesh > Clean Up) or its node's transform, and export it again"
            )
            found.append((f"{text}, the first is vertex {first} at ({place})", remedy))
        out = ((piece.faces < 0) | (piece.faces >= count)).any(axis=1)
        if out.any():
            first = int(np.argmax(out))
            text = f"{file}: {out.sum()} faces of {piece.name!r} name vertices outside of 0 to {count - 1}"
            found.append(
                (f"{text}, the first is face {first}: {piece.faces[first].tolist()}", "export it again")
            )
    return found


def _placed(piece: Piece, frame: Frame) -> Piece:
    """The piece in level coordinates; a mirroring frame turns the triangles round again."""
    faces = piece.faces if np.linalg.det(frame.matrix) > 0 else piece.faces[:, ::-1]
    return replace(piece, vertices=frame.to_level(piece.vertices), faces=faces)


def degenerate(triangles: Floats) -> Bools:
    """Which triangles [F, 3, 3] are thinner than a micrometre, and so no surface [F]."""
    edges = triangles - np.roll(triangles, 1, axis=1)
    longest = np.sqrt(np.einsum("fij,fij->fi", edges, edges).max(axis=1, initial=0.0))
    area = np.linalg.norm(np.cross(edges[:, 1], edges[:, 2]), axis=1) / 2
    return np.asarray(2 * area <= THINNEST_M * longest)
