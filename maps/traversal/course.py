"""What climbing structures are made of, and the record of how one gets from each to the next.

A part is a stretch of the nav-mesh with one name and the skill it takes to get there from the part before. A
link leads from one patch of the nav-mesh to another where only a jump or a drop does.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import lanes
from kit.files import place
from kit.pieces import STEP_TREAD_M, Corner, Piece, Rect, box, slope

DECK_M = 0.5  # thickness of what hangs in the air
NET_M, NET_THICK_M = 2.5, 0.25


@dataclass(frozen=True)
class Part:
    """A named stretch of the nav-mesh."""

    name: str
    skill: str  # walk, beam, jump or drop: what leads here from the part before
    after: str | None
    at: Corner  # a place on it
    low: Corner
    high: Corner


@dataclass(frozen=True)
class Link:
    """A jump or drop from one place on the nav-mesh to another, across `gap_m` and up `rise_m`."""

    skill: str
    start: Corner
    end: Corner
    gap_m: float
    rise_m: float


@dataclass
class Course:
    """The map as it is being built."""

    pieces: list[Piece] = field(default_factory=list)
    parts: list[Part] = field(default_factory=list)
    links: list[Link] = field(default_factory=list)

    def add(self, name: str, kind: str, rect: Rect, base: float, top: float) -> Piece:
        """Place a box."""
        piece = box(name, kind, rect, round(base, 3), round(top, 3))
        self.pieces.append(piece)
        return piece

    def ramp(self, name: str, kind: str, rect: Rect, base: float, top: float, uphill: str) -> None:
        """Place a ramp or stairs."""
        self.pieces.append(slope(name, kind, rect, round(base, 3), round(top, 3), uphill))

    def part(
        self,
        name: str,
        skill: str,
        after: str | None,
        at: Corner,
        rects: Sequence[Rect],
        heights: Sequence[float],
    ) -> None:
        """Note a part that covers `rects` at some of `heights`."""
        low = (min(r.x0 for r in rects), min(r.y0 for r in rects), round(min(heights) - 0.3, 3))
        high = (max(r.x1 for r in rects), max(r.y1 for r in rects), round(max(heights) + 0.3, 3))
        self.parts.append(Part(name, skill, after, at, low, high))

    def jump(self, start: Piece, end: Piece, gap: float) -> None:
        """Note a jump between two platforms across `gap` [m]."""
        rise = round(end.top - start.top, 3)
        self.links.append(Link("jump", middle(start), middle(end), gap, rise))

    def drop(self, start: Corner, end: Corner) -> None:
        """Note a drop from a place at a rim to one below the open air next to it."""
        self.links.append(Link("drop", start, end, 0.0, round(end[2] - start[2], 3)))

    # --- structures

    def beam(self, name: str, rect: Rect, top: float, after: str) -> None:
        """A narrow beam; long in one direction."""
        self.add(name, "platform", rect, top - DECK_M, top)
        self.part(name, "beam", after, (*rect.middle, top), [rect], [top])

    def spiral(
        self, name: str, kind: str, core: Rect, base: float, rise: float, sides: str, width: float = 3.0
    ) -> Piece:
        """A way up round `core`, rising by `rise` along each of `sides`, to a landing that joins its top.

        Returns that landing, which reaches round the last corner of the core.
        """
        height = base
        for side in sides:
            foot = STEP_TREAD_M if kind == "stairs" else 0.0
            if foot and height > base:
                self.add(name, "platform", lanes.pad(core, side, width, foot), height - DECK_M, height)
            self.ramp(
                name, kind, lanes.lane(core, side, width, foot), height, height + rise, lanes.WAYS[side]
            )
            height = round(height + rise, 3)
            self.add(name, "platform", lanes.corner(core, side, width), height - DECK_M, height)
        follow = lanes.after(sides[-1])
        last, corner = lanes.start(core, follow, width), lanes.corner(core, sides[-1], width)
        both = Rect(
            min(last.x0, corner.x0), min(last.y0, corner.y0), max(last.x1, corner.x1), max(last.y1, corner.y1)
        )
        self.pieces.pop()
        return self.add(name, "platform", both, height - DECK_M, height)

    def chain(
        self,
        name: str,
        start: Piece,
        way: str,
        across: float,
        count: int,
        gap: float,
        rise: float,
        after: str,
        size: float = 3.0,
    ) -> Piece:
        """Pillars in a row from an edge of `start`, each a jump from the last; returns the last one.

        `across` is the coordinate of their middle line; `rise` is from each to the next [m].
        """
        previous, pillars = start, []
        for _ in range(count):
            rect = lanes.beside(previous.footprint, way, across, gap, size)
            pillar = self.add(name, "platform", rect, 0.0, previous.top + rise)
            self.jump(previous, pillar, gap)
            pillars.append(pillar)
            previous = pillar
        rects = [pillar.footprint for pillar in pillars]
        self.part(name, "jump", after, middle(previous), rects, [pillar.top for pillar in pillars])
        return previous

    def nets(self, name: str, rect: Rect, top: float, sides: str) -> list[Piece]:
        """Nets along some sides of a platform, on its rim."""
        t = NET_THICK_M
        rects = {
            "S": Rect(rect.x0, rect.y0, rect.x1, rect.y0 + t),
            "N": Rect(rect.x0, rect.y1 - t, rect.x1, rect.y1),
            "W": Rect(rect.x0, rect.y0 + t, rect.x0 + t, rect.y1 - t),
            "E": Rect(rect.x1 - t, rect.y0 + t, rect.x1, rect.y1 - t),
        }
        return [box(name, "block", rects[side], round(top, 3), round(top + NET_M, 3)) for side in sides]

    def needs(self, part: Part) -> list[str]:
        """All skills on the way to a part, in order of first use."""
        names = {other.name: other for other in self.parts}
        way = [part]
        while (before := way[-1].after) is not None:
            way.append(names[before])
        return list(dict.fromkeys(step.skill for step in reversed(way)))

    def truth(self) -> dict[str, Any]:
        """Parts and links as truth.yaml has them."""
        parts = [
            {
                "name": part.name,
                "skill": part.skill,
                "after": part.after,
                "needs": self.needs(part),
                "position": place(part.at),
                "bounds": _bounds(part.low, part.high),
            }
            for part in self.parts
        ]
        links = [
            {
                "skill": link.skill,
                "from": place(link.start),
                "to": place(link.end),
                "gap_m": link.gap_m,
                "rise_m": link.rise_m,
            }
            for link in self.links
        ]
        return {"parts": parts, "links": links}


def middle(piece: Piece) -> Corner:
    """The middle of a platform's top."""
    return (*piece.footprint.middle, piece.top)


def _bounds(low: Corner, high: Corner) -> dict[str, list[float]]:
    a, b = place(low), place(high)
    pairs = [sorted(pair) for pair in zip(a, b, strict=True)]
    return {"low": [pair[0] for pair in pairs], "high": [pair[1] for pair in pairs]}
