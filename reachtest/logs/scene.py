"""Triangles and findings as Foxglove scene entities (Foxglove and Lichtblick; Rerun ignores them)."""

from __future__ import annotations

import numpy as np
from foxglove_schemas_protobuf.Color_pb2 import Color
from foxglove_schemas_protobuf.KeyValuePair_pb2 import KeyValuePair
from foxglove_schemas_protobuf.LinePrimitive_pb2 import LinePrimitive
from foxglove_schemas_protobuf.SceneEntity_pb2 import SceneEntity
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate
from foxglove_schemas_protobuf.SpherePrimitive_pb2 import SpherePrimitive
from foxglove_schemas_protobuf.TextPrimitive_pb2 import TextPrimitive
from foxglove_schemas_protobuf.TriangleListPrimitive_pb2 import TriangleListPrimitive
from foxglove_schemas_protobuf.Vector3_pb2 import Vector3

from reachtest.logs.clouds import FRAME, point, pose, stamp, utf8
from reachtest.records import Finding, Floats

LEVEL_COLOUR = Color(r=0.75, g=0.75, b=0.75, a=1.0)
NAVMESH_COLOUR = Color(r=0.2, g=0.8, b=0.3, a=0.35)
ERROR_COLOUR = Color(r=0.95, g=0.2, b=0.1, a=0.9)
WARNING_COLOUR = Color(r=1.0, g=0.7, b=0.1, a=0.9)

NAVMESH_LIFT_M = 0.05  # or it flickers in the floor it lies on
SPHERE_M = 1.0  # diameter of a finding's marker: about a character
TEXT_ABOVE_M = 1.5
TEXT_M = 0.5
LINE_PX = 3.0
MAX_PATH_POINTS = 1000  # 29 bytes each: a long path must not outweigh the run


def triangles(name: str, corners: Floats, colour: Color, lift_m: float, time_ns: int) -> SceneUpdate:
    """One entity of triangles `corners` [F, 3, 3], raised by `lift_m`; equal corners are stored once."""
    flat = np.asarray(corners, dtype=np.float64).reshape(-1, 3) + np.array([0.0, 0.0, lift_m])
    vertices, indices = np.unique(flat.astype(np.float32), axis=0, return_inverse=True)
    entity = SceneEntity(timestamp=stamp(time_ns), frame_id=FRAME, id=name)
    entity.triangles.append(
        TriangleListPrimitive(
            pose=pose(np.zeros(3)),
            points=[point(vertex) for vertex in vertices],
            color=colour,
            indices=indices.reshape(-1).tolist(),
        )
    )
    return SceneUpdate(entities=[entity])


def findings_scene(findings: tuple[Finding, ...], time_ns: int) -> SceneUpdate:
    """One entity a finding: a sphere at the place, its title above it, and the way there as a line."""
    return SceneUpdate(entities=[_entity(finding, time_ns) for finding in findings])


def _entity(finding: Finding, time_ns: int) -> SceneEntity:
    colour = ERROR_COLOUR if finding.severity == "error" else WARNING_COLOUR
    above = finding.position + np.array([0.0, 0.0, TEXT_ABOVE_M])
    entity = SceneEntity(timestamp=stamp(time_ns), frame_id=FRAME, id=utf8(finding.id))
    entity.metadata.extend(
        KeyValuePair(key=key, value=utf8(value))
        for key, value in (
            ("id", finding.id),
            ("kind", finding.kind),
            ("severity", finding.severity),
            ("gating", str(finding.gating).lower()),
        )
    )
    size = Vector3(x=SPHERE_M, y=SPHERE_M, z=SPHERE_M)
    entity.spheres.append(SpherePrimitive(pose=pose(finding.position), size=size, color=colour))
    entity.texts.append(
        TextPrimitive(
            pose=pose(above), billboard=True, font_size=TEXT_M, color=colour, text=utf8(finding.title)
        )
    )
    if finding.path is not None:
        entity.lines.append(_path_line(finding.path.positions, colour))
    return entity


def _path_line(positions: Floats, colour: Color) -> LinePrimitive:
    """A line along `positions` [N, 3], thinned evenly to `MAX_PATH_POINTS` with both ends kept."""
    known = positions[np.isfinite(positions).all(axis=1)]
    kept = known
    if len(known) > MAX_PATH_POINTS:
        kept = known[np.linspace(0, len(known) - 1, MAX_PATH_POINTS).round().astype(np.int64)]
    return LinePrimitive(
        type=LinePrimitive.LINE_STRIP,
        pose=pose(np.zeros(3)),
        thickness=LINE_PX,
        scale_invariant=True,
        points=[point(row) for row in kept],
        color=colour,
    )
