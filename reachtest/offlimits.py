"""What nobody may get into: a level's solids and forbidden zones, each known by its kind of finding and its name."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from reachtest.geometry import body_inside
from reachtest.records import Bools, Character, Floats, Level, Solid

SOLID, ZONE = "inside_solid", "forbidden_zone"  # kinds of findings


@dataclass(frozen=True)
class OffLimits:
    """A solid or a forbidden zone."""

    kind: str  # of finding, when somebody is in it
    name: str
    low: Floats  # [3] where the feet of somebody in it may be
    high: Floats  # [3]
    holds: Callable[[Floats], Bools]  # which feet positions [n, 3] are those of somebody in it


def off_limits(level: Level) -> tuple[OffLimits, ...]:
    """All of them; somebody may be in several."""
    solids = [_solid(solid, level.character) for solid in level.solids]
    zones = [
        OffLimits(ZONE, zone.name, *zone.box, zone.holds) for zone in level.zones if zone.kind == "forbidden"
    ]
    return (*solids, *zones)


def _solid(solid: Solid, who: Character) -> OffLimits:
    low, high = solid.triangles.min(axis=(0, 1)), solid.triangles.max(axis=(0, 1))
    feet = low - [0, 0, who.height_m / 2], high - [0, 0, who.radius_m]
    return OffLimits(SOLID, solid.name, *feet, lambda at: body_inside(at, who, solid.triangles))
