"""The pieces of the small map as one fixed table, in level coordinates (metres; x east, y north, z up).

What can be stood on is at most 2 m high, because a jump (apex 0.90 m) from there stays within 3 m of the
floor; only the keep is 3 m high, and stands on a terrace wide enough to catch its jumpers. Walls, towers,
pillars and the monolith are too high to be reached from anything near them.
`tests/unit/maps/test_small_map.py` proves both.
"""

from __future__ import annotations

from dataclasses import dataclass

Corner = tuple[float, float, float]

STRAY_RAMP = "stray ramp"  # planted bug 1
MONOLITH = "monolith"  # planted bug 2
STEP_RISE_M = 0.3
STEP_TREAD_M = 0.5


@dataclass(frozen=True)
class Piece:
    """One named piece of geometry inside the box `low` to `high` [m].

    `kind`: `block` (an obstacle), `platform` and `bridge` (walkable on top), `ramp` and `stairs` (walkable,
    rising towards `uphill`). `on_navmesh` is false for a slope that the nav-mesh has as an obstacle.
    """

    name: str
    kind: str
    low: Corner
    high: Corner
    uphill: str = "+x"  # "+x", "-x", "+y" or "-y"
    on_navmesh: bool = True


def _block(name: str, x: tuple[float, float], y: tuple[float, float], top: float, base: float = 0.0) -> Piece:
    return Piece(name, "block", (x[0], y[0], base), (x[1], y[1], top))


def _crate(number: int, x: float, y: float, side: float, height: float, base: float = 0.0) -> Piece:
    """A crate whose south-west corner is at (x, y)."""
    return _block(f"crate {number}", (x, x + side), (y, y + side), base + height, base)


def _pillar(number: int, x: float, y: float) -> Piece:
    """A pillar round its centre (x, y)."""
    return _block(f"pillar {number}", (x - 0.6, x + 0.6), (y - 0.6, y + 0.6), 5.0)


FLOOR = Piece("floor", "platform", (-50, -50, -0.5), (50, 50, 0))

# Outer walls 4 m high and 1 m thick. The towers keep whoever gets onto one wall from walking to the next.
BOUNDARY = (
    _block("south wall", (-46, 46), (-50, -49), 4),
    _block("north wall", (-46, 46), (49, 50), 4),
    _block("west wall", (-50, -49), (-46, 46), 4),
    _block("east wall", (49, 50), (-46, 46), 4),
    _block("south-west tower", (-50, -46), (-50, -46), 6),
    _block("south-east tower", (46, 50), (-50, -46), 6),
    _block("north-west tower", (-50, -46), (46, 50), 6),
    _block("north-east tower", (46, 50), (46, 50), 6),
)

KEEP = (
    Piece("keep terrace", "platform", (-7, 15, 0), (7, 29, 1.5)),
    Piece("keep top", "platform", (-3, 19, 1.5), (3, 25, 3.0)),
    Piece("keep ramp", "ramp", (-2.5, 11.5, 0), (2.5, 15, 1.5), "+y"),
    Piece("keep upper ramp", "ramp", (-6, 20, 1.5), (-3, 24, 3.0), "+x"),
    Piece("keep upper stairs", "stairs", (3, 20, 1.5), (5, 24, 2.7), "-x"),
    Piece("keep stairs", "stairs", (7, 19.5, 0), (9, 24.5, 1.2), "-x"),
)

