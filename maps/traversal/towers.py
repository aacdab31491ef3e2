"""The towers in the order in which one climbs them, from the ground to 50 m.

East tower (walk) - north-east tower (beam) - north mesa (jumps) and the tower on it (stairs) - north-west tower
(jumps; its shaft is a drop) - west mesa (beam) and the tower on it (ramps) - keep (jumps, stairs). All stand so
far inside that nobody who jumps off one of them flies over the outer walls.
"""

from __future__ import annotations

from course import Course, middle
from kit.pieces import Piece, Rect

SHAFT_FLOOR_M = 8.0
DOOR_M = 2.5


def build(course: Course) -> None:
    """All towers."""
    _east(course)
    landing = _north(course, _north_east(course))
    corner = _west(course, _north_west(course, landing))
    _keep(course, corner)


def _square(x: float, y: float, size: float) -> Rect:
    return Rect(x - size / 2, y - size / 2, x + size / 2, y + size / 2)


def _east(course: Course) -> None:
    rect = _square(60, 0, 10)
    course.add("east tower", "platform", rect, 0.0, 16.0)
    course.spiral("east tower ramps", "ramp", rect, 0.0, 4.0, "ENWS")
    course.part("east tower", "walk", "ground", (60, 0, 16), [rect.grown(3, 3, 3, 3)], [1.0, 16.0])


def _north_east(course: Course) -> Piece:
    """Returns the last of the pillars that lead to the north tower."""
    course.beam("long beam", Rect(59.55, 5, 60.45, 38), 16.0, "east tower")
    rect = _square(60, 42, 8)
    tower = course.add("north-east tower", "platform", rect, 0.0, 16.0)
    course.part("north-east tower", "walk", "long beam", (60, 42, 16), [rect], [16.0])
    return course.chain("north-east pillars", tower, "-x", 42.0, 6, 2.0, 0.8, "north-east tower")


def _north(course: Course, pillar: Piece) -> Piece:
    """Returns the landing at the upper end of the stairs."""
    north = course.add("north mesa", "platform", Rect(-24, 36, 24, 62), 0.0, pillar.top + 0.8)
    course.jump(pillar, north, 2.0)
    base, core = north.top, _square(0, 42, 6)
    course.part("north mesa", "jump", "north-east pillars", (20, 40, base), [north.footprint], [base])
    for rect in (Rect(12, 46, 12.5, 62), Rect(-12.5, 50, -12, 58), Rect(-18, 50, -12.5, 50.5)):
        course.add("north mesa screens", "block", rect, base, base + 2.4)
    course.add("north tower top", "platform", core, base, base + 12)
    landing = course.spiral("north tower stairs", "stairs", core, base, 3.0, "WSEN")
    course.part(
        "north tower stairs",
        "walk",
        "north mesa",
        (0, 42, base + 12),
        [_square(0, 42, 12)],
        [base + 1, base + 12],
    )
    return landing


def _north_west(course: Course, landing: Piece) -> float:
    """Returns the height of the tower."""
    last = course.chain("north-west needles", landing, "-x", 43.5, 5, 3.5, 0.0, "north tower stairs")
    top, rect = last.top, Rect(-50, 39.5, -42, 47.5)
    inner = rect.inset(1.5)
    name = "north-west tower"
    floor = course.add(f"{name} base", "platform", rect, 0.0, SHAFT_FLOOR_M)
    east = course.add(name, "platform", Rect(inner.x1, rect.y0, rect.x1, rect.y1), SHAFT_FLOOR_M, top)
    course.add(name, "platform", Rect(inner.x0, rect.y0, inner.x1, inner.y0), SHAFT_FLOOR_M, top)
    course.add(name, "platform", Rect(inner.x0, inner.y1, inner.x1, rect.y1), SHAFT_FLOOR_M, top)
    y = rect.middle[1]
    for y0, y1, base in (
        (rect.y0, y - 1, SHAFT_FLOOR_M),
        (y - 1, y + 1, SHAFT_FLOOR_M + DOOR_M),
        (y + 1, rect.y1, SHAFT_FLOOR_M),
    ):
        course.add(name, "platform", Rect(rect.x0, y0, inner.x0, y1), base, top)
    course.part(name, "jump", "north-west needles", middle(east), [rect], [top])
    course.jump(last, east, 3.5)
    course.part("north-west shaft", "drop", name, (*inner.middle, SHAFT_FLOOR_M), [rect], [SHAFT_FLOOR_M])
    course.drop(middle(east), middle(floor))
    return top


def _west(course: Course, top: float) -> Piece:
    """Returns the landing at the upper end of the ramps."""
    course.beam("high beam", Rect(-46.45, 6, -45.55, 39.5), top, "north-west tower")
    body, core = Rect(-55, -20, -37, 6), _square(-43, 0, 6)
    course.add("west mesa", "platform", body, 0.0, top)
    course.part("west mesa", "walk", "high beam", (-44.5, 4.5, top), [body], [top])
    course.add("west tower top", "platform", core, top, top + 9)
    landing = course.spiral("west tower ramps", "ramp", core, top, 3.0, "WSE")
    course.part(
        "west tower ramps", "walk", "west mesa", (-43, 0, top + 9), [_square(-43, 0, 12)], [top + 1, top + 9]
    )
    return landing


def _keep(course: Course, landing: Piece) -> None:
    last = course.chain("high pillars", landing, "+x", 4.5, 6, 2.25, 0.8, "west tower ramps", size=2.5)
    keep = course.add("keep", "platform", Rect(-6.25, -16, 12, 8), 0.0, last.top + 0.8)
    course.part("keep", "jump", "high pillars", (-5, 4.5, keep.top), [keep.footprint], [keep.top])
    course.jump(last, keep, 2.25)
    crown = Rect(-1, -3, 5, 3)
    course.add("keep crown", "platform", crown, keep.top, keep.top + 2)
    course.ramp("keep crown", "stairs", Rect(-4.5, -1.5, -1, 1.5), keep.top, keep.top + 2, "+x")
    course.part("keep crown", "walk", "keep", (2, 0, keep.top + 2), [crown], [keep.top + 2])
