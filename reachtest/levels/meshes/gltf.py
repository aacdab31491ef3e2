"""glTF and GLB: what trimesh would load wrongly without an error is refused from the JSON first."""

from __future__ import annotations

import json
import struct
from base64 import b64decode
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import unquote

from reachtest.levels.meshes.gltf_layout import FAN, Buffer, Document, Primitive, mistakes, parse
from reachtest.levels.meshes.scene import NavFile, Piece, Unreadable, read_scene, several

_UNCOMPRESSED = "export without compression, or run `gltf-transform cp` on it, which decompresses"
GEOMETRY_EXTENSIONS = {
    "KHR_draco_mesh_compression": _UNCOMPRESSED,
    "EXT_meshopt_compression": _UNCOMPRESSED,
    "KHR_meshopt_compression": _UNCOMPRESSED,
    "EXT_mesh_gpu_instancing": "run `gltf-transform uninstance` on it, which makes nodes of the instances",
}
"""Extensions that hold geometry where the reader does not look, with the remedy."""

_AGAIN = "the file is damaged or cut off: export it again"


def read_glb(data: bytes, path: Path) -> list[Piece]:
    """The nodes of a binary glTF file."""
    text, body = _chunks(data)
    tree = _json_object(text, start=20)
    text = _for_trimesh(tree, _checked(tree, path, body))
    chunks = struct.pack("<I4s", len(text), b"JSON") + text
    if body is not None:
        chunks += struct.pack("<I4s", len(body), b"BIN\0") + body
    head = struct.pack("<4sII", b"glTF", 2, 12 + len(chunks))
    return read_scene(head + chunks, path, "glb", skip_materials=True)


def read_gltf(data: bytes, path: Path) -> list[Piece]:
    """The nodes of a glTF file, with the buffer files it names."""
    tree = _json_object(data)
    return read_scene(_for_trimesh(tree, _checked(tree, path)), path, "gltf", skip_materials=True)


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


def external_files(data: bytes, path: Path) -> list[Path]:
    """The buffer files that a glTF file names, in order."""
    tree = _json_object(_chunks(data)[0]) if is_glb(data) else _json_object(data)
    uris = (str(buffer.get("uri", "data:")) for buffer in tree.get("buffers", []))
    return [_beside(path, uri) for uri in uris if not uri.startswith("data:")]


def _beside(path: Path, uri: str) -> Path:
    return path.parent / unquote(uri)


def _chunks(data: bytes) -> tuple[bytes, bytes | None]:
    """The JSON of a GLB and its binary chunk: 12 bytes of header, then length, type and content of each."""
    if not is_glb(data) or len(data) < 20:
        raise Unreadable("does not start as a GLB file does", "export it as binary glTF")
    version, total = struct.unpack_from("<4xII", data)
    if version != 2:
        raise Unreadable(f"is glTF version {version} at byte 4", "export it as glTF 2.0")
    if len(data) < total:
        found = f"is cut off: it has {len(data)} of the {total} bytes that its header states"
        raise Unreadable(found, "export or copy it again")
    found_chunks: dict[bytes, bytes] = {}
    at = 12
    while at + 8 <= total:
        length, kind = struct.unpack_from("<I4s", data, at)
        if length > total - at - 8:
            found = f"has a chunk of {length:,} bytes at byte {at}, where {total - at - 8:,} bytes are left"
            raise Unreadable(found, _AGAIN)
        if at == 12 and kind != b"JSON":
            raise Unreadable(f"has a first chunk of type {kind!r} at byte 16, not b'JSON'", _AGAIN)
        found_chunks.setdefault(kind, data[at + 8 : at + 8 + length])
        at += 8 + length
    return found_chunks.get(b"JSON", b""), found_chunks.get(b"BIN\0")


def _json_object(text: bytes, start: int = 0) -> dict[str, Any]:
    """The JSON that lies from byte `start` of a file."""
    try:
        tree = json.loads(text)
    except json.JSONDecodeError as error:
        at = start + len(error.doc[: error.pos].encode())
        raise Unreadable(
            f"holds JSON that breaks off or goes wrong at byte {at}: {error.msg}", _AGAIN
        ) from error
    except UnicodeDecodeError as error:
        raise Unreadable(f"holds JSON that is no text at byte {start + error.start}", _AGAIN) from error
    except (RecursionError, ValueError) as error:
        raise Unreadable(f"holds JSON that cannot be meant: {error}", _AGAIN) from error
    if not isinstance(tree, dict):
        raise Unreadable("does not hold a glTF document", "export it again")
    return tree


