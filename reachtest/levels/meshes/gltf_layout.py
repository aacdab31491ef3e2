"""What a glTF document must say for its triangles to be read: checked before any array is made.

The names are the standard's: glTF 2.0, chapter 5. Unknown keys are none of our business.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from reachtest.levels.fields import dotted, show

TRIANGLES, STRIP, FAN = 4, 5, 6  # mesh.primitive.mode
_BYTES = {5120: 1, 5121: 1, 5122: 2, 5123: 2, 5125: 4, 5126: 4}  # by accessor.componentType
_NUMBERS = {
    "SCALAR": 1,
    "VEC2": 2,
    "VEC3": 3,
    "VEC4": 4,
    "MAT2": 4,
    "MAT3": 9,
    "MAT4": 16,
}  # by accessor.type

Index = Annotated[int, Field(ge=0)]


def _numbers(count: int) -> Any:
    return Field(default=None, min_length=count, max_length=count)


class _Part(BaseModel):
    model_config = ConfigDict(strict=True, frozen=True, allow_inf_nan=False)


class Accessor(_Part):
    """An array, as it lies in a view."""

    bufferView: Index | None = None
    byteOffset: Index = 0
    componentType: Literal[5120, 5121, 5122, 5123, 5125, 5126]
    count: Index
    type: Literal["SCALAR", "VEC2", "VEC3", "VEC4", "MAT2", "MAT3", "MAT4"]
    normalized: bool = False
    sparse: Any = None


class View(_Part):
    """A part of a buffer."""

    buffer: Index
    byteOffset: Index = 0
    byteLength: Index
    byteStride: Annotated[int, Field(ge=4, le=252)] | None = None


class Buffer(_Part):
    """Bytes: in a GLB's second chunk, in the document, or in a file."""

    byteLength: Index
    uri: str | None = None


class Primitive(_Part):
    """Triangles, lines or points."""

    attributes: dict[str, Index] = {}
    indices: Index | None = None
    mode: Annotated[int, Field(ge=0, le=6)] = TRIANGLES

    @property
    def has_triangles(self) -> bool:
        """Whether there is anything to read in it."""
        return self.mode in (TRIANGLES, STRIP, FAN) and "POSITION" in self.attributes

    @property
    def arrays(self) -> dict[str, int]:
        """The accessors that are read, by what they hold."""
        own = {"POSITION": self.attributes["POSITION"]}
        return own if self.indices is None else {**own, "indices": self.indices}


class Mesh(_Part):
    """What a node shows."""

    name: str = ""
    primitives: list[Primitive]


class Node(_Part):
    """A place in the scene."""

    name: str = ""
    mesh: Index | None = None
    children: list[Index] = []
    matrix: list[float] | None = _numbers(16)
    translation: list[float] | None = _numbers(3)
    rotation: list[float] | None = _numbers(4)
    scale: list[float] | None = _numbers(3)


class Scene(_Part):
    """The nodes at the top."""

    nodes: list[Index] = []


class Document(_Part):
    """The whole of it."""

    scene: Index = 0
    scenes: list[Scene] = []
    nodes: list[Node] = []
    meshes: list[Mesh] = []
    accessors: list[Accessor] = []
    bufferViews: list[View] = []
    buffers: list[Buffer] = []
    extensionsUsed: list[str] = []
    extensionsRequired: list[str] = []

    def triangles(self) -> Iterator[tuple[str, Primitive]]:
        """Every primitive that has triangles, with where it stands."""
        for number, mesh in enumerate(self.meshes):
            for place, primitive in enumerate(mesh.primitives):
                if primitive.has_triangles:
                    yield f"meshes[{number}].primitives[{place}]", primitive

    def used(self) -> dict[int, Accessor]:
        """The accessors that are read, by index; only those that exist."""
        named = {index for _, primitive in self.triangles() for index in primitive.arrays.values()}
        return {index: self.accessors[index] for index in sorted(named) if index < len(self.accessors)}


def parse(tree: Any) -> tuple[Document | None, list[str]]:
    """The document, or everything that is wrong with its keys and values."""
    try:
        return Document.model_validate(tree), []
    except ValidationError as error:
        return None, [_words(each) for each in error.errors(include_url=False)]


def _words(details: Any) -> str:
    where = dotted(details["loc"]) or "the document"
    if details["type"] == "missing":
        return f"{where} is missing"
    return f"{where} is {show(details['input'])}: {details['msg'].replace('Input should', 'it must', 1)}"


def mistakes(document: Document, sizes: Sequence[int]) -> list[str]:
    """What points nowhere in a document whose buffers have these `sizes` [bytes], with the numbers."""
    found = list(_dangling(document))
    for where, primitive in document.triangles():
        counts = [
            document.accessors[i].count for i in primitive.arrays.values() if i < len(document.accessors)
        ]
        if primitive.mode == TRIANGLES and counts and counts[-1] % 3:
            found.append(f"{where} has {counts[-1]:,} corners, which make no whole triangles")
    for index, accessor in document.used().items():
        if accessor.bufferView is None:
            found.append(f"accessors[{index}] has no bufferView for its count of {accessor.count:,}")
        elif accessor.bufferView < len(document.bufferViews):
            found += _too_long(document, index, accessor, sizes)
    return found


def _dangling(document: Document) -> Iterator[str]:
    """References to what does not exist."""
    named = [(f"scenes[{i}]", n, "nodes") for i, scene in enumerate(document.scenes) for n in scene.nodes]
    for i, node in enumerate(document.nodes):
        named += [(f"nodes[{i}]", child, "nodes") for child in node.children]
        named += [(f"nodes[{i}]", node.mesh, "meshes")] if node.mesh is not None else []
    for where, primitive in document.triangles():
        named += [(f"{where}.{key}", n, "accessors") for key, n in primitive.arrays.items()]
    for i, accessor in document.used().items():
        if accessor.bufferView is not None:
            named.append((f"accessors[{i}]", accessor.bufferView, "bufferViews"))
    if document.scenes:
        named.append(("scene", document.scene, "scenes"))
    for where, index, what in named:
        if index >= (count := len(getattr(document, what))):
            yield f"{where} names {what}[{index}], and there are {count}"


def _too_long(document: Document, index: int, accessor: Accessor, sizes: Sequence[int]) -> Iterator[str]:
    """An accessor that goes beyond its view, and a view that goes beyond its buffer."""
    number = accessor.bufferView or 0
    view = document.bufferViews[number]
    item = _BYTES[accessor.componentType] * _NUMBERS[accessor.type]
    stride = view.byteStride or item
    need = accessor.byteOffset + (accessor.count - 1) * stride + item if accessor.count else 0
    if stride < item:
        yield f"bufferViews[{number}] has byteStride {stride}, less than the {item} bytes of an item"
    if need > view.byteLength:
        found = f"accessors[{index}] needs {need:,} bytes for its count of {accessor.count:,}"
        yield f"{found}, and bufferViews[{number}] has {view.byteLength:,}"
    end = view.byteOffset + view.byteLength
    if view.buffer >= len(sizes):
        yield f"bufferViews[{number}] names buffers[{view.buffer}], and there are {len(sizes)}"
    elif end > sizes[view.buffer]:
        yield f"bufferViews[{number}] ends at byte {end:,} of buffers[{view.buffer}], which has {sizes[view.buffer]:,}"
