"""The nav-mesh of the small map, by exact geometry: every piece is an axis-aligned box or slope.

A walkable surface is its outline shrunk by the agent radius, minus what stands on it grown by that radius.
Cut along all those edges it falls into cells, which are merged into rectangles. Slopes are rectangles too. In
the end every rectangle becomes a fan round its centre over all corners on its rim, so neighbours share edges.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from layout import FLOOR, STEP_RISE_M, STEP_TREAD_M, Piece
from mesh import Floats, Ints, Mesh
from numpy.typing import NDArray

AGENT_RADIUS_M = 0.4  # the character's 0.34, rounded up
HEAD_ROOM_M = 1.9  # the character's 1.76, rounded up
TILE_M = 10.0  # no rectangle crosses a tile border: keeps triangles compact, as nav-mesh builders do
TOLERANCE_M = 1e-6


@dataclass(frozen=True)
class Rect:
    """A rectangle in plan [m]."""

    x0: float
    y0: float
    x1: float
    y1: float

    def grown(self, west: float, south: float, east: float, north: float) -> Rect:
        """With each side moved outwards [m]."""
        return Rect(self.x0 - west, self.y0 - south, self.x1 + east, self.y1 + north)

    def contains(self, x: float, y: float) -> bool:
        """Whether the point is inside."""
        return self.x0 < x < self.x1 and self.y0 < y < self.y1


@dataclass(frozen=True)
class Patch:
    """A walkable rectangle, level or sloped one way."""

    corners: Floats  # [4, 3] anticlockwise from the south-west


def footprint(piece: Piece) -> Rect:
    """The rectangle `piece` covers in plan."""
    return Rect(piece.low[0], piece.low[1], piece.high[0], piece.high[1])


def _moved(rect: Rect, uphill: str, foot: float, top: float, sides: float) -> Rect:
    """`rect` with its foot, its top end and its two sides moved outwards [m]."""
    if uphill == "+x":
        return rect.grown(foot, sides, top, sides)
    if uphill == "-x":
        return rect.grown(top, sides, foot, sides)
    return rect.grown(sides, foot, sides, top) if uphill == "+y" else rect.grown(sides, top, sides, foot)


def _is_slope(piece: Piece) -> bool:
    return piece.on_navmesh and piece.kind in ("ramp", "stairs")


def _foot(piece: Piece) -> float:
    """How far before `piece` its slope begins: stairs rise from one tread before the first riser [m]."""
    return STEP_TREAD_M if piece.kind == "stairs" else 0.0


def slope_top(piece: Piece) -> float:
    """Height of the surface a ramp or flight of stairs leads to: stairs end one rise below it [m]."""
    return piece.high[2] + (STEP_RISE_M if piece.kind == "stairs" else 0.0)


def blocked(piece: Piece, height: float) -> Rect | None:
    """What `piece` takes from a surface at `height` [m], if it stands in the way there."""
    r = AGENT_RADIUS_M
    if piece.high[2] <= height + TOLERANCE_M or piece.low[2] >= height + HEAD_ROOM_M - TOLERANCE_M:
        return None
    if _is_slope(piece):
        return _moved(footprint(piece), piece.uphill, _foot(piece), r, r)
    return footprint(piece).grown(r, r, r, r)


def allowed(pieces: Sequence[Piece], height: float) -> list[Rect]:
    """Where an agent's centre may stand at `height` [m] as far as edges go."""
    r = AGENT_RADIUS_M
    rects = []
    for piece in pieces:
        if piece.kind == "platform" and piece.high[2] == height:
            rects.append(footprint(piece).grown(-r, -r, -r, -r))
        elif piece.kind == "bridge" and piece.high[2] == height:
            rects.append(_moved(footprint(piece), piece.uphill, r, r, -r))
        elif _is_slope(piece) and abs(slope_top(piece) - height) < TOLERANCE_M:
            length = piece.high[0] - piece.low[0] if piece.uphill[1] == "x" else piece.high[1] - piece.low[1]
            rects.append(_moved(footprint(piece), piece.uphill, -length, r, -r))
    return rects


def _cuts(values: Iterable[float]) -> list[float]:
    """The sorted grid lines at `values` and at the tile borders between them."""
    lines = {round(v, 6) for v in values}
    tiles = np.arange(np.ceil(min(lines) / TILE_M), np.ceil(max(lines) / TILE_M)) * TILE_M
    return sorted(lines | set(tiles.tolist()))


