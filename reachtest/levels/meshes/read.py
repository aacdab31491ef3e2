"""Reads mesh files into level coordinates, and says what is wrong with them.

Shape legend: V vertices, F triangles.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from pathlib import Path

import numpy as np

from reachtest.errors import BadInput, Problem
from reachtest.levels.fields import nearest
from reachtest.levels.frames import make_frame
from reachtest.levels.keys.geometry import FrameSpec, MeshSpec
from reachtest.levels.meshes.defects import THINNEST_M, defects, degenerate
from reachtest.levels.meshes.formats import FORMAT_UNITS, FORMAT_UP_AXIS, MeshReader
from reachtest.levels.meshes.gltf import external_files
from reachtest.levels.meshes.paths import file_problem
from reachtest.levels.meshes.scene import Piece, Unreadable
from reachtest.records import Frame


@dataclass(frozen=True)
class Mesh:
    """A mesh file, read."""

    file: str
    digest_data: bytes  # what the file holds, with what is in the files it names
    frame: Frame
    pieces: tuple[Piece, ...]  # in level coordinates


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
    if problems := [Problem(f"{where}.mesh", *bad) for bad in defects(pieces, name)]:
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


def _placed(piece: Piece, frame: Frame) -> Piece:
    """The piece in level coordinates; a mirroring frame turns the triangles round again."""
    faces = piece.faces if np.linalg.det(frame.matrix) > 0 else piece.faces[:, ::-1]
    return replace(piece, vertices=frame.to_level(piece.vertices), faces=faces)
