"""What stands round the towers: a field of pillars, a vault, terraces with a beam course, a tower, hedges."""

from __future__ import annotations

from course import DECK_M, Course, middle
from kit.pieces import Piece, Rect

FIELD_GAPS_M = (2.0, 2.5, 3.0, 4.0)  # between the columns of the field
FIELD_RISES_M = (0.8, 0.8, 0.5, -1.0)  # across each of these gaps
ROW_GAP_M, ROW_RISE_M = 2.5, 0.4
ROWS = 5
HEDGE_M = 2.4  # who lands on a hedge is near the ground still


def build(course: Course) -> None:
    """Everything but the towers."""
    _gallery(course)
    _field(course)
    _vault(course)
    _terraces(course)
    _beams(course)
    _round_tower(course)
    _hedges(course)


def _gallery(course: Course) -> None:
    """A square deck round the keep, 8 m up on posts, with a ramp."""
    name, inner, outer, top = "gallery", 16.0, 24.0, 8.0
    sides = (
        Rect(-outer, -outer, outer, -inner),
        Rect(-outer, inner, outer, outer),
        Rect(-outer, -inner, -inner, inner),
        Rect(inner, -inner, outer, inner),
    )
    for rect in sides:
        course.add(name, "platform", rect, top - DECK_M, top)
    for x in (-outer, -8.5, 7.5, outer - 1):
        for y in (-outer, outer - 1):
            course.add(f"{name} posts", "block", Rect(x, y, x + 1, y + 1), 0.0, top - DECK_M)
    ramp = Rect(outer, -22, outer + 2 * top, -18)
    course.ramp(f"{name} ramp", "ramp", ramp, 0.0, top, "-x")
    course.part(name, "walk", "ground", (20, 20, top), [*sides, ramp], [1.0, top])


def _field(course: Course) -> None:
    """Pillars 3 m wide in five rows, climbed there and back: 4 m to 11 m high."""
    name = "field of pillars"
    course.ramp(f"{name} ramp", "ramp", Rect(-20, -48, -12, -45), 0.0, 4.0, "+x")
    xs = [-12.0]
    for gap in FIELD_GAPS_M:
        xs.append(xs[-1] + 3 + gap)
    pillars: list[Piece] = []
    height = 4.0
    for row in range(ROWS):
        y = -48.0 - row * (3 + ROW_GAP_M)
        columns = list(range(5)) if row % 2 == 0 else list(range(5))[::-1]
        for number, column in enumerate(columns):
            if pillars:
                between = min(column, columns[number - 1]) if number else 0
                height += FIELD_RISES_M[between] if number else ROW_RISE_M
            pillars.append(
                course.add(name, "platform", Rect(xs[column], y, xs[column] + 3, y + 3), 0.0, height)
            )
            if len(pillars) > 1:
                gap = FIELD_GAPS_M[between] if number else ROW_GAP_M
                course.jump(pillars[-2], pillars[-1], gap)
    ramp = Rect(-20, -48, -12, -45)
    course.part(
        f"{name} ramp", "walk", "ground", middle(pillars[0]), [ramp, pillars[0].footprint], [1.0, 4.0]
    )
    rects, tops = [p.footprint for p in pillars[1:]], [p.top for p in pillars[1:]]
    course.part(name, "jump", f"{name} ramp", middle(pillars[-1]), rects, tops)


