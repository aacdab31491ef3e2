"""Buildings whose roof one can get onto: an outside flight of stairs or a ramp, and parapets all round.

Parapets are 1.5 m high, and so are the guards along flights above the roof: more than a jump (apex 0.90 m) and a
step (0.45 m) on top.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from kit.pieces import SLOPE_RUN, Piece, Rect, Span, box, slope

PARAPET_M = 1.5
THICK_M = 0.25  # of parapets and guards
FLIGHT_M = 2.0  # width of a flight of stairs or a ramp
LANDING_M = 2.5
CORNER_M = (
    3.0  # no flight comes nearer to the corner of its building: leaves room for the one round the corner
)
SIDES = "SENW"  # anticlockwise


@dataclass(frozen=True)
class Flight:
    """Stairs or a ramp along one side of a building, up to a landing at roof height."""

    side: str
    kind: str
    foot: float  # where it starts, along the side [m]
    up: int  # +1 or -1: the way it leads along the side
    rise: float

    @property
    def end(self) -> float:
        """Where its landing ends, along the side [m]."""
        return self.foot + self.up * (SLOPE_RUN * self.rise + LANDING_M)

    @property
    def door(self) -> Span:
        """The extent of the landing along the side."""
        low, high = sorted((self.end, self.end - self.up * LANDING_M))
        return low, high


@dataclass(frozen=True)
class Roof:
    """A building with a roof to stand on at height `top` [m]."""

    name: str
    rect: Rect
    top: float
    flights: tuple[Flight, ...] = ()
    doors: tuple[tuple[str, Span], ...] = ()  # further gaps in the parapet, by side
    open_sides: str = ""  # sides without a parapet

    def with_door(self, side: str, span: Span) -> Roof:
        """With one more gap in the parapet."""
        return replace(self, doors=(*self.doors, (side, span)))


def side_span(rect: Rect, side: str) -> Span:
    """The extent of a side of `rect` along itself."""
    return (rect.x0, rect.x1) if side in "SN" else (rect.y0, rect.y1)


def strip(rect: Rect, side: str, span: Span, inside: float, outside: float) -> Rect:
    """The strip along `span` of a side, reaching `inside` and `outside` of it [m]."""
    a, b = span
    if side == "S":
        return Rect(a, rect.y0 - outside, b, rect.y0 + inside)
    if side == "N":
        return Rect(a, rect.y1 - inside, b, rect.y1 + outside)
    if side == "W":
        return Rect(rect.x0 - outside, a, rect.x0 + inside, b)
    return Rect(rect.x1 - inside, a, rect.x1 + outside, b)


def fits(rect: Rect, side: str, rise: float) -> bool:
    """Whether a side is long enough for a flight to that height [m]."""
    low, high = side_span(rect, side)
    return high - low >= SLOPE_RUN * rise + LANDING_M + 2 * CORNER_M


def along(rect: Rect, side: str, kind: str, rise: float, share: float, up: int) -> Flight:
    """A flight along a side that is long enough, at `share` (0 to 1) of the room there is for it."""
    low, high = side_span(rect, side)
    length = SLOPE_RUN * rise + LANDING_M
    start = low + CORNER_M + round(share * (high - low - 2 * CORNER_M - length) * 4) / 4
    return Flight(side, kind, start if up > 0 else start + length, up, rise)


def pieces(roof: Roof) -> Iterator[Piece]:
    """The building with its parapets and flights."""
    yield box(roof.name, "platform", roof.rect, 0.0, roof.top)
    for side in SIDES:
        if side not in roof.open_sides:
            gaps = [span for at, span in roof.doors if at == side]
            gaps += [flight.door for flight in roof.flights if flight.side == side]
            yield from parapets(roof, side, gaps)
    for flight in roof.flights:
        yield from _flight(roof, flight)


def parapets(roof: Roof, side: str, gaps: Sequence[Span] = ()) -> Iterator[Piece]:
    """The parapet along one side; those on the north and south take the corners."""
    low, high = side_span(roof.rect, side)
    if side in "EW":
        low, high = low + THICK_M, high - THICK_M
    for start, end in sorted(gaps):
        yield from _parapet(roof, side, (low, start))
        low = end
    yield from _parapet(roof, side, (low, high))


def _parapet(roof: Roof, side: str, span: Span) -> Iterator[Piece]:
    if span[1] > span[0]:
        rect = strip(roof.rect, side, span, THICK_M, 0.0)
        yield box(roof.name, "block", rect, roof.top, roof.top + PARAPET_M)


def _flight(roof: Roof, flight: Flight) -> Iterator[Piece]:
    run = SLOPE_RUN * roof.top
    if flight.kind == "stairs":
        run -= 0.5  # the last riser is the landing's edge
    top_end = flight.foot + flight.up * SLOPE_RUN * roof.top
    first = top_end - flight.up * run
    span = (min(first, top_end), max(first, top_end))
    uphill = ("+" if flight.up > 0 else "-") + ("x" if flight.side in "SN" else "y")
    yield slope(
        roof.name, flight.kind, strip(roof.rect, flight.side, span, 0.0, FLIGHT_M), 0.0, roof.top, uphill
    )
    yield box(roof.name, "platform", strip(roof.rect, flight.side, flight.door, 0.0, FLIGHT_M), 0.0, roof.top)
    # As high all along as at the top: who jumps down the flight must not get over it further down either.
    top, far = roof.top + PARAPET_M, flight.end + flight.up * THICK_M
    whole, end = ((min(a, far), max(a, far)) for a in (flight.foot, flight.end))
    outer = strip(roof.rect, flight.side, whole, -FLIGHT_M, FLIGHT_M + THICK_M)
    yield box(roof.name, "block", outer, 0.0, top)
    yield box(roof.name, "block", strip(roof.rect, flight.side, end, 0.0, FLIGHT_M), 0.0, top)
