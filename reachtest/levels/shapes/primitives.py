"""Shapes that `level.yaml` can state without a mesh file: box, ramp, cylinder, heightmap.

Each is a surface with outward normals, closed but for the heightmap. Positions are in the file's frame, the
triangles in level coordinates. To add one: its spec, its builder, and one line in `PRIMITIVES`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from pydantic import Field

from reachtest.levels.fields import Length, Point, Size, Spec
from reachtest.levels.shapes.heightmap import Heightmap, build_heightmap
from reachtest.records import Floats, Frame, HeightField

CYLINDER_SIDES = 32  # the polygon then stays within 0.5 % of the radius: 1 - cos(pi / 32)

# Corners of a hexahedron: bit 0 = x, bit 1 = y, bit 2 = z; each quadrilateral anticlockwise from outside.
_QUADS = ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5))
_HEXAHEDRON = np.array([corners for a, b, c, d in _QUADS for corners in ((a, b, c), (a, c, d))])


class AlignedBox(Spec):
    """A box along the frame's axes."""

    center: Point = Field(description="Centre of the box, in the frame's axes and units.")
    size: Size = Field(description="Full length along each of the frame's axes, in the frame's units.")

    def level_box(self, frame: Frame) -> tuple[Floats, Floats]:
        """Lowest and highest corner in level coordinates [3] [m]."""
        center = frame.to_level(np.array(self.center))
        half = np.abs(frame.matrix) @ np.array(self.size) / 2
        return center - half, center + half


class Box(AlignedBox):
    """A box that may be turned about the up axis."""

    yaw_deg: float = Field(
        0.0, ge=-360, le=360, description="Turn about the up axis [deg], anticlockwise from above."
    )


class Ramp(Spec):
    """A slab that leads from one edge to another."""

    start: Point = Field(alias="from", description="Centre of the top surface's lower edge.")
    end: Point = Field(alias="to", description="Centre of the top surface's upper edge.")
    width: Length = Field(description="Width across the slope, in the frame's units.")
    thickness: Length = Field(0.2, description="Thickness under the surface, in the frame's units.")


class Cylinder(Spec):
    """An upright cylinder."""

    center: Point = Field(description="Centre of the cylinder's volume.")
    radius: Length = Field(description="Radius, in the frame's units.")
    height: Length = Field(description="Full height along the up axis, in the frame's units.")


def build_box(spec: Box, frame: Frame) -> Floats:
    """Triangles [12, 3, 3] of a box."""
    low, high = spec.level_box(frame)
    center, half = (low + high) / 2, (high - low) / 2
    bits = np.array([[corner >> axis & 1 for axis in range(3)] for corner in range(8)])
    yaw = np.deg2rad(spec.yaw_deg)
    turn = np.array([[np.cos(yaw), -np.sin(yaw), 0], [np.sin(yaw), np.cos(yaw), 0], [0, 0, 1]])
    corners = center + ((2 * bits - 1) * half) @ turn.T
    return np.asarray(corners[_HEXAHEDRON])


def build_ramp(spec: Ramp, frame: Frame) -> Floats:
    """Triangles [12, 3, 3] of a sloping slab. Raises ValueError where `from` is right above `to`."""
    start, end = frame.to_level(np.array([spec.start, spec.end]))
    along = end - start
    across = np.array([-along[1], along[0], 0.0])  # horizontal, to the left of the way up
    length = float(np.linalg.norm(across))
    if length < 1e-6:
        raise ValueError("'from' and 'to' lie above each other: a ramp needs a horizontal distance")
    across *= spec.width * frame.unit_m / 2 / length
    down = np.cross(across, along)
    down *= spec.thickness * frame.unit_m / np.linalg.norm(down)
    if down[2] > 0:
        down = -down
    # Local axes: x along, y to the left, z up; right-handed, so that the corner order holds.
    corners = [
        start + down * (1 - z) + along * x + across * (2 * y - 1)
        for z in (0, 1)
        for y in (0, 1)
        for x in (0, 1)
    ]
    return np.asarray(np.array(corners)[_HEXAHEDRON])


def build_cylinder(spec: Cylinder, frame: Frame) -> Floats:
    """Triangles [4 * sides, 3, 3] of an upright cylinder, its corners on the radius."""
    center, unit = frame.to_level(np.array(spec.center)), frame.unit_m
    angle = np.arange(CYLINDER_SIDES) * (2 * np.pi / CYLINDER_SIDES)
    ring = np.stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)], axis=1) * spec.radius * unit
    half = np.array([0.0, 0.0, spec.height * unit / 2])
    low, high = center + ring - half, center + ring + half
    low_next, high_next = np.roll(low, -1, axis=0), np.roll(high, -1, axis=0)
    bottom, top = np.broadcast_to(center - half, low.shape), np.broadcast_to(center + half, low.shape)
    faces = [
        (low, low_next, high_next),
        (low, high_next, high),
        (top, high, high_next),
        (bottom, low_next, low),
    ]
    return np.concatenate([np.stack(corners, axis=1) for corners in faces])


@dataclass(frozen=True)
class Primitive:
    """A kind of primitive: what the file says of it and how it becomes triangles."""

    spec: type[Spec]
    # Of the spec, the frame and, where it has `files`, the file's bytes: triangles [F, 3, 3] or a grid of heights.
    build: Callable[..., Floats | HeightField]
    description: str
    files: tuple[str, ...] = ()  # the types its key `file` can name; none: it has no such key


PRIMITIVES: dict[str, Primitive] = {
    "box": Primitive(Box, build_box, "A box: center, size, yaw_deg."),
    "ramp": Primitive(Ramp, build_ramp, "A sloping slab: from, to, width, thickness."),
    "cylinder": Primitive(Cylinder, build_cylinder, "An upright cylinder: center, radius, height."),
    "heightmap": Primitive(
        Heightmap,
        build_heightmap,
        "A terrain: file (PNG or NPY, first row at +y), size_m, height_m, position.",
        files=(".npy", ".png"),
    ),
}
