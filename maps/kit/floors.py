"""Which part of every floor an agent's centre may stand on, as rectangles in plan.

A floor is the union of everything whose top is level at one height, so that neighbours join without a seam.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, field

from kit.pieces import STEP_TREAD_M, Piece, Rect

AGENT_RADIUS_M = 0.4  # the character's 0.34, rounded up
HEAD_ROOM_M = 1.9  # the character's 1.76, rounded up
TOLERANCE_M = 1e-6


@dataclass
class Floor:
    """One height: where there is ground, and what an agent's centre has to keep out of."""

    ground: list[Rect] = field(default_factory=list)
    blocked: list[Rect] = field(default_factory=list)


@dataclass(frozen=True)
class Slope:
    """A rectangle that rises from `low` to `high` [m] towards `uphill`."""

    rect: Rect
    low: float
    high: float
    uphill: str


def moved(rect: Rect, uphill: str, foot: float, top: float, sides: float) -> Rect:
    """`rect` with its foot, its top end and its two sides moved outwards [m]."""
    if uphill == "+x":
        return rect.grown(foot, sides, top, sides)
    if uphill == "-x":
        return rect.grown(top, sides, foot, sides)
    return rect.grown(sides, foot, sides, top) if uphill == "+y" else rect.grown(sides, top, sides, foot)


def foot_m(piece: Piece) -> float:
    """How far before `piece` its slope begins: stairs rise from one tread before the first riser [m]."""
    return STEP_TREAD_M if piece.kind == "stairs" else 0.0


def slope_of(piece: Piece) -> Slope:
    """The walkable surface of a ramp or flight of stairs."""
    rect = moved(piece.footprint, piece.uphill, foot_m(piece), 0.0, -AGENT_RADIUS_M)
    return Slope(rect, piece.low[2], piece.top, piece.uphill)


def _blocked(piece: Piece, height: float) -> Rect | None:
    """What `piece` takes from a floor at `height` [m], if it stands in the way there."""
    r = AGENT_RADIUS_M
    if piece.high[2] <= height + TOLERANCE_M or piece.low[2] >= height + HEAD_ROOM_M - TOLERANCE_M:
        return None
    if piece.is_slope and piece.low[2] <= height + TOLERANCE_M:
        return moved(piece.footprint, piece.uphill, foot_m(piece), r, r)
    return piece.footprint.grown(r, r, r, r)


def floors(pieces: Sequence[Piece]) -> dict[float, Floor]:
    """All floors by their height [m], lowest first."""
    r = AGENT_RADIUS_M
    found: dict[float, Floor] = defaultdict(Floor)
    for piece in pieces:
        if piece.kind == "platform":
            found[piece.high[2]].ground.append(piece.footprint)
    for piece in filter(lambda piece: piece.is_slope, pieces):
        # The ground goes on as a slope there: without these strips the edge would count as a drop.
        rect = piece.footprint
        length = rect.width if piece.uphill[1] == "x" else rect.depth
        for height, strip in (
            (piece.low[2], moved(rect, piece.uphill, 0.0, r - length, 0.0)),
            (piece.top, moved(rect, piece.uphill, r - length, 0.0, 0.0)),
        ):
            if height in found:
                found[height].ground.append(strip)
    for height, floor in found.items():
        floor.blocked += [hole for piece in pieces if (hole := _blocked(piece, height))]
    return dict(sorted(found.items()))
