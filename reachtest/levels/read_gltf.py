"""glTF and GLB: what trimesh would load wrongly without an error is refused from the JSON first."""

from __future__ import annotations

import json
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import unquote

from reachtest.levels.scene import NavFile, Piece, Unreadable, read_scene

_UNCOMPRESSED = "export without compression, or run `gltf-transform cp` on it, which decompresses"
GEOMETRY_EXTENSIONS = {
    "KHR_draco_mesh_compression": _UNCOMPRESSED,
    "EXT_meshopt_compression": _UNCOMPRESSED,
    "KHR_meshopt_compression": _UNCOMPRESSED,
    "EXT_mesh_gpu_instancing": "run `gltf-transform uninstance` on it, which makes nodes of the instances",
}
"""Extensions that hold geometry where the reader does not look, with the remedy."""

_LINES_AND_POINTS, _FAN = (0, 1, 2, 3), 6  # glTF 2.0: mesh.primitive.mode


def read_glb(data: bytes, path: Path) -> list[Piece]:
    """The nodes of a binary glTF file."""
    tree = _json_chunk(data)
    _check(tree, path)
    text = _for_trimesh(tree)
    rest = data[20 + struct.unpack_from("<I", data, 12)[0] :]
    head = struct.pack("<4sIII4s", b"glTF", 2, 20 + len(text) + len(rest), len(text), b"JSON")
    return read_scene(head + text + rest, path, "glb", skip_materials=True)


def read_gltf(data: bytes, path: Path) -> list[Piece]:
    """The nodes of a glTF file, with the buffer files it names."""
    tree = _json_object(data)
    _check(tree, path)
    return read_scene(_for_trimesh(tree), path, "gltf", skip_materials=True)


def is_glb(data: bytes) -> bool:
    """Whether a file is binary glTF."""
    return data[:4] == b"glTF"


def is_gltf(data: bytes) -> bool:
    """Whether a file is glTF in text."""
    return data[:64].lstrip(b"\xef\xbb\xbf \t\r\n")[:1] == b"{" and b'"asset"' in data


def read_glb_navmesh(data: bytes, path: Path) -> NavFile:
    """The nodes of a binary glTF file."""
    return NavFile(read_glb(data, path), "glTF, binary")


def read_gltf_navmesh(data: bytes, path: Path) -> NavFile:
    """The nodes of a glTF file."""
    return NavFile(read_gltf(data, path), "glTF")


def _for_trimesh(tree: dict[str, Any]) -> bytes:
    """The JSON without what trimesh stumbles over, padded to 4 bytes."""
    for buffer in tree.get("buffers", []):
        if "uri" in buffer and not buffer["uri"].startswith("data:"):
            buffer["uri"] = unquote(buffer["uri"])  # it looks for a file named "my%20level.bin"
    for node in tree.get("nodes", []):
        node.pop("camera", None)  # it leaves out the first camera's node, and so the place of its children
    text = json.dumps(tree).encode()
    return text + b" " * (-len(text) % 4)


def external_files(data: bytes, path: Path) -> list[Path]:
    """The buffer files that a glTF file names, in order."""
    tree = _json_chunk(data) if data[:4] == b"glTF" else _json_object(data)
    uris = (str(buffer.get("uri", "data:")) for buffer in tree.get("buffers", []))
    return [path.parent / unquote(uri) for uri in uris if not uri.startswith("data:")]


def _json_chunk(data: bytes) -> dict[str, Any]:
    """The JSON of a GLB: 12 bytes of header, then length, type and text of the first chunk."""
    if data[:4] != b"glTF" or len(data) < 20:
        raise Unreadable("does not start as a GLB file does", "export it as binary glTF")
    total, length = struct.unpack_from("<8xII", data)
    if len(data) < total:
        found = f"is cut off: it has {len(data)} of the {total} bytes that its header states"
        raise Unreadable(found, "export or copy it again")
    return _json_object(data[20 : 20 + length])


def _json_object(text: bytes) -> dict[str, Any]:
    tree = json.loads(text)
    if not isinstance(tree, dict):
        raise Unreadable("does not hold a glTF document", "export it again")
    return tree


def _check(tree: dict[str, Any], path: Path) -> None:
    used = {*tree.get("extensionsUsed", []), *tree.get("extensionsRequired", [])}
    for extension, remedy in GEOMETRY_EXTENSIONS.items():
        if extension in used:
            raise Unreadable(f"uses {extension}, which is not read", remedy)
    for file in external_files(json.dumps(tree).encode(), path):
        if not file.is_file():
            raise Unreadable(
                f"names the buffer {file.name}, which does not exist", "copy it next to the file"
            )
    for accessor, mode in _positions(tree):
        if mode == _FAN:
            raise Unreadable("holds triangle fans, which are not read", "export triangles")
        if accessor.get("normalized") or "sparse" in accessor:
            kind = "quantised" if accessor.get("normalized") else "sparse"
            remedy = "export without quantisation, or run `gltf-transform dequantize` on it"
            raise Unreadable(f"holds {kind} positions, which are not read", remedy)


def _positions(tree: dict[str, Any]) -> Iterator[tuple[dict[str, Any], int]]:
    """The position accessor and the mode of every primitive that has triangles."""
    for mesh in tree.get("meshes", []):
        for primitive in mesh.get("primitives", []):
            mode, index = primitive.get("mode", 4), primitive.get("attributes", {}).get("POSITION")
            if mode not in _LINES_AND_POINTS and index is not None:
                yield tree["accessors"][index], mode