def cover(inside: Sequence[Rect], outside: Sequence[Rect]) -> list[Rect]:
    """Disjoint rectangles that together are the union of `inside` minus the union of `outside`."""
    rects = (*inside, *outside)
    xs = _cuts(v for rect in rects for v in (rect.x0, rect.x1))
    ys = _cuts(v for rect in rects for v in (rect.y0, rect.y1))
    free = np.zeros((len(xs) - 1, len(ys) - 1), dtype=bool)
    for i, j in np.ndindex(*free.shape):
        x, y = (xs[i] + xs[i + 1]) / 2, (ys[j] + ys[j + 1]) / 2
        free[i, j] = any(a.contains(x, y) for a in inside) and not any(b.contains(x, y) for b in outside)
    return [Rect(xs[i], ys[j], xs[right], ys[top]) for i, j, right, top in _merged(free, xs, ys)]


def _merged(free: NDArray[np.bool_], xs: list[float], ys: list[float]) -> Iterator[tuple[int, int, int, int]]:
    """Blocks (i, j, end i, end j) of free cells, first as wide and then as deep as they go within a tile."""
    for i, j in np.ndindex(*free.shape):
        if not free[i, j]:
            continue
        right, top = i + 1, j + 1
        while right < len(free) and free[right, j] and xs[right] % TILE_M:
            right += 1
        while top < free.shape[1] and free[i:right, top].all() and ys[top] % TILE_M:
            top += 1
        free[i:right, j:top] = False
        yield i, j, right, top


def _patch(rect: Rect, low: float, high: float, uphill: str) -> Patch:
    """The rectangle rising from `low` to `high` [m] towards `uphill`."""
    raised = {"+x": (1, 2), "-x": (0, 3), "+y": (2, 3), "-y": (0, 1)}[uphill]
    heights = [high if corner in raised else low for corner in range(4)]
    xs, ys = (rect.x0, rect.x1, rect.x1, rect.x0), (rect.y0, rect.y0, rect.y1, rect.y1)
    return Patch(np.round(np.stack([xs, ys, heights], axis=1), 6))


def patches(pieces: Sequence[Piece]) -> list[Patch]:
    """The walkable rectangles of all surfaces and slopes."""
    found = []
    for height in sorted({piece.high[2] for piece in pieces if piece.kind in ("platform", "bridge")}):
        holes = [hole for piece in pieces if piece is not FLOOR and (hole := blocked(piece, height))]
        flat = cover(allowed(pieces, height), holes)
        found += [_patch(rect, height, height, "+x") for rect in flat]
    for piece in filter(_is_slope, pieces):
        rect = _moved(footprint(piece), piece.uphill, _foot(piece), 0.0, -AGENT_RADIUS_M)
        found.append(_patch(rect, piece.low[2], slope_top(piece), piece.uphill))
    return found


def _on_rim(patch: Patch, points: Floats) -> list[Floats]:
    """Those of `points` [n, 3] that lie on the rim of `patch`, in order round it."""
    rim = []
    for a, b in zip(patch.corners, np.roll(patch.corners, -1, axis=0), strict=True):
        way = (points - a) @ (b - a) / ((b - a) @ (b - a))
        off = np.linalg.norm(points - a - way[:, None] * (b - a), axis=1)
        on = np.flatnonzero((off < TOLERANCE_M) & (way > -TOLERANCE_M) & (way < 1 - TOLERANCE_M))
        rim += [points[k] for k in on[np.argsort(way[on])]]
    return rim


def navmesh(pieces: Sequence[Piece]) -> Mesh:
    """The nav-mesh in level coordinates, triangles facing up."""
    found = patches(pieces)
    corners = np.unique(np.concatenate([patch.corners for patch in found]), axis=0)
    index = {tuple(point): k for k, point in enumerate(corners.tolist())}
    vertices: list[Floats] = list(corners)
    faces: list[tuple[int, int, int]] = []
    for patch in found:
        rim = [index[tuple(point.tolist())] for point in _on_rim(patch, corners)]
        centre = len(vertices)
        vertices.append(patch.corners.mean(axis=0))
        faces += [(centre, a, b) for a, b in zip(rim, rim[1:] + rim[:1], strict=True)]
    indices: Ints = np.array(faces, dtype=np.int64)
    return Mesh("navmesh", np.array(vertices), indices, np.zeros(3))
