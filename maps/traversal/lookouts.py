"""The outer walls, and four lookouts that overlook them.

Each lookout has nets round it, so that nobody jumps over the outer wall. The planted bugs: the outermost net of
each is missing. `mended` has these four.
"""

from __future__ import annotations

from dataclasses import dataclass

from course import Course
from kit.files import Bug
from kit.pieces import Corner, Piece, Rect

HALF_M = 100.0
WALL_M, WALL_TOP_M, CORNER_TOP_M = 1.0, 8.0, 12.0
CORNER_M = 4.0
BEYOND_M = 25.0  # outside of the walls the world goes on this far: farther than anybody flies
KILL_Z_M = -20.0
SIZE_M = 8.0


@dataclass(frozen=True)
class Lookout:
    """A lookout's bug, and the net that mends it."""

    bug: Bug
    mended: tuple[Piece, ...]


def walls(course: Course) -> None:
    """The ground and the walls round it."""
    h, w, c = HALF_M, WALL_M, CORNER_M
    course.add("ground", "platform", Rect(-h, -h, h, h), -0.5, 0.0)
    course.part("ground", "walk", None, (20, -20, 0), [Rect(-h, -h, h, h)], [0.0])
    for name, rect in (
        ("south wall", Rect(-h + c, -h, h - c, -h + w)),
        ("north wall", Rect(-h + c, h - w, h - c, h)),
        ("west wall", Rect(-h, -h + c, -h + w, h - c)),
        ("east wall", Rect(h - w, -h + c, h, h - c)),
    ):
        course.add(name, "block", rect, 0.0, WALL_TOP_M)
    for name, x, y in (
        ("south-west", -h, -h),
        ("south-east", h - c, -h),
        ("north-west", -h, h - c),
        ("north-east", h - c, h - c),
    ):
        course.add(f"{name} corner", "block", Rect(x, y, x + c, y + c), 0.0, CORNER_TOP_M)


def build(course: Course) -> list[Lookout]:
    """All four lookouts, with the ways to them."""
    return [_east(course), _south(course), _west(course), _north(course)]


def _lookout(
    course: Course, side: str, rect: Rect, top: float, skill: str, after: str
) -> tuple[Lookout, Piece]:
    """The platform with its nets; open towards the middle of the map."""
    names = {"E": "east", "S": "south", "W": "west", "N": "north"}
    name = f"{names[side]} lookout"
    platform = course.add(name, "platform", rect, 0.0, top)
    course.part(name, skill, after, (*rect.middle, top), [rect], [top])
    inner = {"E": "W", "W": "E", "N": "S", "S": "N"}[side]
    course.pieces += course.nets(
        f"{name} nets", rect, top, "".join(s for s in "SNWE" if s not in (side, inner))
    )
    mended = course.nets(f"{name} outer net", rect, top, side)
    return Lookout(_bug(name, side, rect, top), tuple(mended)), platform


def _bug(name: str, side: str, rect: Rect, top: float) -> Bug:
    x, y = rect.middle
    at: Corner = {
        "E": (rect.x1, y, top),
        "W": (rect.x0, y, top),
        "N": (x, rect.y1, top),
        "S": (x, rect.y0, top),
    }[side]
    low, high = [-HALF_M, -HALF_M, KILL_Z_M - 5], [HALF_M, HALF_M, top + 2]
    axis, reach = (0 if side in "EW" else 1), HALF_M + BEYOND_M
    if side in "EN":
        low[axis], high[axis] = at[axis], reach
    else:
        low[axis], high[axis] = -reach, at[axis]
    text = (
        f"The outermost net of the {name} is missing: from {top:g} m up one jumps over the wall, which is "
        f"{WALL_TOP_M:g} m high, or onto it, and falls off the map."
    )
    bounds = ((low[0], low[1], low[2]), (high[0], high[1], high[2]))
    return Bug(f"{name} without a net", "unexpected_area", ("fell_out_of_world",), at, *bounds, 8.0, text)


def _east(course: Course) -> Lookout:
    course.beam("east beam", Rect(65, -0.45, 84, 0.45), 16.0, "east tower")
    return _lookout(course, "E", Rect(84, -4, 92, 4), 16.0, "walk", "east beam")[0]


def _south(course: Course) -> Lookout:
    start = [piece for piece in course.pieces if piece.name == "field of pillars"][-1]
    x = start.footprint.middle[0]
    last = course.chain("south pillars", start, "-y", x, 2, 3.0, 0.0, "field of pillars")
    rect = Rect(x - 4, last.low[1] - 3 - SIZE_M, x + 4, last.low[1] - 3)
    lookout, platform = _lookout(course, "S", rect, last.top, "jump", "south pillars")
    course.jump(last, platform, 3.0)
    return lookout


def _west(course: Course) -> Lookout:
    top = next(piece.top for piece in course.pieces if piece.name == "west mesa")
    course.beam("west beam", Rect(-80, 4, -55, 5), top, "west mesa")
    return _lookout(course, "W", Rect(-88, 0.5, -80, 8.5), top, "walk", "west beam")[0]


def _north(course: Course) -> Lookout:
    start = next(piece for piece in course.pieces if piece.name == "north mesa")
    last = course.chain("north pillars", start, "+y", 0.0, 3, 3.5, 0.0, "north mesa")
    rect = Rect(-4, last.high[1] + 3.5, 4, last.high[1] + 3.5 + SIZE_M)
    lookout, platform = _lookout(course, "N", rect, last.top, "jump", "north pillars")
    course.jump(last, platform, 3.5)
    return lookout
