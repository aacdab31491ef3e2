"""Builds a nav-mesh from the level's triangles: a voxel height field, block by block, as Recast defines it.

Recast's documentation has the terms (rcConfig). Shape legend: F triangles, Q patches, V vertices.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

import numpy as np

from reachtest.geometry import triangle_normals
from reachtest.navmesh.blocks import Block, build_block, large_islands
from reachtest.navmesh.filters import OPEN
from reachtest.navmesh.settings import BuildSettings
from reachtest.navmesh.voxels import Grid
from reachtest.records import Floats, Ints, NavAgent, NavMesh

BUILT, BUILT_BOTH = "built", "built, floors on both sides of faces"  # NavMesh.format
BLOCK = 512  # [cells] side of a block: about 0.5 GB at work over ten layers of surfaces
TURNED_OVER = 2.0  # times as much facing down as up: a level right way round has at most a little more
MOST_COLUMNS = 1 << 33  # a 1.5 km level in 2 cm cells; more is a mistake in units


def turned_over(triangles: Floats, slope_deg: float) -> bool:
    """Whether most of what is flat enough for a floor in `triangles` [F, 3, 3] faces down: turned inside out.

    Closed shapes have as much of one as of the other, rooms and terrain mostly floors.
    """
    normals, areas = triangle_normals(triangles)
    flat = float(np.cos(np.radians(slope_deg)))
    return bool(areas[normals[:, 2] < -flat].sum() > TURNED_OVER * areas[normals[:, 2] > flat].sum())


def build_navmesh(triangles: Floats, settings: BuildSettings, file: str = "") -> NavMesh:
    """The surface that the agent can walk on over `triangles` [F, 3, 3] [m], outward normal by the right-hand rule.

    Its vertices lie on the floor to within about a cell height, and a radius off walls and edges. Without faces
    where nothing is walkable. Raises ValueError where cells are so small that the level cannot be held.
    """
    agent = NavAgent(settings.radius_m, settings.height_m, settings.climb_m, settings.slope_deg)
    vertices, faces = np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64)
    if blocks := list(_blocks(triangles, settings)):
        low = triangles.min(axis=(0, 1))
        corners = large_islands(blocks, settings) * [settings.cell_m, settings.cell_m, 1.0]
        vertices, faces = _mesh(corners + [low[0], low[1], 0.0])
    return NavMesh(file, vertices, faces, format=BUILT_BOTH if settings.both_sides else BUILT, agent=agent)


def _blocks(triangles: Floats, settings: BuildSettings) -> Iterator[Block]:
    """The blocks of the grid that hold anything to walk on."""
    if not len(triangles):
        return
    low, high = triangles.min(axis=(0, 1)), triangles.max(axis=(0, 1))
    columns = np.maximum(np.ceil((high - low)[:2] / settings.cell_m), 1)
    layers = (high - low)[2] / settings.cell_height_m
    if columns.prod() > MOST_COLUMNS or layers > OPEN // 4:
        raise ValueError(f"{columns[0]:.0f} x {columns[1]:.0f} columns of {layers:.0f} cells are too many")
    shape = columns.astype(np.int64)
    margin = settings.agent.radius + 3  # what may change a block's outermost places and their neighbours
    lowest, highest = (
        (bound[:, :2] - low[:2]) / settings.cell_m for bound in (triangles.min(axis=1), triangles.max(axis=1))
    )
    for corner in product(*(range(0, int(size), BLOCK) for size in shape)):
        begin = np.array(corner)
        end = np.minimum(begin + BLOCK, shape)
        outer, outer_end = np.maximum(begin - margin, 0), np.minimum(end + margin, shape)
        near = ((lowest <= outer_end) & (highest >= outer)).all(axis=1)
        size = outer_end - outer
        origin = low + np.append(outer * settings.cell_m, 0.0)
        grid = Grid(origin, settings.cell_m, settings.cell_height_m, (int(size[0]), int(size[1])))
        if near.any() and (block := build_block(triangles[near], settings, grid, outer, begin, end)):
            yield block


def _mesh(corners: Floats) -> tuple[Floats, Ints]:
    """Vertices [V, 3] and faces [2 Q, 3] of quadrilaterals [Q, 4, 3]; equal corners are one vertex."""
    vertices, number = np.unique(np.round(corners.reshape(-1, 3), 5), axis=0, return_inverse=True)
    quads = number.reshape(-1, 4)
    faces = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]], axis=1).reshape(-1, 3)
    distinct = (faces != np.roll(faces, 1, axis=1)).all(axis=1)  # where a side has shrunk to a point
    return vertices, faces[distinct].astype(np.int64)
