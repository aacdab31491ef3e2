"""From `level.yaml` to a `Level`: reads everything, and reports every mistake at once."""

from __future__ import annotations

import dataclasses
import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from reachtest.errors import BadInput, Problem
from reachtest.geometry import grid_surface
from reachtest.levels.build import build_primitive
from reachtest.levels.built_navmesh import built_navmesh
from reachtest.levels.check import check_level
from reachtest.levels.document import merge, parse, read_yaml
from reachtest.levels.files import missing_files
from reachtest.levels.frames import make_frame
from reachtest.levels.meshes import MESH_READERS, degenerate, read_mesh
from reachtest.levels.names import distinct
from reachtest.levels.read_navmesh import NavMeshFile, read_navmesh
from reachtest.levels.reading import Reading, ReadLevel
from reachtest.levels.scene import Piece
from reachtest.levels.schema import GeometrySpec, LevelSpec
from reachtest.levels.solids import make_solids
from reachtest.records import (
    Bools,
    Floats,
    Frame,
    GateSettings,
    HeightField,
    Level,
    NavMesh,
    Part,
    Required,
    Solid,
    Spawn,
    Zone,
)

KILL_BELOW_M = 10.0  # deep enough that no pit inside the geometry is a fall
BOUNDS_MARGIN_M = (
    50.0  # farther than any character jumps off the geometry's edge before it falls below kill_z
)


def load_level(path: Path, overrides: Mapping[str, Any] | None = None) -> Level:
    """Read a level file and everything it names.

    `overrides` are values from the command line, section by section as in the file; they win over it.
    Raises BadInput with all problems found: in the schema, the files, the geometry, and its plausibility.
    """
    path = Path(path)
    given = overrides or {}
    document = merge(read_yaml(path), given)
    spec, problems = parse(document, path.name, given)
    if spec is None:
        raise BadInput(problems + list(missing_files(document, path)), path)
    builder = _Builder(spec, path)
    builder.read()
    if builder.collision_known:
        level = builder.level()
        builder.problems += check_level(level).problems
    if builder.problems or not builder.collision_known:
        raise BadInput(builder.problems, path)
    return level


@dataclass
class _Builder:
    """Collects a level piece by piece, and the problems on the way."""

    spec: LevelSpec
    path: Path

    def __post_init__(self) -> None:
        self.folder = self.path.parent
        self.frame = make_frame(self.spec.frame.up_axis, self.spec.frame.units)
        self.problems: list[Problem] = []
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

    def level(self) -> ReadLevel:
        """The level, as far as it could be read."""
        spec = self.spec
        collision = np.concatenate(self.collision)
        thin = degenerate(collision)
        collision = collision[~thin]
        low, high = collision.min(axis=(0, 1)), collision.max(axis=(0, 1))
        kill_z = spec.kill_z_m if spec.kill_z_m is not None else float(low[2]) - KILL_BELOW_M
        navmesh, thin_nav = self._built(collision) if spec.navmesh.build else self._navmesh()
        return ReadLevel(
            name=spec.name or self.path.resolve().parent.name or "level",
            file=self.path,
            sha256=self._digest(),
            frame=self.frame,
            collision=collision,
            solids=distinct(self.solids),
            parts=tuple(self.parts),
            navmesh=navmesh,
            character=spec.character.character(),
            spawns=tuple(
                Spawn(spawn.name or f"spawn {index}", self._point(spawn.position))
                for index, spawn in enumerate(spec.spawns)
            ),
            kill_z_m=kill_z,
            bounds=self._bounds(low, high, kill_z),
            zones=distinct(
                [Zone(zone.name, zone.kind, *zone.box.level_box(self.frame)) for zone in spec.zones]
            ),
            required=distinct(
                [Required(place.name, self._point(place.position), place.within_m) for place in spec.required]
            ),
            explore=spec.explore.settings(),
            gate=GateSettings(**spec.gate.model_dump()),
            height_fields=_moved_up(self.height_fields, thin),
            reading=Reading(int(thin.sum()), thin_nav, self._navmesh_frame(), spec.navmesh.scale),
        )

    def _digest(self) -> str:
        """Of the level itself: how long it is explored and what fails a build may change, the level is the same."""
        said = self.spec.model_dump(mode="json", exclude={"explore", "gate"}, exclude_unset=True)
        digest = hashlib.sha256(json.dumps(said, sort_keys=True).encode())
        for content in self.contents:
            digest.update(content)
        return digest.hexdigest()

    def _point(self, position: Sequence[float]) -> Floats:
        return self.frame.to_level(np.array(position))

    def _navmesh_frame(self) -> Frame:
        return self.navmesh.mesh.frame if self.navmesh else self.frame

    def _navmesh(self) -> tuple[NavMesh, int]:
        """The nav-mesh without degenerate triangles, and their number; empty if it could not be read."""
        if self.navmesh is None:
            return NavMesh(str(self.spec.navmesh.mesh), np.zeros((0, 3)), np.zeros((0, 3), np.int64)), 0
        return self.navmesh.navmesh, self.navmesh.degenerate

    def _built(self, collision: Floats) -> tuple[NavMesh, int]:
        """A nav-mesh built from the collision triangles; empty if the input is wrong anyway."""
        if self.problems or not self.spec.navmesh.build:
            return NavMesh("", np.zeros((0, 3)), np.zeros((0, 3), np.int64)), 0
        where = f"{self.path.name}: navmesh.build"
        navmesh, problems = built_navmesh(
            self.spec.navmesh.build, self.spec.character.character(), collision, where
        )
        self.problems += problems
        return navmesh, 0

    def _bounds(self, low: Floats, high: Floats, kill_z: float) -> tuple[Floats, Floats]:
        if self.spec.bounds_m:
            return np.array(self.spec.bounds_m.low), np.array(self.spec.bounds_m.high)
        margin = np.full(3, BOUNDS_MARGIN_M)
        return np.append((low - margin)[:2], kill_z), high + margin


def _moved_up(fields: Sequence[HeightField], thin: Bools) -> tuple[HeightField, ...]:
    """The height fields in a collision without its `thin` [F] triangles; one that loses some is none any more."""
    return tuple(dataclasses.replace(field, first=int((~thin[: field.first]).sum())) for field in fields)
