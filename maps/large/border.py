"""The walls round the city, and six places on its west and south edge where one gets over or through them.

Every escape has pieces that are there only with the bug (`broken`), and pieces that mend it (`mended`).
Buttresses keep whoever gets onto a wall from walking to the next escape.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

from kit.files import Bug
from kit.pieces import Corner, Piece, Rect, Span, box, slope
from roofs import Roof, along, parapets
from roofs import pieces as roof_pieces
from streets import HALF_M

WALL_TOP_M = 4.5
WALL_M = 1.0
BUTTRESS_TOP_M = 7.0
BUTTRESS_M = 3.0
SECTION_M = 75.0  # from buttress to buttress
OUTER_M = HALF_M + WALL_M
ALLEY_M = 2.5  # between a wall and the building that hides it
CRATE_M = 1.5
CRATE_RISE_M = 0.75
BEYOND_M = 15.0  # outside of the walls the world goes on this far
KILL_Z_M = -20.0


@dataclass(frozen=True)
class Escape:
    """A planted escape, mended and not."""

    bug: Bug
    shared: tuple[Piece, ...]
    broken: tuple[Piece, ...]
    mended: tuple[Piece, ...]


def _section_span(number: int) -> Span:
    """The extent of a section of a wall along it, without its buttresses."""
    start = -OUTER_M + number * SECTION_M
    return start + BUTTRESS_M / 2, start + SECTION_M - BUTTRESS_M / 2


def _wall(edge: str, span: Span, inside: float = 0.0) -> Rect:
    """The part of a wall along `span`, or a strip inside of it."""
    (a, b), near, far = span, HALF_M - inside, OUTER_M
    if edge == "south":
        return Rect(a, -far, b, -near)
    if edge == "north":
        return Rect(a, near, b, far)
    return Rect(-far, a, -near, b) if edge == "west" else Rect(near, a, far, b)


def walls(broken: dict[tuple[str, int], Span]) -> Iterator[Piece]:
    """All walls and buttresses; `broken` names what is left out of a section."""
    count = round(2 * OUTER_M / SECTION_M)
    for edge in ("south", "north", "west", "east"):
        for number in range(count):
            low, high = _section_span(number)
            gap = broken.get((edge, number), (high, high))
            for a, b in ((low, gap[0]), (gap[1], high)):
                if b > a:
                    yield box(f"{edge} wall {number + 1}", "block", _wall(edge, (a, b)), 0.0, WALL_TOP_M)
            if number:
                at = -OUTER_M + number * SECTION_M
                rect = _wall(edge, (at - BUTTRESS_M / 2, at + BUTTRESS_M / 2), BUTTRESS_M - WALL_M)
                yield box(f"{edge} buttress {number}", "block", rect, 0.0, BUTTRESS_TOP_M)
    near, far = HALF_M - BUTTRESS_M, OUTER_M
    for name, x, y in (
        ("south-west", -1, -1),
        ("south-east", 1, -1),
        ("north-west", -1, 1),
        ("north-east", 1, 1),
    ):
        xs, ys = sorted((x * near, x * far)), sorted((y * near, y * far))
        yield box(f"{name} tower", "block", Rect(xs[0], ys[0], xs[1], ys[1]), 0.0, BUTTRESS_TOP_M)


# --- the escapes


def escapes() -> list[Escape]:
    """The six of them, from north to south and from west to east."""
    return [make(edge, number) for make, edge, number in PLACES]


def gaps() -> dict[tuple[str, int], Span]:
    """What the escapes leave out of the walls."""
    return {
        (edge, number): (_middle(number) - half, _middle(number) + half)
        for make, edge, number in PLACES
        if (half := HALF_GAPS_M.get(make)) is not None
    }


def _middle(number: int) -> float:
    low, high = _section_span(number)
    return (low + high) / 2


def _bug(edge: str, number: int, name: str, position: Corner, inside: float, description: str) -> Bug:
    """The bug whose bounds are a wall's section, what is outside of it, and a strip inside of it."""
    rect = _wall(edge, _section_span(number), inside)
    out = rect.grown(BEYOND_M, 0, 0, 0) if edge == "west" else rect.grown(0, BEYOND_M, 0, 0)
    low, high = (out.x0, out.y0, KILL_Z_M - 5), (out.x1, out.y1, BUTTRESS_TOP_M + 1)
    return Bug(name, "unexpected_area", ("fell_out_of_world",), position, low, high, 8.0, description)


def _missing_wall(edge: str, number: int) -> Escape:
    m, x = _middle(number), -HALF_M + ALLEY_M
    span = (m - HALF_GAPS_M[_missing_wall], m + HALF_GAPS_M[_missing_wall])
    house = box("waterworks", "block", Rect(x, m - 10, x + 7, m + 10), 0.0, 9.0)
    mended = box(f"{edge} wall {number + 1} middle", "block", _wall(edge, span), 0.0, WALL_TOP_M)
    text = (
        "Four metres of the west wall are missing behind the waterworks: one walks out and falls off the map."
    )
    bug = _bug(edge, number, "gap behind the waterworks", (-HALF_M - 0.5, m, 0.0), 0.0, text)
    return Escape(bug, (house,), (), (mended,))


