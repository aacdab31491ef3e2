"""Where the streets run: two families of parallel streets with blocks between them."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

from kit.dice import Dice
from kit.pieces import Rect, Span

HALF_M = 749.0  # from the middle of the city to the inner face of its walls
RING_M = 18.0  # the street along the walls
BLOCK_SIZES_M = (72.0, 80.0, 88.0, 96.0, 104.0)
STREET_WIDTHS_M = (12.0, 12.0, 14.0, 16.0, 20.0)
SMALLEST_BLOCK_M = 60.0
LAST_TWO_M = 196.0  # less than this at the end of a row is not cut as usual: what remained might be too small
AVENUE_M = 26.0  # the street through the middle of the city, wide enough for the viaduct


@dataclass(frozen=True)
class Block:
    """The ground between four streets. `name` is as on a chessboard: column letter, row number."""

    name: str
    column: int
    row: int
    rect: Rect


@dataclass(frozen=True)
class Streets:
    """The extents of the columns and rows of blocks [m]; streets are what is between them."""

    columns: tuple[Span, ...]
    rows: tuple[Span, ...]

    @property
    def blocks(self) -> list[Block]:
        """All blocks, row by row from the south-west."""
        return [
            Block(f"{chr(ord('A') + i)}{j + 1}", i, j, Rect(x0, y0, x1, y1))
            for j, (y0, y1) in enumerate(self.rows)
            for i, (x0, x1) in enumerate(self.columns)
        ]

    @property
    def crossings(self) -> list[tuple[int, int, float, float]]:
        """Column, row and middle (x, y) of every crossing: north-east of the block with that column and row."""
        xs = [(a[1] + b[0]) / 2 for a, b in pairwise(self.columns)]
        ys = [(a[1] + b[0]) / 2 for a, b in pairwise(self.rows)]
        return [(i, j, x, y) for j, y in enumerate(ys) for i, x in enumerate(xs)]

    @property
    def avenue(self) -> Span:
        """The extent in y of the avenue."""
        return next((a[1], b[0]) for a, b in pairwise(self.rows) if b[0] - a[1] == AVENUE_M)


def _spans(dice: Dice, avenue: bool) -> tuple[Span, ...]:
    """Extents of blocks from one wall to the other; with an avenue as near to the middle as it comes."""
    low, high = -HALF_M + RING_M, HALF_M - RING_M
    spans: list[Span] = []
    while True:
        end = low + dice.pick(BLOCK_SIZES_M)
        width = dice.pick(STREET_WIDTHS_M)
        if avenue and end > -45.0:
            width, avenue = AVENUE_M, False
        if high - low < LAST_TWO_M:
            return (*spans, *_last(low, high))
        spans.append((low, end))
        low = end + width


def _last(low: float, high: float) -> tuple[Span, ...]:
    """What is left at the end: one block, or two where they are not too small."""
    half = (high - low - STREET_WIDTHS_M[0]) / 2
    if half < SMALLEST_BLOCK_M:
        return ((low, high),)
    return (low, low + half), (high - half, high)


def lay_out(seed: int) -> Streets:
    """The streets of the city with this seed."""
    return Streets(_spans(Dice(seed, "columns"), False), _spans(Dice(seed, "rows"), True))