def _vault(course: Course) -> None:
    """A block with a room that one can only drop into, through two holes in its roof, and only drop out of."""
    rect, name = Rect(30, -60, 54, -44), "vault"
    course.ramp(f"{name} ramp", "ramp", Rect(18, -54, 30, -50), 0.0, 6.0, "+x")
    course.add(f"{name} floor", "platform", rect, 0.0, 2.0)
    inner = rect.inset(0.5)
    for wall in (
        Rect(rect.x0, rect.y0, rect.x1, inner.y0),
        Rect(rect.x0, inner.y1, rect.x1, rect.y1),
        Rect(rect.x0, inner.y0, inner.x0, inner.y1),
        Rect(inner.x1, inner.y0, rect.x1, -53),
        Rect(inner.x1, -51, rect.x1, inner.y1),
        Rect(41, -56, 41.5, inner.y1),  # an inner wall between the two holes, passed at its south end
    ):
        course.add(f"{name} walls", "block", wall, 2.0, 5.5)
    course.add(f"{name} walls", "block", Rect(inner.x1, -53, rect.x1, -51), 4.5, 5.5)
    holes = (Rect(35, -53.5, 38, -50.5), Rect(45, -53.5, 48, -50.5))
    for roof in (
        Rect(rect.x0, rect.y0, rect.x1, holes[0].y0),
        Rect(rect.x0, holes[0].y1, rect.x1, rect.y1),
        Rect(rect.x0, holes[0].y0, holes[0].x0, holes[0].y1),
        Rect(holes[0].x1, holes[0].y0, holes[1].x0, holes[0].y1),
        Rect(holes[1].x1, holes[0].y0, rect.x1, holes[0].y1),
    ):
        course.add(f"{name} roof", "platform", roof, 5.5, 6.0)
    walked = [rect, Rect(18, -54, 30, -50)]
    course.part(f"{name} roof", "walk", "ground", (32, -46, 6.0), walked, [1.0, 6.0])
    course.part(f"{name} room", "drop", f"{name} roof", (36.5, -52, 2.0), [rect], [2.0])
    course.drop((34.0, -52.0, 6.0), (36.5, -52.0, 2.0))


def _terraces(course: Course) -> None:
    """Three terraces, one upon the other."""
    name = "terraces"
    for level, size in enumerate((30.0, 20.0, 10.0)):
        rect = Rect(-55 - size / 2, -55 - size / 2, -55 + size / 2, -55 + size / 2)
        top = 1.5 * (level + 1)
        course.add(name, "platform", rect, top - 1.5, top)
        course.ramp(name, "ramp", Rect(-57, rect.y1, -53, rect.y1 + 3), top - 1.5, top, "-y")
    walked = Rect(-70, -70, -40, -37)
    course.part(name, "walk", "ground", (-55, -55, 4.5), [walked], [0.5, 4.5])


def _beams(course: Course) -> None:
    """From the top terrace along two beams and over pillars to a nest."""
    course.beam("first beam", Rect(-50, -55.5, -34, -54.5), 4.5, "terraces")
    course.add("perch", "platform", Rect(-34, -57, -30, -53), 0.0, 4.5)
    course.beam("second beam", Rect(-32.45, -53, -31.55, -33), 4.5, "first beam")
    perch = course.add("perch", "platform", Rect(-34, -33, -30, -29), 0.0, 4.5)
    course.part("perch", "walk", "second beam", middle(perch), [perch.footprint], [4.5])
    last = course.chain("nest pillars", perch, "-x", -31.0, 4, 2.5, 0.8, "perch")
    nest = course.add("nest", "platform", Rect(-64.5, -34, -58.5, -28), 0.0, last.top + 0.4)
    course.jump(last, nest, round(last.low[0] - nest.high[0], 3))
    course.part("nest", "jump", "nest pillars", middle(nest), [nest.footprint], [nest.top])


def _round_tower(course: Course) -> None:
    """A lower tower with stairs all round."""
    rect = Rect(68, -79, 76, -71)
    course.add("south-east tower", "platform", rect, 0.0, 12.0)
    course.spiral("south-east tower stairs", "stairs", rect, 0.0, 4.0, "NWS")
    course.part("south-east tower", "walk", "ground", (72, -75, 12), [rect.grown(3, 3, 3, 3)], [1.0, 12.0])


def _hedges(course: Course) -> None:
    """Four square rings with one gap each: a labyrinth on the ground."""
    x, y, t = 74.0, 74.0, 0.5
    for number, half in enumerate((5.0, 9.0, 13.0, 17.0)):
        gap = (-1) ** number * (half - 4)
        whole = (-half, half)
        broken = ((-half, gap - 1.5), (gap + 1.5, half))
        for a, b in broken if number % 2 else (whole,):
            course.add("hedge", "block", Rect(x + a, y - half, x + b, y - half + t), 0.0, HEDGE_M)
        course.add("hedge", "block", Rect(x - half, y + half - t, x + half, y + half), 0.0, HEDGE_M)
        inner = half - t
        for a, b in (whole,) if number % 2 else broken:
            low, high = max(a, -inner), min(b, inner)
            course.add("hedge", "block", Rect(x - half, y + low, x - half + t, y + high), 0.0, HEDGE_M)
        course.add("hedge", "block", Rect(x + half - t, y - inner, x + half, y + inner), 0.0, HEDGE_M)
