"""What every mesh reader gives back, and how trimesh's scenes become it: raw vertices, nothing merged."""

from __future__ import annotations

import io
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from reachtest.records import Floats, Ints


@dataclass(frozen=True)
class Piece:
    """One node of a scene."""

    name: str
    vertices: Floats  # [V, 3]
    faces: Ints  # [F, 3]

    @property
    def triangles(self) -> Floats:
        """Corner positions [F, 3, 3]."""
        return self.vertices[self.faces]


class Unreadable(Exception):
    """A mesh file cannot be used: what was found, and the remedy."""

    def __init__(self, found: str, remedy: str) -> None:
        self.found, self.remedy = found, remedy
        super().__init__(found)


def read_scene(data: bytes, path: Path, file_type: str, **options: Any) -> list[Piece]:
    """Every node with triangles that trimesh finds, with the nodes' transforms applied."""
    import trimesh

    with warnings.catch_warnings():
        # numpy stops at the first word that is no number and merely warns: half a mesh would pass.
        warnings.filterwarnings("error", message=".*could not be read to its end.*")
        scene = trimesh.load_scene(
            io.BytesIO(data),
            file_type=file_type,
            resolver=trimesh.resolvers.FilePathResolver(str(path)),
            process=False,
            **options,
        )
    return list(_pieces(scene))


def _pieces(scene: Any) -> Iterator[Piece]:
    for node in sorted(scene.graph.nodes_geometry):
        matrix, geometry = scene.graph[node]
        mesh = scene.geometry[geometry]
        faces = np.asarray(getattr(mesh, "faces", np.zeros((0, 3))), dtype=np.int64)
        if not len(faces):
            continue  # points and lines
        if np.linalg.det(matrix[:3, :3]) < 0:
            faces = faces[:, ::-1]  # a mirrored node turns its faces inside out
        vertices = np.asarray(mesh.vertices, dtype=np.float64) @ matrix[:3, :3].T + matrix[:3, 3]
        yield Piece(str(node), vertices, faces)
