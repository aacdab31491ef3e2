"""Reads everything that a level file names, as far as it can be read, and collects what is wrong with it."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from reachtest.errors import BadInput, Problem
from reachtest.geometry import grid_surface
from reachtest.levels.frames import make_frame
from reachtest.levels.keys.geometry import GeometrySpec
from reachtest.levels.keys.level import LevelSpec
from reachtest.levels.meshes.defects import degenerate
from reachtest.levels.meshes.formats import MESH_READERS
from reachtest.levels.meshes.read import read_mesh
from reachtest.levels.meshes.scene import Piece
from reachtest.levels.meshes.solids import make_solids
from reachtest.levels.navmeshes.read import NavMeshFile, read_navmesh
from reachtest.levels.shapes.build import build_primitive
from reachtest.records import Floats, HeightField, Part, Solid


@dataclass
class Collected:
    """What the files of a level hold, piece by piece, and the problems on the way."""

    spec: LevelSpec
    path: Path
    problems: list[Problem]

    def __post_init__(self) -> None:
        self.folder = self.path.parent
        self.frame = make_frame(self.spec.frame.up_axis, self.spec.frame.units)
        self.collision: list[Floats] = []
        self.height_fields: list[HeightField] = []
        self.solids: list[Solid] = []
        self.parts: list[Part] = []
        self.contents: list[bytes] = []
        self.navmesh: NavMeshFile | None = None
        self.collision_known = True

    def read(self) -> None:
        """Read geometry and nav-mesh."""
        for index, item in enumerate(self.spec.geometry):
            where = f"{self.path.name}: geometry[{index}]"
            try:
                pieces = self._pieces(item, where, index)
            except BadInput as error:
                self.problems += error.problems
                self.collision_known &= item.role == "solid"
                continue
            self._add(item, pieces, where, index)
        if self.collision_known and all(degenerate(triangles).all() for triangles in self.collision):
            remedy = "give at least one piece of geometry role: collision or both"
            self.problems.append(Problem(f"{self.path.name}: geometry", "has no collision surface", remedy))
            self.collision_known = False
        if self.spec.navmesh.build is not None:
            return
        try:
            where = f"{self.path.name}: navmesh"
            self.navmesh = read_navmesh(self.spec.navmesh, self.folder, self.spec.frame, where)
            self.contents.append(self.navmesh.mesh.digest_data)
        except BadInput as error:
            self.problems += error.problems

    def _pieces(self, item: GeometrySpec, where: str, index: int) -> tuple[Piece, ...]:
        if item.shape == "mesh":
            mesh = read_mesh(item, self.folder, self.spec.frame, MESH_READERS, where)
            self.contents.append(mesh.digest_data)
            return mesh.pieces
        spec = getattr(item, item.shape)
        built, content = build_primitive(item.shape, spec, self.folder, self.frame, where)
        self.contents.append(content)
        if isinstance(built, HeightField):
            if item.role != "solid":
                first = sum(len(triangles) for triangles in self.collision)
                self.height_fields.append(dataclasses.replace(built, first=first))
            built = grid_surface(built.points)
        triangles = built
        faces = np.arange(3 * len(triangles), dtype=np.int64).reshape(-1, 3)
        return (Piece(item.name or f"{item.shape} {index}", triangles.reshape(-1, 3), faces),)

    def _add(self, item: GeometrySpec, pieces: tuple[Piece, ...], where: str, index: int) -> None:
        label = item.name or (f"{item.shape} {index}" if item.shape != "mesh" else Path(str(item.mesh)).stem)
        if item.name and len(pieces) == 1:
            pieces = (dataclasses.replace(pieces[0], name=item.name),)
        for piece in pieces:
            used = piece.triangles.reshape(-1, 3)
            self.parts.append(Part(piece.name, used.min(axis=0), used.max(axis=0)))
        if item.role != "solid":
            self.collision += [piece.triangles for piece in pieces]
        if item.role != "collision":
            solids, problems = make_solids(label, pieces, where, self.frame)
            self.solids += solids
            self.problems += problems
