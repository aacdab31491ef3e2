"""Closed triangle meshes of the pieces, and GLB files of them that are the same to the byte on every machine.

trimesh writes GLB too, but its bytes change with its version.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kit.pieces import STEP_RISE_M, STEP_TREAD_M, Piece

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

FLOAT32, UINT16, UINT32, TRIANGLES = 5126, 5123, 5125, 4  # glTF component types and primitive mode
VERTEX_BUFFER, INDEX_BUFFER = 34962, 34963  # glTF buffer view targets
JSON_CHUNK, BINARY_CHUNK = 0x4E4F534A, 0x004E4942


@dataclass(frozen=True)
class Mesh:
    """A named triangle mesh in level coordinates: vertices [V, 3] [m] from `origin` [3], faces [F, 3]."""

    name: str
    vertices: Floats
    faces: Ints
    origin: Floats


def _profile(piece: Piece, run: float) -> list[tuple[float, float]]:
    """The outline (way uphill, height) [m]; its first corner, low at the top end, sees all of it."""
    rise = piece.high[2] - piece.low[2]
    if piece.kind == "ramp":
        return [(run, 0), (run, rise), (0, 0)]
    if piece.kind == "stairs":
        steps = round(rise / STEP_RISE_M)
        corners = [(k * STEP_TREAD_M, (k + up) * STEP_RISE_M) for k in range(steps) for up in (0, 1)]
        return [(run, 0), (run, rise), *reversed(corners)]
    return [(run, 0), (run, rise), (0, rise), (0, 0)]


def prism(piece: Piece) -> tuple[Floats, Ints]:
    """The closed surface of `piece`: vertices [V, 3] [m], faces [F, 3] with outward normals."""
    low, high = np.array(piece.low, float), np.array(piece.high, float)
    along = 0 if piece.uphill[1] == "x" else 1
    size = high - low
    outline = np.array(_profile(piece, size[along]))
    n = len(outline)
    local = np.zeros((2 * n, 3))
    local[:, along] = np.tile(outline[:, 0] if piece.uphill[0] == "+" else size[along] - outline[:, 0], 2)
    local[n:, 1 - along] = size[1 - along]
    local[:, 2] = np.tile(outline[:, 1], 2)
    k = np.arange(1, n - 1)
    near = np.stack([np.zeros_like(k), k, k + 1], axis=1)
    a, b = np.arange(n), np.roll(np.arange(n), -1)
    around = np.concatenate([np.stack([a, n + a, b], axis=1), np.stack([b, n + a, n + b], axis=1)])
    faces = np.concatenate([near, near[:, ::-1] + n, around])
    # Mirrored outlines, and those along y, run the other way round.
    turned = (piece.uphill[0] == "+") != (along == 0)
    return local + low, faces[:, ::-1] if turned else faces


def nodes(pieces: Iterable[Piece]) -> list[Mesh]:
    """One mesh for every name, in the order in which the names come."""
    groups: dict[str, list[Piece]] = {}
    for piece in pieces:
        groups.setdefault(piece.name, []).append(piece)
    return [_merged(name, group) for name, group in groups.items()]


def _merged(name: str, pieces: Sequence[Piece]) -> Mesh:
    parts = [prism(piece) for piece in pieces]
    starts = np.cumsum([0, *(len(vertices) for vertices, _ in parts)])
    vertices = np.concatenate([vertices for vertices, _ in parts])
    faces = np.concatenate([faces + start for (_, faces), start in zip(parts, starts, strict=False)])
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    origin = np.array([*np.round((low + high)[:2] / 2), 0.0])
    return Mesh(name, vertices - origin, faces, origin)


def y_up(points: Floats) -> Floats:
    """Level coordinates (z up) [..., 3] to the file's axes (y up, z south)."""
    return np.stack([points[..., 0], points[..., 2], -points[..., 1]], axis=-1) + 0.0  # no negative zeros


def glb(meshes: Sequence[Mesh], generator: str) -> bytes:
    """A y-up binary glTF with one named node a mesh."""
    document: dict[str, Any] = {
        "asset": {"version": "2.0", "generator": generator},
        "scene": 0,
        "scenes": [{"nodes": list(range(len(meshes)))}],
        "nodes": [],
        "meshes": [],
        "accessors": [],
        "bufferViews": [],
    }
    binary = bytearray()
    for index, mesh in enumerate(meshes):
        node: dict[str, Any] = {"name": mesh.name, "mesh": index}
        if mesh.origin.any():
            node["translation"] = y_up(mesh.origin).tolist()
        document["nodes"].append(node)
        primitive = {"attributes": {"POSITION": 2 * index}, "indices": 2 * index + 1, "mode": TRIANGLES}
        document["meshes"].append({"name": mesh.name, "primitives": [primitive]})
        _append_arrays(document, binary, mesh)
    document["buffers"] = [{"byteLength": len(binary)}]
    text = json.dumps(document, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    total = 12 + 8 + len(text) + 8 + len(binary)
    header = struct.pack("<4sII", b"glTF", 2, total)
    parts = ((text, JSON_CHUNK), (bytes(binary), BINARY_CHUNK))
    return header + b"".join(struct.pack("<II", len(data), kind) + data for data, kind in parts)


def _append_arrays(document: dict[str, Any], binary: bytearray, mesh: Mesh) -> None:
    positions = y_up(mesh.vertices).astype("<f4")
    small = len(positions) <= 1 << 16
    indices = mesh.faces.astype("<u2" if small else "<u4").ravel()
    extent = {"min": positions.min(axis=0).tolist(), "max": positions.max(axis=0).tolist()}
    arrays: list[tuple[Any, int, dict[str, Any]]] = [
        (positions, VERTEX_BUFFER, {"componentType": FLOAT32, "type": "VEC3", **extent}),
        (indices, INDEX_BUFFER, {"componentType": UINT16 if small else UINT32, "type": "SCALAR"}),
    ]
    for array, target, accessor in arrays:
        data = array.tobytes()
        view = {"buffer": 0, "byteOffset": len(binary), "byteLength": len(data), "target": target}
        accessor |= {"bufferView": len(document["bufferViews"]), "count": len(array)}
        document["accessors"].append(accessor)
        document["bufferViews"].append(view)
        binary += data + b"\0" * (-len(data) % 4)
