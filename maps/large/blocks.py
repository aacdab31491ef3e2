"""What stands on a block: six kinds of them.

What can be stood on in the open is at most 1.1 m high, everything else there at least 2.75 m: then a jump
(apex 0.90 m and a step of 0.45 m) from anything in the open leads onto nothing else. `Lot.roofs` are the
exceptions, behind parapets.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import accumulate

from kit.dice import Dice
from kit.pieces import Rect, Span, slope
from lot import Lot, around
from roofs import side_span
from streets import Block

LOW_FENCE_M, HIGH_FENCE_M = 1.1, 2.75
TERRACE_M = 1.0
PASSAGE_M = 5.0
ARCH_M = 4.0  # clear height of a passage under a house


def perimeter(lot: Lot) -> None:
    """Houses round a courtyard, with passages into it."""
    rect, d = lot.block.rect, lot.dice.pick((12.0, 14.0, 16.0))
    rows = (
        ("S", Rect(rect.x0, rect.y0, rect.x1, rect.y0 + d)),
        ("N", Rect(rect.x0, rect.y1 - d, rect.x1, rect.y1)),
        ("W", Rect(rect.x0, rect.y0 + d, rect.x0 + d, rect.y1 - d)),
        ("E", Rect(rect.x1 - d, rect.y0 + d, rect.x1, rect.y1 - d)),
    )
    for street, row in rows:
        _row(lot, row, street, passage=street in "SN" or lot.dice.chance(0.4))
    yard = rect.inset(d + 6)
    if lot.dice.chance(0.5):
        lot.fence(yard, LOW_FENCE_M)
    for x, y in lot.scatter(yard.inset(4), lot.dice.pick((3, 5, 7)), 6.0):
        if lot.dice.chance(0.6):
            lot.add("tree", around(x, y, 0.5, 0.5), 7.0)
        else:
            lot.add("shed", around(x, y, 3.0, 2.5), 3.0)


def _row(lot: Lot, row: Rect, street: str, passage: bool) -> None:
    """One side of a courtyard: houses wall to wall, with a passage about the middle."""
    low, high = side_span(row, street)
    for index, (a, b) in enumerate(cuts := _cut(lot.dice, low, high, passage)):
        rect = Rect(a, row.y0, b, row.y1) if street in "SN" else Rect(row.x0, a, row.x1, b)
        if passage and b - a == PASSAGE_M:
            if lot.dice.chance(0.6):
                lot.add("arch", rect, lot.dice.length(8, 14, 1.0), base=ARCH_M)
            continue
        corner = street in "SN" and index in (0, len(cuts) - 1)
        sides = street if corner else street + {"S": "N", "N": "S", "W": "E", "E": "W"}[street]
        if not (lot.dice.chance(0.5) and lot.add_roof(rect, sides)):
            lot.add(f"house {len(lot.pieces) + 1}", rect, lot.dice.length(9, 24, 1.5))


def _cut(dice: Dice, low: float, high: float, passage: bool) -> list[Span]:
    """A row of houses 16 to 34 m long, split by the passage, if there is one."""
    if passage:
        gate = low + round((high - low) * dice.pick((0.4, 0.5, 0.6)) * 2) / 2
        halves = [(low, gate), (gate + PASSAGE_M, high)]
        return [*_cut(dice, *halves[0], False), (gate, gate + PASSAGE_M), *_cut(dice, *halves[1], False)]
    spans = []
    while high - low > 34:
        end = low + dice.length(16, min(32, high - low - 16), 2.0)
        spans.append((low, end))
        low = end
    return [*spans, (low, high)]


def podium(lot: Lot) -> None:
    """A shopping podium with a roof terrace, and towers on it."""
    rect = lot.block.rect.inset(lot.dice.pick((4.0, 6.0, 8.0)))
    lot.add_roof(rect, "SENW", flights=2)
    top = lot.roofs[-1].top
    half = Rect(rect.x0 + 8, rect.y0 + 8, rect.middle[0] - 4, rect.y1 - 8)
    other = Rect(rect.middle[0] + 4, rect.y0 + 8, rect.x1 - 8, rect.y1 - 8)
    for number, place in enumerate((half, other)):
        if lot.dice.chance(0.75):
            x, y = (round(v) for v in place.middle)
            tower = around(x, y, lot.dice.length(12, 18, 2.0), lot.dice.length(14, 26, 2.0))
            lot.add(f"tower {number + 1}", tower, lot.dice.length(20, 70, 2.5), base=top)


def yard(lot: Lot) -> None:
    """Warehouses behind a high fence."""
    rect = lot.block.rect
    lot.fence(rect, HIGH_FENCE_M)
    inner = rect.inset(7)
    x = round(inner.x0 + inner.width * lot.dice.pick((0.4, 0.5, 0.6)))
    y = round(inner.y0 + inner.depth * lot.dice.pick((0.4, 0.5)))
    quarters = (
        Rect(inner.x0, inner.y0, x - 5, y - 5),
        Rect(x + 5, inner.y0, inner.x1, y - 5),
        Rect(inner.x0, y + 5, x - 5, inner.y1),
        Rect(x + 5, y + 5, inner.x1, inner.y1),
    )
    for number, quarter in enumerate(quarters):
        if lot.dice.chance(0.7):
            if not lot.add_roof(quarter, "SENW"):
                lot.add(f"warehouse {number + 1}", quarter, 7.5)
        else:
            for cx, cy in lot.scatter(quarter.inset(3), 4, 8.0):
                size = lot.dice.pick(((6.0, 2.5), (2.5, 6.0)))
                lot.add("container", around(cx, cy, *size), 2.75)


def alleys(lot: Lot) -> None:
    """An old quarter: small houses and narrow alleys."""
    rect = lot.block.rect
    columns = _cut(lot.dice, rect.x0, rect.x1, False)
    rows = _cut(lot.dice, rect.y0, rect.y1, False)
    for x0, x1 in columns:
        for y0, y1 in rows:
            house = Rect(x0, y0, x1, y1).inset(lot.dice.pick((2.0, 2.0, 2.5)))
            lot.add(f"house {len(lot.pieces) + 1}", house, lot.dice.length(6, 15, 1.5))


def park(lot: Lot) -> None:
    """Trees and benches behind a low fence, and a pavilion."""
    rect = lot.block.rect
    lot.fence(rect, LOW_FENCE_M)
    x, y = (float(round(v)) for v in rect.middle)
    _terrace(lot, "pavilion", around(x, y, 12, 12))
    for dx in (-5.25, 5.25):
        for dy in (-5.25, 5.25):
            lot.add("pavilion", around(x + dx, y + dy, 0.5, 0.5), 5.0, base=TERRACE_M)
    lot.add("pavilion", around(x, y, 12, 12), 5.5, base=5.0)
    for tx, ty in lot.scatter(rect.inset(5), 26, 6.0, clear=around(x, y, 24, 24)):
        lot.add("tree", around(tx, ty, 0.5, 0.5), lot.dice.length(6, 10, 1.0))
        if lot.dice.chance(0.25):
            lot.add("bench", Rect(tx + 1.25, ty - 1, tx + 1.75, ty + 1), 0.5)


def square(lot: Lot) -> None:
    """An open square with a terrace, a monument, and market stalls."""
    rect = lot.block.rect
    x, y = (float(round(v)) for v in rect.middle)
    size = 24.0 if rect.width < 85 else 32.0
    _terrace(lot, "terrace", around(x, y, size, size))
    lot.add("monument", around(x, y, 3, 3), 12.0, base=TERRACE_M)
    for sx, sy in lot.scatter(rect.inset(5), 9, 7.0, clear=around(x, y, size + 14, size + 14)):
        if lot.dice.chance(0.6):
            lot.add("stall", around(sx, sy, 3.0, 2.0), 2.75)
        else:
            lot.add("planter", around(sx, sy, 1.5, 1.5), 0.75)


def _terrace(lot: Lot, what: str, rect: Rect) -> None:
    """A platform of 1 m with stairs on two sides and ramps on the two others."""
    lot.add(what, rect, TERRACE_M, kind="platform")
    x, y = rect.middle
    name, run = lot.name(what), 2 * TERRACE_M
    stairs = run - 0.5
    lot.pieces += [
        slope(name, "stairs", Rect(x - 4, rect.y0 - stairs, x + 4, rect.y0), 0.0, TERRACE_M, "+y"),
        slope(name, "stairs", Rect(x - 4, rect.y1, x + 4, rect.y1 + stairs), 0.0, TERRACE_M, "-y"),
        slope(name, "ramp", Rect(rect.x0 - run, y - 1.5, rect.x0, y + 1.5), 0.0, TERRACE_M, "+x"),
        slope(name, "ramp", Rect(rect.x1, y - 1.5, rect.x1 + run, y + 1.5), 0.0, TERRACE_M, "-x"),
    ]


KINDS: tuple[tuple[Callable[[Lot], None], float], ...] = (
    (perimeter, 0.40),
    (podium, 0.22),
    (yard, 0.12),
    (alleys, 0.11),
    (park, 0.09),
    (square, 0.06),
)
"""The kinds of blocks with their shares."""


def build(block: Block, seed: int) -> Lot:
    """What stands on `block`."""
    lot = Lot(block, Dice(seed, block.name))
    draw = lot.dice.length(0, sum(share for _, share in KINDS), 1 / 4096)
    ends = accumulate(share for _, share in KINDS)
    number = sum(draw >= end for end in ends)
    KINDS[min(number, len(KINDS) - 1)][0](lot)
    return lot
