"""A block as it is being built: places boxes, fences, and buildings with walkable roofs."""

from __future__ import annotations

from dataclasses import dataclass, field

from kit.dice import Dice
from kit.pieces import Piece, Rect, box
from roofs import Flight, Roof, along, fits
from streets import Block

ROOF_HEIGHTS_M = (4.5, 4.5, 6.0)
FENCE_THICK_M = 0.25


@dataclass
class Lot:
    """A block as it is being built."""

    block: Block
    dice: Dice
    pieces: list[Piece] = field(default_factory=list)
    roofs: list[Roof] = field(default_factory=list)

    def name(self, what: str) -> str:
        """The node name of something here."""
        return f"{self.block.name} {what}"

    def add(self, what: str, rect: Rect, top: float, base: float = 0.0, kind: str = "block") -> None:
        """Place a box."""
        self.pieces.append(box(self.name(what), kind, rect, base, top))

    def add_roof(self, rect: Rect, sides: str, flights: int = 1) -> bool:
        """Place a building with a walkable roof and flights on some of `sides`; False where none fits."""
        top = self.dice.pick(ROOF_HEIGHTS_M)
        free = [side for side in sides if fits(rect, side, top)]
        if not free:
            return False
        used: list[Flight] = []
        for _ in range(min(flights, len(free))):
            side = self.dice.pick([side for side in free if side not in [flight.side for flight in used]])
            used.append(self._flight(rect, side, top))
        name = self.name(f"hall {len(self.roofs) + 1}")
        self.roofs.append(Roof(name, rect, top, tuple(used)))
        return True

    def _flight(self, rect: Rect, side: str, top: float) -> Flight:
        kind = self.dice.pick(("stairs", "ramp", "ramp", "ramp"))
        return along(rect, side, kind, top, self.dice.length(0, 1, 0.25), self.dice.pick((1, -1)))

    def fence(self, rect: Rect, height: float, gates: int = 4) -> None:
        """A fence along the inside of `rect` with gates of 4 m in the middle of its first sides (S, N, W, E)."""
        t = FENCE_THICK_M
        x, y = (round(v * 4) / 4 for v in rect.middle)
        for number, (low, high, middle) in enumerate(
            [(rect.x0, rect.x1, x)] * 2 + [(rect.y0 + t, rect.y1 - t, y)] * 2
        ):
            spans = [(low, middle - 2), (middle + 2, high)] if number < gates else [(low, high)]
            for a, b in spans:
                rects = (
                    Rect(a, rect.y0, b, rect.y0 + t),
                    Rect(a, rect.y1 - t, b, rect.y1),
                    Rect(rect.x0, a, rect.x0 + t, b),
                    Rect(rect.x1 - t, a, rect.x1, b),
                )
                self.add("fence", rects[number], height)

    def scatter(
        self, rect: Rect, count: int, pitch: float, clear: Rect | None = None
    ) -> list[tuple[float, float]]:
        """Up to `count` places on a grid of `pitch` [m] in `rect`, none within `clear`."""
        xs = [rect.x0 + pitch * k for k in range(int(rect.width // pitch) + 1)]
        ys = [rect.y0 + pitch * k for k in range(int(rect.depth // pitch) + 1)]
        places = [(x, y) for x in xs for y in ys if clear is None or not _within(clear, x, y)]
        chosen: list[tuple[float, float]] = []
        while places and len(chosen) < count:
            chosen.append(places.pop(int(self.dice.length(0, len(places) - 1, 1))))
        return chosen


def _within(rect: Rect, x: float, y: float) -> bool:
    return rect.x0 < x < rect.x1 and rect.y0 < y < rect.y1


def around(x: float, y: float, width: float, depth: float) -> Rect:
    """The rectangle of that size centred at (x, y)."""
    return Rect(x - width / 2, y - depth / 2, x + width / 2, y + depth / 2)