def _crates(edge: str, number: int) -> Escape:
    m, x = _middle(number), -HALF_M
    crates = tuple(
        box(
            f"stray crate {k + 1}", "block", Rect(x, a, x + CRATE_M, a + CRATE_M), 0.0, CRATE_RISE_M * (k + 1)
        )
        for k, a in enumerate(m + CRATE_M * k for k in range(5))
    )
    text = (
        "Crates piled against the west wall, each a jump higher than the last, lead onto it and off the map."
    )
    at = (-HALF_M + CRATE_M / 2, m + 4.5 * CRATE_M, CRATE_RISE_M * 5)
    return Escape(_bug(edge, number, "crates at the west wall", at, CRATE_M, text), (), crates, ())


def _scaffold(edge: str, number: int) -> Escape:
    m, x = _middle(number), -HALF_M
    run = 2 * WALL_TOP_M
    scaffold = (
        slope("scaffold ramp", "ramp", Rect(x, m - run, x + 2, m), 0.0, WALL_TOP_M, "+y"),
        box("scaffold platform", "platform", Rect(x, m, x + 2, m + 2), 0.0, WALL_TOP_M),
    )
    text = "A scaffold was left at the west wall. Its ramp leads onto the wall, and from there one falls off the map."
    return Escape(
        _bug(edge, number, "scaffold at the west wall", (x + 1, m + 1, WALL_TOP_M), 2.0, text),
        (),
        scaffold,
        (),
    )


def _low_wall(edge: str, number: int) -> Escape:
    m, y = _middle(number), -HALF_M + ALLEY_M
    span = (m - HALF_GAPS_M[_low_wall], m + HALF_GAPS_M[_low_wall])
    part = f"{edge} wall {number + 1} middle"
    hiding = box("transformer", "block", Rect(m - 8, y, m + 8, y + 5), 0.0, 5.0)
    low = box(part, "block", _wall(edge, span), 0.0, CRATE_RISE_M)
    mended = replace(low, high=(*low.high[:2], WALL_TOP_M))
    text = (
        "Six metres of the south wall are 0.75 m high instead of 4.5 m: one jumps over and falls off the map."
    )
    bug = _bug(edge, number, "low wall behind the transformer", (m, -HALF_M - 0.5, CRATE_RISE_M), 0.0, text)
    return Escape(bug, (hiding,), (low,), (mended,))


def _container(edge: str, number: int) -> Escape:
    m, y = _middle(number), -HALF_M
    tops = ((-7.5, 0.75, 0.0), (-6.0, 1.5, 0.0), (-4.5, 2.25, 0.0), (0.0, 3.5, 2.75), (1.5, 4.25, 2.75))
    pile = [
        box(f"stray box {k + 1}", "block", Rect(m + x, y, m + x + CRATE_M, y + CRATE_M), base, top)
        for k, (x, top, base) in enumerate(tops)
    ]
    container = box("stray container", "block", Rect(m - 3, y, m + 3, y + 2.5), 0.0, 2.75)
    text = (
        "A container at the south wall with boxes beside and on it: a climb onto the wall, and off the map."
    )
    at = (m + 2.25, y + CRATE_M / 2, 4.25)
    return Escape(
        _bug(edge, number, "container at the south wall", at, 2.5, text), (), (container, *pile), ()
    )


def _open_roof(edge: str, number: int) -> Escape:
    m, y = _middle(number), -HALF_M + ALLEY_M
    rect = Rect(m - 14, y, m + 14, y + 8)
    roof = Roof("pump house", rect, WALL_TOP_M, (along(rect, "N", "stairs", WALL_TOP_M, 0.5, 1),), (), "S")
    mended = tuple(replace(piece, name="pump house parapet") for piece in parapets(roof, "S"))
    text = (
        "The parapet of the pump house is missing towards the south wall, whose top is as high and only "
        "2.5 m away: one jumps across, and off the map."
    )
    bug = _bug(edge, number, "roof without parapet at the south wall", (m, y, WALL_TOP_M), ALLEY_M, text)
    return Escape(bug, tuple(roof_pieces(roof)), (), mended)


HALF_GAPS_M: dict[Callable[[str, int], Escape], float] = {_missing_wall: 2.0, _low_wall: 3.0}

PLACES: tuple[tuple[Callable[[str, int], Escape], str, int], ...] = (
    (_missing_wall, "west", 14),
    (_crates, "west", 9),
    (_scaffold, "west", 4),
    (_low_wall, "south", 5),
    (_container, "south", 11),
    (_open_roof, "south", 16),
)
