"""The pieces a map is made of, in level coordinates (metres; x east, y north, z up)."""

from __future__ import annotations

from dataclasses import dataclass

Corner = tuple[float, float, float]
Span = tuple[float, float]

STEP_RISE_M = 0.25
STEP_TREAD_M = 0.5
SLOPE_RUN = STEP_TREAD_M / STEP_RISE_M  # run of a flight or ramp for every metre of rise: 26.6 degrees


@dataclass(frozen=True)
class Rect:
    """A rectangle in plan [m]."""

    x0: float
    y0: float
    x1: float
    y1: float

    @property
    def width(self) -> float:
        """Extent in x [m]."""
        return self.x1 - self.x0

    @property
    def depth(self) -> float:
        """Extent in y [m]."""
        return self.y1 - self.y0

    @property
    def middle(self) -> tuple[float, float]:
        """The centre (x, y)."""
        return (self.x0 + self.x1) / 2, (self.y0 + self.y1) / 2

    def grown(self, west: float, south: float, east: float, north: float) -> Rect:
        """With each side moved outwards [m]."""
        return Rect(self.x0 - west, self.y0 - south, self.x1 + east, self.y1 + north)

    def inset(self, by: float) -> Rect:
        """With every side moved inwards [m]."""
        return self.grown(-by, -by, -by, -by)


@dataclass(frozen=True)
class Piece:
    """One convex box or slope, or one flight of stairs, inside the box `low` to `high` [m].

    `kind`: `block` (an obstacle), `platform` (walkable on top), `ramp` and `stairs` (walkable, rising towards
    `uphill`; stairs end one riser below what they lead to). Pieces with the same `name` become one node.
    """

    name: str
    kind: str
    low: Corner
    high: Corner
    uphill: str = "+x"  # "+x", "-x", "+y" or "-y"

    @property
    def footprint(self) -> Rect:
        """The rectangle it covers in plan."""
        return Rect(self.low[0], self.low[1], self.high[0], self.high[1])

    @property
    def is_slope(self) -> bool:
        """Whether its top is a slope on the nav-mesh."""
        return self.kind in ("ramp", "stairs")

    @property
    def top(self) -> float:
        """Height of the floor it is or leads to [m]."""
        return self.high[2] + (STEP_RISE_M if self.kind == "stairs" else 0.0)


def box(name: str, kind: str, rect: Rect, base: float, top: float) -> Piece:
    """A block or platform over `rect` from height `base` to `top` [m]."""
    return Piece(name, kind, (rect.x0, rect.y0, base), (rect.x1, rect.y1, top))


def slope(name: str, kind: str, rect: Rect, base: float, top: float, uphill: str) -> Piece:
    """A ramp or a flight of stairs over `rect` that leads from height `base` to `top` [m].

    Raises ValueError for stairs whose run is not what their treads take.
    """
    high = top - (STEP_RISE_M if kind == "stairs" else 0.0)
    run = rect.width if uphill[1] == "x" else rect.depth
    if kind == "stairs" and abs(run - SLOPE_RUN * (high - base)) > 1e-6:
        raise ValueError(
            f"{name}: stairs up {high - base:g} m take {SLOPE_RUN * (high - base):g} m, not {run:g} m"
        )
    return Piece(name, kind, (rect.x0, rect.y0, base), (rect.x1, rect.y1, high), uphill)
