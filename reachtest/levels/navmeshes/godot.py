"""Nav-meshes of Godot 3 and 4: the NavigationMesh resources of `.tres` files and of scenes (`.tscn`).

Shape legend: V vertices, F triangles.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import numpy as np

from reachtest.levels.fields import FARTHEST
from reachtest.levels.meshes.scene import NavFile, Piece, Unreadable
from reachtest.levels.navmeshes.godot_text import (
    TextSection,
    decode,
    masked_text,
    parse_numbers,
    read_numbers,
    refuse_at,
    sections_of,
)
from reachtest.records import Floats, Ints, NavAgent

_NO_MESH = (
    "bake the nav-mesh in Godot and save it; where a scene keeps it in a file of its own, name that file"
)

_VERTICES = re.compile(r"^vertices\s*=\s*", re.MULTILINE)
_POLYGONS = re.compile(r"^polygons\s*=\s*", re.MULTILINE)
_TRANSFORM = re.compile(r"^transform\s*=\s*", re.MULTILINE)
_MESH_OF_REGION = re.compile(r"^(?:navigation_mesh|navmesh)\s*=\s*SubResource\(", re.MULTILINE)
_POINTS = re.compile(r"(?:Packed|Pool)Vector3Array\s*\(([^()]*)\)")
_PLACEMENT = re.compile(r"Transform(?:3D)?\s*\(([^()]*)\)")
_LIST = re.compile(r"(?:Array\[\w+\]\s*\(\s*)?\[\s*")
_CORNERS = re.compile(r"(?:PackedInt32|PoolInt)Array\s*\(([^()]*)\)\s*")
_SEPARATOR = re.compile(r",\s*")


_AGENT = {"radius": 0.5, "height": 1.5, "max_climb": 0.25, "max_slope": 45.0}
"""What Godot 4 does not write because it is its default; Godot 3 had others from release to release."""


def is_godot(data: bytes) -> bool:
    """Whether a file is a scene or a resource in Godot's text format."""
    return (
        re.match(rb"(?:\xef\xbb\xbf)?\s*(?:;[^\n]*\n\s*)*\[gd_(?:scene|resource)\b", data[:4096]) is not None
    )


def read_godot(data: bytes, path: Path) -> NavFile:
    """One piece for every region of a scene, or for every mesh no region of the file has. Raises Unreadable.

    Regions are placed by the transforms of their node and its parents. y up, as the file has it.
    """
    text = decode(data)
    masked = masked_text(text)
    sections = list(sections_of(text, masked))
    resources = dict(_resources(sections))
    meshes = {key: mesh for key, at in resources.items() if (mesh := _mesh(masked, at))}
    places = _placements(text, masked, sections)
    pieces, polygons = [], 0
    for key, (vertices, faces, count) in meshes.items():
        for name, matrix in places.get(key) or [(path.stem, np.eye(4))]:
            pieces.append(Piece(name, vertices @ matrix[:3, :3].T + matrix[:3, 3], faces))
            polygons += count
    if not pieces:
        lines = [str(text.count("\n", 0, at.start) + 1) for at in resources.values()]
        empty = f", those in line {', '.join(lines[:8])} are empty" if lines else ""
        raise Unreadable(f"holds no triangles: no baked NavigationMesh{empty}", _NO_MESH)
    packed = "Packed" in masked  # Godot 3 calls its arrays Pool...
    agent = _agent(masked, resources[next(iter(meshes))], packed)
    return NavFile(pieces, f"Godot {4 if packed else 3}", polygons, agent)


def _agent(text: str, section: TextSection, defaults: bool) -> NavAgent:
    """The agent that one resource was baked for."""
    numbers: dict[str, float | None] = dict(_AGENT) if defaults else dict.fromkeys(_AGENT)
    for key in numbers:
        line = re.compile(rf"^agent[_/]{key}\s*=\s*([^\n]*)", re.MULTILINE)
        if match := line.search(text, section.start, section.end):
            try:
                number = float(match[1])
            except ValueError:
                refuse_at(text, match.start(1), f"has an agent_{key} of {match[1][:40]!r}")
            if not 0 <= number <= FARTHEST:
                refuse_at(text, match.start(1), f"has an agent_{key} of {match[1][:40]}")
            numbers[key] = number
    return NavAgent(*numbers.values())