DECKS = (
    Piece("north deck", "platform", (18, 28, 0), (26, 36, 2)),
    Piece("east deck", "platform", (34, 28, 0), (42, 36, 2)),
    Piece("bridge", "bridge", (26, 31, 1.9), (34, 33, 2)),
    Piece("north deck ramp", "ramp", (13.5, 30, 0), (18, 34, 2), "+x"),
    Piece("north deck south ramp", "ramp", (20, 24, 0), (24, 28, 2), "+y"),
    Piece("east deck ramp", "ramp", (36, 24, 0), (40, 28, 2), "+y"),
    Piece("west deck", "platform", (-44, -6, 0), (-36, 4, 2)),
    Piece("west deck ramp", "ramp", (-36, -3, 0), (-31.5, 1, 2), "-x"),
    Piece("west deck north ramp", "ramp", (-42, 4, 0), (-38, 8.5, 2), "-y"),
    Piece("south deck", "platform", (26, -44, 0), (34, -37, 1.5)),
    Piece("south deck ramp", "ramp", (22.4, -42.5, 0), (26, -38.5, 1.5), "+x"),
    Piece("south deck stairs", "stairs", (28, -37, 0), (32, -35, 1.2), "-y"),
    Piece("east ledge", "platform", (36, -4, 0), (43, 6, 1.5)),
    Piece("east ledge stairs", "stairs", (34, -1.5, 0), (36, 3.5, 1.2), "+x"),
    Piece("east ledge ramp", "ramp", (37.5, 6, 0), (41.5, 9.5, 1.5), "-y"),
)

ROOMS = (
    _block("room wall 1", (-44, -40), (22, 22.4), 3.6),
    _block("room wall 2", (-37.5, -27), (22, 22.4), 3.6),
    _block("room wall 3", (-24.5, -20), (22, 22.4), 3.6),
    _block("room wall 4", (-44, -20), (39.6, 40), 3.6),
    _block("room wall 5", (-44, -43.6), (22.4, 39.6), 3.6),
    _block("room wall 6", (-20.4, -20), (22.4, 31), 3.6),
    _block("room wall 7", (-20.4, -20), (33.5, 39.6), 3.6),
    _block("room wall 8", (-32.2, -31.8), (22.4, 28), 3.6),
    _block("room wall 9", (-32.2, -31.8), (30.5, 39.6), 3.6),
)

LANES = (
    _block("lane wall 1", (14, 36), (-16, -15.5), 1.0),
    _block("lane wall 2", (20, 42), (-21, -20.5), 1.0),
    _block("lane wall 3", (14, 36), (-26, -25.5), 1.0),
    _block("lane wall 4", (20, 42), (-31, -30.5), 1.0),
)

# Cover across the yard, so that nobody sees from one end to the other.
COVER = (
    _block("cover 1", (-20, -15), (9, 9.5), 1.0),
    _block("cover 2", (-20, -19.5), (9.5, 14), 1.0),
    _block("cover 3", (17, 22), (-6, -5.5), 1.0),
    _block("cover 4", (21.5, 22), (-5.5, -1), 1.0),
    _block("cover 5", (-4, 4), (-11, -10.5), 1.0),
    _block("cover 6", (-27, -26.5), (-14, -8), 1.0),
    _block("cover 7", (-20, -13), (-39, -38.5), 1.0),
    _block("cover 8", (1, 1.5), (-30, -22), 1.0),
)

CLUTTER = (
    _pillar(1, -40, -22),
    _pillar(2, -31, -22),
    _pillar(3, -40, -33),
    _pillar(4, -31, -33),
    _crate(1, 9, 4, 1.2, 1.0),
    _crate(2, 10.2, 4, 1.2, 0.9),
    _crate(3, -11, 3.5, 1.2, 1.0),
    _crate(4, -12.2, 3.5, 1.2, 1.0),
    _crate(5, -12.2, 3.5, 1.2, 0.9, base=1.0),
    _crate(6, -40, 35, 1.2, 1.0),
    _crate(7, -26, 34, 1.2, 1.0),
    _crate(8, 25, -18.8, 1.2, 1.0),
    _crate(9, 31, -29, 1.2, 1.0),
    _crate(10, -4, -33, 1.2, 1.0),
    _crate(11, -2.8, -33, 1.2, 0.9),
    _crate(12, 20, 10, 1.2, 1.0),
)

BUGS = (
    Piece(STRAY_RAMP, "ramp", (8, -49, 0), (11, -44.2, 4), "-y", on_navmesh=False),
    _block(MONOLITH, (-18, -10), (-24, -16), 4),
)

PIECES = (FLOOR, *BOUNDARY, *KEEP, *DECKS, *ROOMS, *LANES, *COVER, *CLUTTER, *BUGS)
