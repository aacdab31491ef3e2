"""The whole city: ground, blocks, streets with what stands in them, bridges, and the walls round it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

from blocks import build
from border import OUTER_M, Escape, escapes, gaps, walls
from bridges import connect, viaduct
from kit.dice import Dice
from kit.pieces import Piece, Rect, box
from roofs import Roof
from roofs import pieces as roof_pieces
from streets import AVENUE_M, Block, Streets, lay_out

CAR_M = (1.75, 4.25)
CAR_TOP_M = 1.0
CAR_PITCH_M = 9.0
CAR_SHARE = 0.2
LAMP_M = 0.25
LAMP_TOP_M = 6.0


@dataclass(frozen=True)
class City:
    """The pieces of the city, without what only one of its two variants has."""

    streets: Streets
    pieces: tuple[Piece, ...]
    roofs: tuple[Roof, ...]
    bridges: tuple[Piece, ...]
    escapes: tuple[Escape, ...]


def make_city(seed: int) -> City:
    """The city of a seed."""
    streets = lay_out(seed)
    lots = [build(block, seed) for block in streets.blocks]
    roofs, bridges = connect([roof for lot in lots for roof in lot.roofs])
    pieces = [
        *_ground(streets),
        *walls(gaps()),
        *(piece for lot in lots for piece in lot.pieces),
        *(piece for roof in roofs for piece in roof_pieces(roof)),
        *bridges,
        *viaduct(streets),
        *(piece for block in streets.blocks for piece in _furniture(block, streets, seed)),
        *(piece for escape in escapes() for piece in escape.shared),
    ]
    return City(streets, tuple(pieces), tuple(roofs), tuple(bridges), tuple(escapes()))


def _ground(streets: Streets) -> Iterator[Piece]:
    """One slab for every block, to the middle of the streets round it and under the walls."""
    xs, ys = (
        [-OUTER_M, *((a[1] + b[0]) / 2 for a, b in pairwise(spans)), OUTER_M]
        for spans in (streets.columns, streets.rows)
    )
    for block in streets.blocks:
        i, j = block.column, block.row
        yield box(f"{block.name} ground", "platform", Rect(xs[i], ys[j], xs[i + 1], ys[j + 1]), -0.5, 0.0)


def _furniture(block: Block, streets: Streets, seed: int) -> Iterator[Piece]:
    """Cars in the streets east and north of a block, and lamps at two of its corners."""
    dice, rect = Dice(seed, block.name, "street"), block.rect
    width, length = CAR_M
    if block.column + 1 < len(streets.columns):
        middle = (rect.x1 + streets.columns[block.column + 1][0]) / 2
        for y in _car_places(dice, rect.y0, rect.y1 - length):
            x = middle + dice.pick((0.25, -0.25 - width))
            yield box(f"{block.name} cars", "block", Rect(x, y, x + width, y + length), 0.0, CAR_TOP_M)
    if block.row + 1 < len(streets.rows):
        south, north = rect.y1, streets.rows[block.row + 1][0]
        away = 7.0 if north - south == AVENUE_M else 0.25
        for x in _car_places(dice, rect.x0, rect.x1 - length):
            y = (south + north) / 2 + dice.pick((away, -away - width))
            yield box(f"{block.name} cars", "block", Rect(x, y, x + length, y + width), 0.0, CAR_TOP_M)
    for x, y in ((rect.x1 + 1, rect.y0 - 1), (rect.x0 - 1, rect.y1 + 1)):
        yield box(f"{block.name} lamps", "block", Rect(x, y, x + LAMP_M, y + LAMP_M), 0.0, LAMP_TOP_M)


def _car_places(dice: Dice, low: float, high: float) -> Iterator[float]:
    count = int((high - low) // CAR_PITCH_M)
    for k in range(count + 1):
        if dice.chance(CAR_SHARE):
            yield low + k * CAR_PITCH_M + dice.length(0, 2, 0.5)
