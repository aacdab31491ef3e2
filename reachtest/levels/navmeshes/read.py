"""Reads a nav-mesh file of any format into level coordinates."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import ValidationError

from reachtest.errors import BadInput, Problem
from reachtest.levels.keys.geometry import FrameSpec
from reachtest.levels.keys.navmesh import NavMeshSpec
from reachtest.levels.meshes.defects import degenerate
from reachtest.levels.meshes.paths import file_problem
from reachtest.levels.meshes.read import Mesh, guarded, placed, read_bytes
from reachtest.levels.meshes.scene import NavFile
from reachtest.levels.navmeshes.formats import AUTO, NAVMESH_FORMATS, NAVMESH_SUFFIXES, NavFormat, format_of
from reachtest.records import Frame, Ints, NavAgent, NavLink, NavMesh


@dataclass(frozen=True)
class NavMeshFile:
    """A nav-mesh file, read."""

    mesh: Mesh
    navmesh: NavMesh  # in level coordinates, without degenerate triangles
    degenerate: int  # triangles left out


def read_navmesh(spec: NavMeshSpec, folder: Path, frame: FrameSpec, where: str) -> NavMeshFile:
    """Read the file that `spec` names. Raises BadInput with every problem found in it."""
    name = str(spec.mesh)
    if problem := file_problem(name, folder, NAVMESH_SUFFIXES, typed=False):
        raise BadInput([Problem(f"{where}.mesh", *problem)])
    path = folder / name
    with guarded(name, where):
        data = read_bytes(path)
        kind = _format(spec, data, path, where)
        file = kind.read(data, path)
        attached = b"".join(other.read_bytes() for other in kind.attached(data, path))
    units = spec.units or kind.units or frame.units
    up_axis = spec.up_axis or kind.up_axis or frame.up_axis
    own, pieces = placed(file.pieces, spec, (up_axis, units), name, where)
    mesh = Mesh(name, data + attached, own, pieces)
    return NavMeshFile(mesh, *_navmesh(mesh, file, chosen=spec.nodes is not None))


def read_navmesh_file(file: Path, **keys: Any) -> NavMesh:
    """The nav-mesh of a file without a level; `keys` are those of the navmesh section, None for defaults.

    Raises BadInput.
    """
    given = {key: value for key, value in keys.items() if value is not None}
    try:
        spec = NavMeshSpec.model_validate({"mesh": file.name or str(file), **given})
    except ValidationError as error:
        raise BadInput(
            [
                Problem(
                    f"command line: {each['loc'][0]}", each["msg"].removeprefix("Value error, "), "see --help"
                )
                for each in error.errors()
            ]
        ) from error
    return read_navmesh(spec, file.parent, FrameSpec.model_validate({}), "navmesh").navmesh


def _format(spec: NavMeshSpec, data: bytes, path: Path, where: str) -> NavFormat:
    name = format_of(data, path) if spec.format == AUTO else spec.format
    if name is None:
        types = " ".join(sorted(NAVMESH_SUFFIXES))
        remedy = f"export it as one of {types}, or name its format: {', '.join(NAVMESH_FORMATS)}"
        raise BadInput([Problem(f"{where}.mesh", f"{spec.mesh} holds no nav-mesh of a known format", remedy)])
    return NAVMESH_FORMATS[name]


def _navmesh(mesh: Mesh, file: NavFile, chosen: bool) -> tuple[NavMesh, int]:
    """All pieces in one, and the number of degenerate triangles left out."""
    starts = np.cumsum([0, *(len(piece.vertices) for piece in mesh.pieces)])
    vertices = np.concatenate([piece.vertices for piece in mesh.pieces])
    faces = np.concatenate([piece.faces + start for piece, start in zip(mesh.pieces, starts, strict=False)])
    thin = degenerate(vertices[faces])
    areas: list[Ints] = [piece.areas for piece in mesh.pieces if piece.areas is not None]
    navmesh = NavMesh(
        file=mesh.file,
        vertices=vertices,
        faces=faces[~thin],
        format=file.format,
        polygons=None if chosen else file.polygons,
        agent=_agent(file.agent, _scale(mesh.frame)),
        links=tuple(_link(link, mesh.frame) for link in file.links),
        areas=np.concatenate(areas)[~thin] if len(areas) == len(mesh.pieces) else None,
    )
    return navmesh, int(thin.sum())


def _scale(frame: Frame) -> float:
    """Length of one of the file's units [m]."""
    return float(np.cbrt(abs(np.linalg.det(frame.matrix))))


def _agent(agent: NavAgent, scale: float) -> NavAgent:
    def length(number: float | None) -> float | None:
        return None if number is None else number * scale

    return NavAgent(length(agent.radius_m), length(agent.height_m), length(agent.climb_m), agent.slope_deg)


def _link(link: NavLink, frame: Frame) -> NavLink:
    start, end = frame.to_level(link.start), frame.to_level(link.end)
    return replace(link, start=start, end=end, radius_m=link.radius_m * _scale(frame))
