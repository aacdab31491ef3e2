"""What crosses the streets: footbridges from roof to roof, and a viaduct along the avenue."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import pairwise

from kit.pieces import Piece, Rect, Span, box, slope
from roofs import PARAPET_M, THICK_M, Roof, side_span
from streets import Streets

BRIDGE_M = 3.5  # width with its railings
DECK_M = 0.5
GAPS_M = (10.0, 24.0)  # spanned by a footbridge; the avenue, where the viaduct is, is wider
MARGIN_M = 1.0  # from the corner of a building or a landing to a bridge
VIADUCT_M = 9.0
VIADUCT_TOP_M = 6.0
VIADUCT_RUN_M = 60.0  # of the ramps at its ends
PIER_PITCH_M = 30.0
RAMP_RAIL_M = 2.0  # who jumps down a ramp of 1 in 10 rises above it by 4.8^2 / (4 * 4.9) = 1.18 m


def connect(roofs: Sequence[Roof]) -> tuple[list[Roof], list[Piece]]:
    """Footbridges between roofs of one height that face each other across a street.

    Returns the roofs with their doors, and the bridges. A roof gets one bridge to each side at most.
    """
    found = list(roofs)
    bridges: list[Piece] = []
    for near, far in (("E", "W"), ("N", "S")):
        for a in range(len(found)):
            candidates = ((b, _span(found[a], found[b], near, far)) for b in range(len(found)))
            for b, span in candidates:
                if span is None:
                    continue
                bridges += _bridge(f"footbridge {len(bridges) // 3 + 1}", found[a], found[b], near, span)
                door = (span[0] + THICK_M, span[1] - THICK_M)
                found[a] = found[a].with_door(near, door)
                found[b] = found[b].with_door(far, door)
                break
    return found, bridges


def _block(roof: Roof) -> str:
    return roof.name.split()[0]


def _edge(rect: Rect, side: str) -> float:
    return {"S": rect.y0, "N": rect.y1, "W": rect.x0, "E": rect.x1}[side]


def _span(a: Roof, b: Roof, near: str, far: str) -> Span | None:
    """Where along the street between them a bridge from `a` to `b` fits."""
    gap = _edge(b.rect, far) - _edge(a.rect, near)
    if a.top != b.top or _block(a) == _block(b) or not GAPS_M[0] <= gap <= GAPS_M[1]:
        return None
    taken = [*_taken(a, near), *_taken(b, far)]
    low = max(side_span(a.rect, near)[0], side_span(b.rect, far)[0]) + MARGIN_M
    high = min(side_span(a.rect, near)[1], side_span(b.rect, far)[1]) - MARGIN_M
    middle = round((low + high - BRIDGE_M) / 2 * 4) / 4
    starts = [middle, low, *(end + MARGIN_M for _, end in taken)]
    for start in sorted(starts, key=lambda start: abs(start - middle)):
        end = start + BRIDGE_M
        clear = all(end + MARGIN_M <= begin or start - MARGIN_M >= stop for begin, stop in taken)
        if start >= low and end <= high and clear:
            return start, end
    return None


def _taken(roof: Roof, side: str) -> Iterator[Span]:
    """What is taken of a side by flights and doors; a bridge there takes it all."""
    for flight in roof.flights:
        if flight.side == side:
            low, high = sorted((flight.foot, flight.end))
            yield low - THICK_M, high + THICK_M
    if any(at == side for at, _ in roof.doors):
        yield side_span(roof.rect, side)


def _bridge(name: str, a: Roof, b: Roof, near: str, span: Span) -> Iterator[Piece]:
    start, end = (_edge(a.rect, near), _edge(b.rect, {"E": "W", "N": "S"}[near]))
    low, high = span
    rects = [(low, high), (low, low + THICK_M), (high - THICK_M, high)]
    for number, (p, q) in enumerate(rects):
        rect = Rect(start, p, end, q) if near == "E" else Rect(p, start, q, end)
        if number == 0:
            yield box(name, "platform", rect, a.top - DECK_M, a.top)
        else:
            yield box(name, "block", rect, a.top, a.top + PARAPET_M)


def viaduct(streets: Streets) -> Iterator[Piece]:
    """A road on piers along the avenue, with a ramp at either end."""
    y = sum(streets.avenue) / 2
    west, east = streets.columns[1][0], streets.columns[-2][1]
    road = Rect(west, y - VIADUCT_M / 2, east, y + VIADUCT_M / 2)
    name, top = "viaduct", VIADUCT_TOP_M
    count = round(road.width / PIER_PITCH_M)
    cuts = [round(road.x0 + road.width * k / count) for k in range(count + 1)]
    for number, (a, b) in enumerate(pairwise(cuts)):
        part = f"{name} {number + 1}"
        yield box(part, "platform", Rect(a, road.y0, b, road.y1), top - DECK_M, top)
        yield from _rails(part, Rect(a, road.y0, b, road.y1), top - DECK_M, top + PARAPET_M)
        if number:
            yield box(part, "block", Rect(a - 0.5, y - 2.0, a + 0.5, y + 2.0), 0.0, top - DECK_M)
    west_ramp = Rect(road.x0 - VIADUCT_RUN_M, road.y0, road.x0, road.y1)
    east_ramp = Rect(road.x1, road.y0, road.x1 + VIADUCT_RUN_M, road.y1)
    for part, rect, uphill in (("west ramp", west_ramp, "+x"), ("east ramp", east_ramp, "-x")):
        yield slope(f"{name} {part}", "ramp", rect, 0.0, top, uphill)
        for k in range(4):
            run = VIADUCT_RUN_M / 4
            x0 = rect.x0 + k * run if uphill == "+x" else rect.x1 - (k + 1) * run
            height = top * (k + 1) / 4 + RAMP_RAIL_M
            yield from _rails(f"{name} {part}", replace(rect, x0=x0, x1=x0 + run), 0.0, height)


def _rails(name: str, rect: Rect, base: float, top: float) -> Iterator[Piece]:
    """Railings just outside of the two long sides of `rect`."""
    yield box(name, "block", Rect(rect.x0, rect.y0 - THICK_M, rect.x1, rect.y0), base, top)
    yield box(name, "block", Rect(rect.x0, rect.y1, rect.x1, rect.y1 + THICK_M), base, top)