def _checked(tree: dict[str, Any], path: Path, body: bytes | None = None) -> Document:
    """What the document says. Raises Unreadable for what trimesh would misread or fail at."""
    document, wrong = parse(tree)
    if document is None:
        raise Unreadable(f"is no valid glTF: {several(wrong)}", _AGAIN)
    if unread := list(_not_read(document, path)):
        found, remedies = zip(*unread, strict=True)
        raise Unreadable(several(found), "; ".join(dict.fromkeys(remedies)))
    sizes = [_size(index, buffer, path, body) for index, buffer in enumerate(document.buffers)]
    if wrong := mistakes(document, sizes):
        raise Unreadable(f"is no valid glTF: {several(wrong)}", _AGAIN)
    return document


def _not_read(document: Document, path: Path) -> Iterator[tuple[str, str]]:
    """What is found that cannot be read, with the remedy."""
    for extension, remedy in GEOMETRY_EXTENSIONS.items():
        if extension in {*document.extensionsUsed, *document.extensionsRequired}:
            yield f"uses {extension}, which is not read", remedy
    if any(primitive.mode == FAN for _, primitive in document.triangles()):
        yield "holds triangle fans, which are not read", "export triangles"
    used = document.used().values()
    if any(accessor.normalized for accessor in used):
        remedy = "export without quantisation, or run `gltf-transform dequantize` on it"
        yield "holds quantised positions, which are not read", remedy
    if any(accessor.sparse is not None for accessor in used):
        yield "holds sparse positions, which are not read", "export without sparse accessors"
    for buffer in document.buffers:
        if buffer.uri is not None and not buffer.uri.startswith("data:"):
            file = _beside(path, buffer.uri)
            if not file.is_file():
                yield f"names the buffer {file.name}, which does not exist", "copy it next to the file"


def _size(index: int, buffer: Buffer, path: Path, body: bytes | None) -> int:
    """How many bytes there are of a buffer."""
    if buffer.uri is None:
        return len(body or b"") if index == 0 else 0
    if not buffer.uri.startswith("data:"):
        return _beside(path, buffer.uri).stat().st_size
    _, base64, text = buffer.uri.partition("base64,")
    try:
        return len(b64decode(text, validate=True)) if base64 else 0
    except ValueError as error:
        raise Unreadable(f"has buffers[{index}] in base64 that is damaged: {error}", _AGAIN) from error


def _for_trimesh(tree: dict[str, Any], document: Document) -> bytes:
    """The JSON with the triangles and nothing that trimesh stumbles over, padded to 4 bytes."""
    used = document.used()
    views = {accessor.bufferView for accessor in used.values()}
    for index, _ in enumerate(document.accessors):
        if index not in used:  # it would make an array of each, read or not
            tree["accessors"][index] = {"componentType": 5121, "count": 0, "type": "SCALAR"}
    for index, _ in enumerate(document.bufferViews):
        if index not in views:
            tree["bufferViews"][index] = {"buffer": 0, "byteLength": 0}
    for mesh, said in zip(tree.get("meshes", []), document.meshes, strict=True):
        mesh["primitives"] = [_bare(primitive) for primitive in said.primitives if primitive.has_triangles]
    for buffer in tree.get("buffers", []):
        if "uri" in buffer and not buffer["uri"].startswith("data:"):
            buffer["uri"] = unquote(buffer["uri"])  # it looks for a file named "my%20level.bin"
    for node in tree.get("nodes", []):
        node.pop("camera", None)  # it leaves out the first camera's node, and so the place of its children
    text = json.dumps(tree).encode()
    return text + b" " * (-len(text) % 4)


def _bare(primitive: Primitive) -> dict[str, Any]:
    bare = {"attributes": {"POSITION": primitive.attributes["POSITION"]}, "mode": primitive.mode}
    return bare if primitive.indices is None else {**bare, "indices": primitive.indices}
