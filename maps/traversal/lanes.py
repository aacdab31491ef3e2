"""The plan of spirals and chains: rectangles beside other rectangles.

The lane of a spiral runs anticlockwise round its core, side by side, with a square landing at every corner.
"""

from __future__ import annotations

from kit.pieces import Rect

SIDES = "ENWS"  # in the order in which a spiral climbs them, anticlockwise
WAYS = {"E": "+y", "N": "-x", "W": "-y", "S": "+x"}


def after(side: str) -> str:
    """The side that a spiral climbs after `side`."""
    return SIDES[(SIDES.index(side) + 1) % 4]


def lane(core: Rect, side: str, width: float, foot: float) -> Rect:
    """The strip outside of a side of `core`, without `foot` at its lower end."""
    return {
        "E": Rect(core.x1, core.y0 + foot, core.x1 + width, core.y1),
        "N": Rect(core.x0, core.y1, core.x1 - foot, core.y1 + width),
        "W": Rect(core.x0 - width, core.y0, core.x0, core.y1 - foot),
        "S": Rect(core.x0 + foot, core.y0 - width, core.x1, core.y0),
    }[side]


def pad(core: Rect, side: str, width: float, foot: float) -> Rect:
    """The lower end of the lane, which stairs leave free."""
    whole, rest = lane(core, side, width, 0.0), lane(core, side, width, foot)
    return {
        "E": Rect(whole.x0, whole.y0, whole.x1, rest.y0),
        "N": Rect(rest.x1, whole.y0, whole.x1, whole.y1),
        "W": Rect(whole.x0, rest.y1, whole.x1, whole.y1),
        "S": Rect(whole.x0, whole.y0, rest.x0, whole.y1),
    }[side]


def corner(core: Rect, side: str, width: float) -> Rect:
    """The square at the upper end of the lane along a side."""
    x, y = {
        "E": (core.x1, core.y1),
        "N": (core.x0 - width, core.y1),
        "W": (core.x0 - width, core.y0 - width),
        "S": (core.x1, core.y0 - width),
    }[side]
    return Rect(x, y, x + width, y + width)


def start(core: Rect, side: str, width: float) -> Rect:
    """The first square of the lane along a side."""
    whole = lane(core, side, width, 0.0)
    return {
        "E": Rect(whole.x0, whole.y0, whole.x1, whole.y0 + width),
        "N": Rect(whole.x1 - width, whole.y0, whole.x1, whole.y1),
        "W": Rect(whole.x0, whole.y1 - width, whole.x1, whole.y1),
        "S": Rect(whole.x0, whole.y0, whole.x0 + width, whole.y1),
    }[side]


def beside(rect: Rect, way: str, across: float, gap: float, size: float) -> Rect:
    """The square across a gap from an edge of `rect`."""
    a, b = across - size / 2, across + size / 2
    return {
        "+x": Rect(rect.x1 + gap, a, rect.x1 + gap + size, b),
        "-x": Rect(rect.x0 - gap - size, a, rect.x0 - gap, b),
        "+y": Rect(a, rect.y1 + gap, b, rect.y1 + gap + size),
        "-y": Rect(a, rect.y0 - gap - size, b, rect.y0 - gap),
    }[way]
