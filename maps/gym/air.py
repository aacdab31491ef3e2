"""Exercises in the air: jumps, gaps, and floors under a fast fall."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from kit.pieces import Rect, box

from gym.exercise import (
    EAST,
    Character,
    Check,
    Exercise,
    Hold,
    Track,
    air_time,
    apex,
    carries,
    end_height,
    lowest,
    run_up,
)
from gym.ground import SETTLE
from gym.shapes import floor, tiled_floor

DEPTH_M = 3.0  # of the pit under a gap: more than a jump is high


def jump_apex(c: Character) -> Exercise:
    """A jump from a standstill."""

    def rise(track: Track) -> float:
        return float(track.path[:, 2].max() - track.path[track.marks[0], 2])

    check = Check("apex [m]", rise, 0.97 * apex(c), 1.03 * apex(c))
    script = (SETTLE, Hold(0.01, jump=True), Hold(air_time(c)))
    return Exercise((floor(-3, 3),), (0, 0, 0.02), script, (check,))


def jump_distance(c: Character) -> Exercise:
    """A jump at walking speed; where its path crosses the ground again lies between two ticks."""

    def distance(track: Track) -> float:
        took_off = track.marks[1]
        path = track.path[took_off:] - track.path[took_off]
        flying = np.flatnonzero(~track.grounded[took_off:])
        last = flying[np.flatnonzero(np.diff(np.append(flying, 10**6)) > 1)[0]]
        x, z = path[last, 0], path[last, 2]
        along, fall = (path[last] - path[last - 1])[[0, 2]] / track.tick_s
        fall -= c.gravity_mps2 * track.tick_s / 2  # what it is at the tick, not over it
        left = (fall + np.sqrt(fall**2 + 2 * c.gravity_mps2 * max(z, 0.0))) / c.gravity_mps2
        return float(x + along * left)

    check = Check("distance [m]", distance, 0.97 * carries(c), 1.03 * carries(c))
    ground = floor(-run_up(c) - 2, carries(c) + 6)
    script = (SETTLE, Hold(9.0, EAST, until_x=0.0), Hold(0.01, EAST, True), Hold(air_time(c) + 0.3, EAST))
    return Exercise((ground,), (-run_up(c), 0, 0.02), script, (check,))


def gap(crossed: bool) -> Callable[[Character], Exercise]:
    """A gap 3 % narrower than the jump carries, or 3 % and the capsule's overhang wider, jumped from its edge."""

    def build(c: Character) -> Exercise:
        wide = 0.97 * carries(c) if crossed else 1.03 * carries(c) + c.radius_m
        deep = DEPTH_M + apex(c)
        near = box("near", "platform", Rect(-run_up(c) - 3, -3, 0, 3), -deep, 0.0)
        far = box("far", "platform" if crossed else "block", Rect(wide, -3, wide + 6, 3), -deep, 0.0)
        pit = box("pit", "platform", Rect(near.low[0], -3, wide + 6, 3), -deep - 1, -deep)
        script = (
            SETTLE,
            Hold(9.0, EAST, until_x=0.0),
            Hold(0.01, EAST, True),
            Hold(air_time(c) + 0.4, EAST),
        )
        limits = {"at_least": -0.1} if crossed else {"at_most": -0.1}
        landed = Check("height [m]", end_height, **limits)
        start = (-run_up(c) - 0.5, 0.0, 0.02)
        top = (wide + 1.5, 0.0, 0.0)
        zone = ((wide + 1, -3.0, -0.5), (wide + 6, 3.0, 4.0))
        return Exercise(
            (pit, near, far),
            start,
            script,
            (landed,),
            required=(top,) if crossed else (),
            forbidden=() if crossed else (zone,),
        )

    return build


def fall(thick_m: float) -> Callable[[Character], Exercise]:
    """A fall at terminal velocity on a floor."""

    def build(c: Character) -> Exercise:
        height = 1.3 * c.terminal_speed_mps**2 / (2 * c.gravity_mps2)
        fastest = Check(
            "fastest [m/s]", lambda t: float(-t.velocity[:, 2].min()), 0.98 * c.terminal_speed_mps
        )
        kept = Check("lowest [m]", lowest, at_least=-0.05)
        lands = Check("height [m]", end_height, -0.03, 0.03)
        seconds = 2 * c.terminal_speed_mps / c.gravity_mps2 + 2.0
        checks = (fastest, kept, lands)
        return Exercise((floor(-3, 3, thick_m),), (0.1, 0.2, 0.02), (Hold(seconds),), checks, drop_m=height)

    return build


def fall_on_tiles(c: Character) -> Exercise:
    """The same on a floor of small triangles and no thickness."""
    base = fall(1.0)(c)
    under = (box("floor", "platform", Rect(-3, -3, 3, 3), -4.0, -3.0),)
    return Exercise(
        under,
        base.start,
        base.script,
        base.checks,
        tiled_floor(-3, 3, 3, 0.5),
        nav=base.pieces,
        drop_m=base.drop_m,
    )


EXERCISES = {
    "jump apex": jump_apex,
    "flat jump distance": jump_distance,
    "gap 3 % narrower than the jump carries": gap(crossed=True),
    "gap 3 % wider than jump and overhang": gap(crossed=False),
    "2 cm floor at terminal velocity": fall(0.02),
    "1 m floor at terminal velocity": fall(1.0),
    "tessellated floor at terminal velocity": fall_on_tiles,
}
