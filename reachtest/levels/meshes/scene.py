"""What every mesh reader gives back, and how trimesh's scenes become it: raw vertices, nothing merged."""

from __future__ import annotations

import io
import warnings
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, field
from operator import itemgetter
from pathlib import Path
from typing import Any

import numpy as np

from reachtest.records import Floats, Ints, NavAgent, NavLink

MOST_SHOWN = 5  # mistakes of one file: a damaged one has thousands


@dataclass(frozen=True)
class Piece:
    """One node of a scene."""

    name: str
    vertices: Floats  # [V, 3]
    faces: Ints  # [F, 3]
    areas: Ints | None = None  # [F] area types, of a nav-mesh that has some

    @property
    def triangles(self) -> Floats:
        """Corner positions [F, 3, 3]."""
        return self.vertices[self.faces]


@dataclass(frozen=True)
class NavFile:
    """What a nav-mesh file says, in its own axes and units."""

    pieces: list[Piece]
    format: str  # for people
    polygons: int | None = None  # of all pieces; None: the format has triangles only
    agent: NavAgent = field(default_factory=NavAgent)
    links: tuple[NavLink, ...] = ()


class Unreadable(Exception):
    """A mesh file cannot be used: what was found, and the remedy."""

    def __init__(self, found: str, remedy: str) -> None:
        self.found, self.remedy = found, remedy
        super().__init__(found)


def several(mistakes: Sequence[str], count: int | None = None) -> str:
    """All mistakes of a file in one sentence, or the first few of `count` and how many more there are."""
    more = (len(mistakes) if count is None else count) - MOST_SHOWN
    return "; ".join(mistakes[:MOST_SHOWN]) + (f"; and {more:,} more" if more > 0 else "")


def read_scene(data: bytes, path: Path, file_type: str, **options: Any) -> list[Piece]:
    """Every node with triangles that trimesh finds, with the nodes' transforms applied."""
    import trimesh

    with (
        warnings.catch_warnings(),
        np.errstate(all="ignore"),
    ):  # infinite vertices are reported later, by number
        # numpy stops at the first word that is no number and merely warns: half a mesh would pass.
        warnings.filterwarnings("error", message=".*could not be read to its end.*")
        scene = trimesh.load_scene(
            io.BytesIO(data),
            file_type=file_type,
            resolver=trimesh.resolvers.FilePathResolver(str(path)),
            process=False,
            **options,
        )
    return _pieces(scene)


def _pieces(scene: Any) -> list[Piece]:
    """One piece for every node, in order of names: the same file gives the same pieces in order."""
    order = {geometry: index for index, geometry in enumerate(scene.geometry)}
    found = defaultdict(list)
    for node in scene.graph.nodes_geometry:
        matrix, geometry = scene.graph[node]
        mesh = scene.geometry[geometry]
        # Where a node has several primitives, trimesh puts each into a child node with a random name.
        split = mesh.metadata.get("from_gltf_primitive")
        name = scene.graph.transforms.parents[node] if split else node
        found[str(name)].append((order[geometry], _placed(mesh, matrix)))
    parts = {
        name: [part for _, part in sorted(each, key=itemgetter(0))] for name, each in sorted(found.items())
    }
    pieces = (_joined(name, each) for name, each in parts.items())
    return [piece for piece in pieces if len(piece.faces)]  # not points and lines


def _placed(mesh: Any, matrix: Floats) -> tuple[Floats, Ints]:
    faces = np.asarray(getattr(mesh, "faces", np.zeros((0, 3))), dtype=np.int64)
    if np.linalg.det(matrix[:3, :3]) < 0:
        faces = faces[:, ::-1]  # a mirrored node turns its faces inside out
    with np.errstate(invalid="ignore", over="ignore"):  # likewise
        return np.asarray(mesh.vertices, dtype=np.float64) @ matrix[:3, :3].T + matrix[:3, 3], faces


def _joined(name: str, parts: list[tuple[Floats, Ints]]) -> Piece:
    starts = np.cumsum([0, *(len(vertices) for vertices, _ in parts)])
    faces = [faces + start for (_, faces), start in zip(parts, starts, strict=False)]
    return Piece(name, np.concatenate([vertices for vertices, _ in parts]), np.concatenate(faces))