def _resources(sections: list[TextSection]) -> Iterator[tuple[str, TextSection]]:
    """The NavigationMesh resources by their id; the main resource of a file has none."""
    main = next((each.attributes.get("type") for each in sections if each.kind == "gd_resource"), None)
    for section in sections:
        if section.kind == "resource" and main == "NavigationMesh":
            yield "", section
        if section.kind == "sub_resource" and section.attributes.get("type") == "NavigationMesh":
            yield section.attributes.get("id", ""), section


def _mesh(text: str, section: TextSection) -> tuple[Floats, Ints, int] | None:
    """Vertices [V, 3], triangles [F, 3] and the number of polygons; None for a mesh that is not baked."""
    points = _VERTICES.search(text, section.start, section.end)
    if points is None:
        return None
    vertices = read_numbers(text, points.end(), _POINTS, "vertices")
    polygons = _POLYGONS.search(text, section.start, section.end)
    if polygons is None:
        return None
    if len(vertices) % 3:
        refuse_at(text, points.start(), f"has {len(vertices)} coordinates of vertices, no multiple of 3,")
    loops = list(_polygons(text, polygons.end(), len(vertices) // 3))
    faces = np.array([fan for corners in loops for fan in _fan(corners)], dtype=np.int64)
    return (vertices.reshape(-1, 3), faces, len(loops)) if loops else None


def _fan(corners: list[int]) -> list[tuple[int, int, int]]:
    """Triangles of a convex polygon."""
    return [(corners[0], *pair) for pair in pairwise(corners[1:])]


def _polygons(text: str, at: int, vertices: int) -> Iterator[list[int]]:
    """The corners of every polygon, all of them within the `vertices`."""
    opening = _LIST.match(text, at)
    if opening is None:
        refuse_at(text, at, "has polygons that are no list")
    at = opening.end()
    while text[at : at + 1] != "]":
        match = _CORNERS.match(text, at)
        if match is None:
            refuse_at(text, at, "has a polygon that is no complete PackedInt32Array")
        corners = parse_numbers(text, match, int, "a polygon")
        if len(corners) < 3:
            refuse_at(text, at, f"has a polygon with {len(corners)} corners")
        if not 0 <= min(corners) <= max(corners) < vertices:
            refuse_at(text, at, f"has a polygon with a corner outside of the {vertices} vertices")
        yield corners
        at = match.end()
        if separator := _SEPARATOR.match(text, at):
            at = separator.end()
        elif text[at : at + 1] != "]":
            refuse_at(text, at, "has polygons without an end")


def _placements(text: str, masked: str, sections: list[TextSection]) -> dict[str, list[tuple[str, Floats]]]:
    """Names and matrices [4, 4] of the regions, by the id of their mesh; parents stand before children."""
    matrices: dict[str, Floats] = {}
    found: dict[str, list[tuple[str, Floats]]] = {}
    for node in (section for section in sections if section.kind == "node"):
        name, parent = node.attributes.get("name", ""), node.attributes.get("parent")
        own = "." if parent is None else name if parent == "." else f"{parent}/{name}"
        above = np.eye(4) if parent is None else matrices.get(parent, np.eye(4))
        matrices[own] = above @ _transform(masked, node)
        if region := _MESH_OF_REGION.search(masked, node.start, node.end):
            key = text[region.end() : masked.find(")", region.end())].strip().strip('"')
            found.setdefault(key, []).append((name, matrices[own]))
    return found


def _transform(text: str, node: TextSection) -> Floats:
    """The matrix [4, 4] of a node: Godot writes the rows of its basis, then its origin."""
    matrix = np.eye(4)
    if start := _TRANSFORM.search(text, node.start, node.end):
        if not text.startswith("Transform", start.end()) or text.startswith("Transform2D", start.end()):
            return matrix
        numbers = read_numbers(text, start.end(), _PLACEMENT, "a transform")
        if len(numbers) != 12:
            refuse_at(text, start.start(), f"has a transform of {len(numbers)} numbers")
        matrix[:3, :3], matrix[:3, 3] = numbers[:9].reshape(3, 3), numbers[9:]
    return matrix
