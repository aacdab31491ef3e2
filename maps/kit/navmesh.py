"""The nav-mesh of a map, by exact geometry: floors cut into rectangles, and slopes that join them.

The floors are worked out tile by tile along the edges of what stands there. Every rectangle becomes triangles
over all corners on its rim, so that neighbours share edges.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from kit.floors import AGENT_RADIUS_M, Floor, Slope, floors, slope_of
from kit.mesh import Floats, Ints, Mesh
from kit.pieces import Piece, Rect

TILE_M = 25.0  # no rectangle crosses a tile border: keeps triangles compact, as nav-mesh builders do

Point = tuple[float, float, float]
Bools = NDArray[np.bool_]


@dataclass(frozen=True)
class Patch:
    """A walkable rectangle: its corners anticlockwise from the south-west."""

    corners: tuple[Point, Point, Point, Point]


def navmesh(pieces: Sequence[Piece]) -> Mesh:
    """The nav-mesh in level coordinates, triangles facing up."""
    patches = [_flat(rect, height) for height, floor in floors(pieces).items() for rect in free(floor)]
    patches += [_sloped(slope_of(piece)) for piece in pieces if piece.is_slope]
    lines = _Lines(patches)
    index: dict[Point, int] = {}
    faces: list[tuple[int, int, int]] = []
    for patch in patches:
        rim = [index.setdefault(point, len(index)) for point in lines.rim(patch)]
        if len(rim) == 4:
            faces += [(rim[0], rim[1], rim[2]), (rim[0], rim[2], rim[3])]
            continue
        x, y, z = np.mean(patch.corners, axis=0).round(6).tolist()
        centre = index.setdefault((x, y, z), len(index))
        faces += [(centre, a, b) for a, b in zip(rim, rim[1:] + rim[:1], strict=True)]
    return Mesh("navmesh", np.array(list(index)), np.array(faces, dtype=np.int64), np.zeros(3))


def areas(mesh: Mesh) -> Floats:
    """Area of every triangle [F] [m2]."""
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    return np.asarray(np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2)


def components(faces: Ints) -> Ints:
    """For every triangle [F] the number of the patch it belongs to: triangles that share edges."""
    edges = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    owner = np.repeat(np.arange(len(faces)), 3)
    order = np.lexsort((edges[:, 1], edges[:, 0]))
    same = (np.diff(edges[order], axis=0) == 0).all(axis=1)
    a, b = owner[order[:-1][same]], owner[order[1:][same]]
    graph = coo_matrix((np.ones(len(a)), (a, b)), shape=(len(faces), len(faces)))
    return np.asarray(connected_components(graph, directed=False)[1], dtype=np.int64)


def kept(mesh: Mesh, keep: Bools) -> Mesh:
    """The mesh with the triangles [F] to keep, and no vertex that they do not use."""
    used, faces = np.unique(mesh.faces[keep], return_inverse=True)
    return Mesh(mesh.name, mesh.vertices[used], faces.reshape(-1, 3), mesh.origin)


# --- floors to rectangles


def free(floor: Floor) -> Iterator[Rect]:
    """Disjoint rectangles that together are where an agent's centre may be."""
    ground, blocked = _by_tile(floor.ground), _by_tile(floor.blocked)
    for key in sorted(ground):
        tile = Rect(key[0] * TILE_M, key[1] * TILE_M, (key[0] + 1) * TILE_M, (key[1] + 1) * TILE_M)
        r = AGENT_RADIUS_M
        missing = [rect.grown(r, r, r, r) for rect in cover(tile.grown(r, r, r, r), [], ground[key])]
        yield from cover(tile, missing + blocked.get(key, []), None)


