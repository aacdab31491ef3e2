"""A small correct level, and ways to spoil it."""

from __future__ import annotations

import json
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from reachtest.errors import BadInput
from reachtest.levels import load_level

NAV_OBJ = "o nav\nv -9 -9 0\nv 9 -9 0\nv 9 9 0\nv -9 9 0\nf 1 2 3\nf 1 3 4\n"
QUAD = np.array([[-10, -10, 0], [10, -10, 0], [10, 10, 0], [-10, 10, 0]], dtype=np.float32)
QUAD_FACES = np.array([[0, 1, 2], [0, 2, 3]], dtype=np.uint32)

WriteLevel = Callable[..., Path]


def document() -> dict[str, Any]:
    """A floor of 20 m x 20 m with its top at z = 0, z up, metres."""
    return {
        "version": 1,
        "geometry": [{"name": "floor", "box": {"center": [0, 0, -0.5], "size": [20, 20, 1]}}],
        "navmesh": {"mesh": "nav.obj"},
        "character": "unreal",
        "spawns": [[0, 0, 0]],
    }


def write_small(folder: Path, **changes: Any) -> Path:
    """Write the small level into `folder` with top-level keys changed, and return its path."""
    folder.mkdir(exist_ok=True)
    if not (folder / "nav.obj").exists():
        (folder / "nav.obj").write_text(NAV_OBJ)
    path = folder / "level.yaml"
    path.write_text(yaml.safe_dump({**document(), **changes}))
    return path


def problems_of(path: Path, overrides: dict[str, Any] | None = None) -> list[tuple[str, str, str]]:
    """What is wrong with a level, as (where, found, remedy)."""
    with pytest.raises(BadInput) as raised:
        load_level(path, overrides)
    assert raised.value.exit_status == 2
    return [(problem.where, problem.found, problem.remedy) for problem in raised.value.problems]


def only_problem(path: Path, overrides: dict[str, Any] | None = None) -> tuple[str, str, str]:
    """The one thing that is wrong with a level."""
    problems = problems_of(path, overrides)
    assert len(problems) == 1, problems
    return problems[0]


def gltf_tree(**changes: Any) -> dict[str, Any]:
    """The JSON of a one-quad glTF whose buffer holds vertices and indices."""
    return {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"name": "ground", "mesh": 0}],
        "meshes": [{"name": "quad", "primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {
                "bufferView": 0,
                "componentType": 5126,
                "count": 4,
                "type": "VEC3",
                "min": [-10] * 3,
                "max": [10] * 3,
            },
            {"bufferView": 1, "componentType": 5125, "count": 6, "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": 48},
            {"buffer": 0, "byteOffset": 48, "byteLength": 24},
        ],
        "buffers": [{"byteLength": 72}],
        **changes,
    }


def glb(tree: dict[str, Any] | None = None, vertices: Any = QUAD, faces: Any = QUAD_FACES) -> bytes:
    """A GLB file of `tree` with the arrays as its buffer."""
    text = json.dumps(tree or gltf_tree()).encode()
    text += b" " * (-len(text) % 4)
    body = np.asarray(vertices, np.float32).tobytes() + np.asarray(faces, np.uint32).tobytes()
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(body), b"BIN\0") + body
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks
