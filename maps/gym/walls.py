"""Exercises at walls: openings, ceilings, sliding, squeezing and climbing."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
from kit.pieces import Piece

from gym.exercise import (
    EAST,
    NORTH,
    NORTH_EAST,
    NORTH_WEST,
    SOUTH_EAST,
    WEST,
    Character,
    Check,
    Exercise,
    Hold,
    Track,
    apex,
    furthest,
    highest,
)
from gym.ground import SETTLE
from gym.shapes import block, column, floor

SPARE_M = 0.05


def opening(passes: bool) -> Callable[[Character], Exercise]:
    """An opening 5 cm wider or narrower than the capsule."""

    def build(c: Character) -> Exercise:
        half = c.radius_m + (SPARE_M if passes else -SPARE_M) / 2
        walls = (block(2, 3, half, 3, 4), block(2, 3, -3, -half, 4))
        return _behind(c, walls, passes)

    return build


def ceiling(passes: bool) -> Callable[[Character], Exercise]:
    """A ceiling 5 cm higher or lower than the capsule."""

    def build(c: Character) -> Exercise:
        base = c.height_m + (SPARE_M if passes else -SPARE_M)
        return _behind(c, (block(2, 3, -3, 3, base + 4, base),), passes)

    return build


def _behind(c: Character, walls: tuple[Piece, ...], passes: bool) -> Exercise:
    end = 2.8 * c.walk_speed_mps + 3
    came = Check("reached x [m]", furthest, 4.0) if passes else Check("reached x [m]", furthest, at_most=3.0)
    ground = floor(-2, end)
    nav = None if passes else (floor(-2, 2), block(2, end, -3, 3, 4))
    zone = ((3.0 + c.radius_m, -3.0, -0.5), (end, 3.0, 4.0))
    return Exercise(
        (ground, *walls),
        (0, 0, 0.02),
        (SETTLE, Hold(2.5 if passes else 6.0, EAST)),
        (came,),
        nav=nav,
        required=((5, 0, 0),) if passes else (),
        forbidden=() if passes else (zone,),
    )


def sliding(panel_m: float) -> Callable[[Character], Exercise]:
    """Along a wall, pushing into it at 45 degrees; also one of panels that meet flush."""

    def build(c: Character) -> Exercise:
        end = 2.5 * c.walk_speed_mps + 4
        panels = np.arange(-2, end, panel_m)
        walls = tuple(block(float(x), min(float(x) + panel_m, end), 2, 3, 4) for x in panels)

        def slowest(track: Track) -> float:
            """Over any half second of the last one: single ticks catch at seams, and it gets on at once."""
            speed = track.velocity[track.last(1.0), 0]
            half = len(speed) // 2
            return float(np.convolve(speed, np.full(half, 1 / half), "valid").min())

        def into(track: Track, part: slice) -> float:
            return float((track.path[part, 1] + c.radius_m - 2.0).max())

        along = Check("slowest half second [m/s]", slowest, 0.6 * c.walk_speed_mps)
        tick = Check("slowest tick [m/s]", lambda t: float(t.velocity[t.last(1.0), 0].min()), 0.0)
        # A tick may end inside the wall, at the impact and at seams, far from the middle of the capsule.
        deep = Check("into the wall [m]", lambda t: into(t, slice(None)), at_most=c.radius_m / 3)
        out = Check(
            "in the wall at the end [m]",
            lambda t: float(np.median(t.path[t.last(1.0), 1])) + c.radius_m - 2.0,
            at_most=0.03,
        )
        script = (SETTLE, Hold(3.0, NORTH_EAST))
        return Exercise((floor(-2, end), *walls), (0, 0, 0.02), script, (along, tick, deep, out))

    return build


def squeezing(jump: bool) -> Callable[[Character], Exercise]:
    """Into the corner between two walls that meet at 10 degrees."""

    def build(c: Character) -> Exercise:
        a = np.radians(5)
        deepest = float(c.radius_m / np.sin(a))
        long = deepest + 4
        wide, tall = long * np.tan(a), 4.0 + apex(c)
        left = column(np.array([[0, 0], [long, wide], [0, wide]]), tall)
        right = column(np.array([[0, 0], [0, -wide], [long, -wide]]), tall)
        ground = floor(-2, long + 4)
        sides = (block(-2, 0, -3, 3, tall), block(0, long, wide, 3, tall), block(0, long, -3, -wide, tall))
        checks = (
            Check("deepest, of theory [m]", lambda t: float(t.path[:, 0].min()) - deepest, at_least=-0.15),
            Check("highest [m]", highest, at_most=1.03 * apex(c) + 0.02 if jump else 0.1),
        )
        nav = (ground, block(-2, deepest + 0.6, -3, 3, tall), *sides[1:])
        zone = ((-2.0, -3.0, -0.5), (deepest - 0.3, 3.0, tall))
        high = ((-2.0, -3.0, tall - 1), (long, 3.0, tall + 3))
        return Exercise(
            (ground, *sides),
            (long + 2, 0, 0.02),
            (SETTLE, Hold(4.0, WEST, jump)),
            checks,
            np.concatenate([left, right]),
            nav,
            forbidden=(zone, high),
        )

    return build


def wall_jumps(course: float = np.inf) -> Callable[[Character], Exercise]:
    """Jumping at a wall with the button held, straight on, aslant, along."""
    sticks = (EAST, NORTH_EAST, NORTH, EAST)
    return _climbing(tuple(Hold(1.5, stick, True) for stick in sticks), course)


def jitter(course: float = np.inf) -> Callable[[Character], Exercise]:
    """Jumping into a corner of two walls with stick and button changing every few ticks."""
    sticks = (EAST, WEST, NORTH_EAST, NORTH_WEST, NORTH, SOUTH_EAST)
    to_wall = (Hold(1.5, NORTH_EAST),)
    holds = tuple(Hold(0.07 + 0.03 * (k % 4), sticks[k % 6], k % 3 != 2) for k in range(80))
    return _climbing(to_wall + holds, course)


def _climbing(holds: tuple[Hold, ...], course: float) -> Callable[[Character], Exercise]:
    """At two walls of blocks, `course` times as high as a jump: where they are flush their joints are no ledges."""

    def build(c: Character) -> Exercise:
        tall = apex(c) + 5
        joints = [*np.arange(0.0, tall - 1e-6, min(course * apex(c), tall)).tolist(), tall]
        walls = [
            block(*sides, top, base)
            for base, top in pairwise(joints)
            for sides in ((2, 3, -3, 3), (-6, 2, 2, 3))
        ]
        check = Check("highest [m]", highest, at_most=1.03 * apex(c) + 0.02)
        zone = ((-6.0, -3.0, 1.03 * apex(c) + 0.5), (3.0, 3.0, tall + 3))
        return Exercise((floor(-6, 3), *walls), (0, 0, 0.02), (SETTLE, *holds), (check,), forbidden=(zone,))

    return build


EXERCISES = {
    "opening of the capsule's width + 5 cm": opening(passes=True),
    "opening of the capsule's width - 5 cm": opening(passes=False),
    "ceiling of the capsule's height + 5 cm": ceiling(passes=True),
    "ceiling of the capsule's height - 5 cm": ceiling(passes=False),
    "sliding along a wall": sliding(1000.0),
    "sliding along a wall of panels": sliding(1.0),
    "walls that meet at 10 degrees": squeezing(jump=False),
    "walls that meet at 10 degrees, jumping": squeezing(jump=True),
    "jumping at a wall": wall_jumps(),
    "jumping into a corner, jittering": jitter(),
    "jumping at a wall of low blocks": wall_jumps(course=0.25),
    "jumping into a corner of blocks, jittering": jitter(course=0.7),
    "jumping into a corner of low blocks, jittering": jitter(course=0.25),
}