def _by_tile(rects: Iterable[Rect]) -> dict[tuple[int, int], list[Rect]]:
    """The rectangles that matter to each tile."""
    tiles: dict[tuple[int, int], list[Rect]] = defaultdict(list)
    reach = 2 * AGENT_RADIUS_M
    for rect in rects:
        wide = rect.grown(reach, reach, reach, reach)
        for i in range(int(wide.x0 // TILE_M), int(wide.x1 // TILE_M) + 1):
            for j in range(int(wide.y0 // TILE_M), int(wide.y1 // TILE_M) + 1):
                tiles[i, j].append(rect)
    return tiles


def cover(area: Rect, outside: Sequence[Rect], holes: Sequence[Rect] | None) -> list[Rect]:
    """Disjoint rectangles that together are `area` without `outside` and `holes`."""
    rects = [*outside, *(holes or ())]
    if not rects:
        return [area]
    xs = _cuts(area.x0, area.x1, (v for rect in rects for v in (rect.x0, rect.x1)))
    ys = _cuts(area.y0, area.y1, (v for rect in rects for v in (rect.y0, rect.y1)))
    taken = np.zeros((len(xs) - 1, len(ys) - 1), dtype=np.bool_)
    bounds = np.round([(rect.x0, rect.x1, rect.y0, rect.y1) for rect in rects], 6)
    i = np.searchsorted(xs, bounds[:, :2])
    j = np.searchsorted(ys, bounds[:, 2:])
    for (i0, i1), (j0, j1) in zip(i.tolist(), j.tolist(), strict=True):
        taken[i0:i1, j0:j1] = True
    return [Rect(xs[a], ys[b], xs[c], ys[d]) for a, b, c, d in _rectangles(~taken)]


def _cuts(low: float, high: float, values: Iterable[float]) -> list[float]:
    low, high = round(low, 6), round(high, 6)
    inner = {v for value in values if low < (v := round(value, 6)) < high}
    return sorted(inner | {low, high})


def _rectangles(cells: Bools) -> Iterator[tuple[int, int, int, int]]:
    """Blocks (i, j, end i, end j) of true cells: runs along j, merged where the next row has the same run."""
    edges = np.diff(np.pad(cells, ((0, 1), (1, 1))).astype(np.int8), axis=1)
    running: dict[tuple[int, int], int] = {}
    for i in range(len(cells) + 1):
        starts, ends = np.flatnonzero(edges[i] == 1).tolist(), np.flatnonzero(edges[i] == -1).tolist()
        runs = dict.fromkeys(zip(starts, ends, strict=True))
        for run in [run for run in running if run not in runs]:
            yield running.pop(run), run[0], i, run[1]
        for run in runs:
            running.setdefault(run, i)


# --- rectangles to triangles


def _point(x: float, y: float, z: float) -> Point:
    return round(x, 6) + 0.0, round(y, 6) + 0.0, round(z, 6) + 0.0


def _flat(rect: Rect, z: float) -> Patch:
    xs, ys = (rect.x0, rect.x1, rect.x1, rect.x0), (rect.y0, rect.y0, rect.y1, rect.y1)
    a, b, c, d = (_point(x, y, z) for x, y in zip(xs, ys, strict=True))
    return Patch((a, b, c, d))


def _sloped(slope: Slope) -> Patch:
    raised = {"+x": (1, 2), "-x": (0, 3), "+y": (2, 3), "-y": (0, 1)}[slope.uphill]
    flat = _flat(slope.rect, slope.low).corners
    a, b, c, d = (_point(*p[:2], slope.high if k in raised else slope.low) for k, p in enumerate(flat))
    return Patch((a, b, c, d))


class _Lines:
    """All corners by the level line in x or y that they lie on."""

    def __init__(self, patches: Iterable[Patch]) -> None:
        lines: dict[tuple[int, float, float], set[float]] = defaultdict(set)
        for patch in patches:
            for x, y, z in patch.corners:
                lines[0, y, z].add(x)
                lines[1, x, z].add(y)
        self._lines = {key: np.array(sorted(values)) for key, values in lines.items()}

    def rim(self, patch: Patch) -> list[Point]:
        """The corners on the rim of `patch`, anticlockwise."""
        rim: list[Point] = []
        corners = patch.corners
        for k, start in enumerate(corners):
            rim += [start, *self._between(start, corners[(k + 1) % 4])]
        return rim

    def _between(self, start: Point, end: Point) -> list[Point]:
        if start[2] != end[2]:
            return []  # the side of a slope, where nothing else ends
        along = 0 if start[1] == end[1] else 1
        values = self._lines[along, start[1 - along], start[2]]
        low, high = sorted((start[along], end[along]))
        inner = values[np.searchsorted(values, low, "right") : np.searchsorted(values, high)].tolist()
        if start[along] > end[along]:
            inner.reverse()
        z, other = start[2], start[1 - along]
        return [(v, other, z) if along == 0 else (other, v, z) for v in inner]
