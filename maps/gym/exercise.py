"""What an exercise is: a piece of level, a way to walk it, and what must come of it.

Level coordinates: metres; x along the lane, y across, z up. Shape legend: N control ticks, F triangles.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from math import inf
from typing import Any

import numpy as np
from kit.pieces import Corner, Piece
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Character = Any  # reachtest.records.Character, or whatever has its fields

STILL, EAST, NORTH_EAST, NORTH, NORTH_WEST, WEST, SOUTH_WEST, SOUTH, SOUTH_EAST = range(9)


@dataclass(frozen=True)
class Hold:
    """Stick and jump button held for a while, or until the next tick would pass `until_x` [m]."""

    seconds: float
    stick: int = STILL
    jump: bool = False
    until_x: float | None = None


@dataclass(frozen=True)
class Track:
    """What a character did: feet [N, 3], who stood [N], and the tick at which each hold of the script ended."""

    path: Floats
    grounded: NDArray[np.bool_]
    tick_s: float
    marks: tuple[int, ...]

    @property
    def velocity(self) -> Floats:
        """Over every tick [N - 1, 3] [m/s]."""
        return np.asarray(np.diff(self.path, axis=0) / self.tick_s)

    def last(self, seconds: float) -> slice:
        """The ticks of the end."""
        return slice(-max(1, round(seconds / self.tick_s)), None)


@dataclass(frozen=True)
class Check:
    """A number taken from the track, and the limits it must keep."""

    what: str
    value: Callable[[Track], float]
    at_least: float = -inf
    at_most: float = inf

    def holds(self, track: Track) -> bool:
        """Whether the limits are kept."""
        return bool(self.at_least <= self.value(track) <= self.at_most)


@dataclass(frozen=True)
class Exercise:
    """One exercise for one character; its floor is its first piece, and all of it lies within that in plan."""

    pieces: tuple[Piece, ...]
    start: Corner
    script: tuple[Hold, ...]
    checks: tuple[Check, ...]
    triangles: Floats = field(default_factory=lambda: np.empty((0, 3, 3)))  # what no piece can be, closed
    nav: tuple[Piece, ...] | None = None  # what the nav-mesh is made from, where not the pieces
    drop_m: float = 0.0  # it starts this far above `start`; in the level at `start`
    spawn: Corner | None = None  # where it starts in the level, where not at `start`
    required: tuple[Corner, ...] = ()  # places to be reached, also with all moves there are
    forbidden: tuple[tuple[Corner, Corner], ...] = ()  # boxes never to be reached by any


def apex(c: Character) -> float:
    """How high a jump goes [m]."""
    return float(c.jump_speed_mps**2 / (2 * c.gravity_mps2))


def air_time(c: Character) -> float:
    """How long a jump on level ground takes [s]."""
    return float(2 * c.jump_speed_mps / c.gravity_mps2)


def carries(c: Character) -> float:
    """How far a jump at walking speed goes on level ground [m]."""
    return float(c.walk_speed_mps * air_time(c))


def run_up(c: Character) -> float:
    """Distance that is enough to be at full speed [m]."""
    return float(2.0 + 2 * c.walk_speed_mps**2 / c.acceleration_mps2)


def round_end(c: Character) -> float:
    """Height that a capsule's round end rolls over on a slope it may walk, whatever its step height [m]."""
    return float(c.radius_m * (1 - np.cos(np.radians(c.slope_limit_deg))))


def highest(track: Track) -> float:
    """Highest position of the feet [m]."""
    return float(track.path[:, 2].max())


def lowest(track: Track) -> float:
    """Lowest position of the feet [m]."""
    return float(track.path[:, 2].min())


def furthest(track: Track) -> float:
    """Largest x [m]."""
    return float(track.path[:, 0].max())


def end_height(track: Track) -> float:
    """Height of the feet at the end [m]."""
    return float(track.path[-1, 2])
