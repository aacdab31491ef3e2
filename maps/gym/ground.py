"""Exercises on the ground: speed, slopes, steps, stairs, ramps and ledges."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from kit.pieces import Rect, slope

from gym.exercise import (
    EAST,
    NORTH_EAST,
    WEST,
    Character,
    Check,
    Exercise,
    Hold,
    Track,
    apex,
    end_height,
    highest,
    round_end,
    run_up,
)
from gym.shapes import block, end_of, floor, ramp, stage

SETTLE = Hold(0.3)
SLOPE_M = 7.0  # long enough for a height that no jump reaches


def stands() -> Check:
    """On the ground at the end."""
    return Check("stands", lambda t: float(t.grounded[-1]), at_least=1)


def walking_speed(c: Character) -> Exercise:
    """Two seconds straight ahead."""
    v = c.walk_speed_mps
    speed = Check("speed [m/s]", lambda t: float(np.linalg.norm(t.velocity[-1])), 0.98 * v, 1.02 * v)
    ground = floor(-2, 2.2 * v + 3)
    return Exercise((ground,), (0, 0, 0.02), (SETTLE, Hold(2.0, EAST)), (speed, stands()))


def tick_rise(c: Character, degrees: float) -> float:
    """How high [m] a tick (1/30 s) that begins on a ramp ends above its crest."""
    return float(c.walk_speed_mps * np.tan(np.radians(degrees)) / 30)


def slope_below(run: bool) -> Callable[[Character], Exercise]:
    """A slope of the limit - 1 degree, up to the landing at its end."""

    def build(c: Character) -> Exercise:
        way = ramp(0.0, SLOPE_M, c.slope_limit_deg - 1)
        x, top = end_of(way)
        start = -run_up(c) if run else -c.radius_m - 0.3
        far = x + 0.5 * c.walk_speed_mps + 4
        pieces = (floor(-run_up(c) - 2, far), way, stage(x, far, top))
        seconds = (x - start) / c.walk_speed_mps + 0.5
        climbed = Check("height [m]", end_height, top - 0.05, top + 0.05)
        flat = Check("highest [m]", highest, at_most=top + max(0.1, tick_rise(c, c.slope_limit_deg - 1)))
        script = (SETTLE, Hold(seconds, EAST), Hold(0.5))
        return Exercise(pieces, (start, 0, 0.02), script, (climbed, flat), required=((x + 1, 0, top),))

    return build


def slope_above(run: bool, jump: bool) -> Callable[[Character], Exercise]:
    """A slope of the limit + 1 degree, pushed against for five seconds."""

    def build(c: Character) -> Exercise:
        way = ramp(0.0, SLOPE_M, c.slope_limit_deg + 1)
        x, top = end_of(way)
        start = -run_up(c) if run else -c.radius_m - 0.3
        pieces = (floor(-run_up(c) - 2, x + 3), way, block(x, x + 3, -3, 3, top))
        nav = (pieces[0], block(0, x + 3, -3, 3, top))
        limit = apex(c) + 0.05 if jump else 0.1
        kept = Check("highest [m]", highest, at_most=limit)
        zone = ((0.0, -3.0, apex(c) + 0.5), (x + 3, 3.0, top + 3))
        script = (SETTLE, Hold(5.0, EAST, jump))
        return Exercise(pieces, (start, 0, 0.02), script, (kept,), nav=nav, forbidden=(zone,))

    return build


def step_up(c: Character) -> Exercise | None:
    """A step of the step height, at walking speed all the way."""
    if not c.step_height_m:
        return None
    height = c.step_height_m - 0.001  # a millimetre for the contact's depth
    pieces = (floor(-run_up(c) - 2, 14), stage(0, 14, height))
    top = Check("height [m]", end_height, height - 0.02, height + 0.02)

    def slowest(track: Track) -> float:
        return float(track.velocity[round(run_up(c) / c.walk_speed_mps / track.tick_s) :, 0].min())

    speed = Check("slowest [m/s]", slowest, 0.98 * c.walk_speed_mps)
    script = (SETTLE, Hold((run_up(c) + 6) / c.walk_speed_mps, EAST))
    return Exercise(pieces, (-run_up(c), 0, 0.02), script, (top, speed), required=((5, 0, height),))


def too_high(stick: int) -> Callable[[Character], Exercise]:
    """A step 5 cm higher than the step height, or than what the capsule's round end rolls over."""

    def build(c: Character) -> Exercise:
        height = max(c.step_height_m, round_end(c)) + 0.05
        half = 3.0 if stick == EAST else 14.0
        pieces = (floor(-run_up(c) - 2, 5, half_m=half), stage(0, 5, height, half))
        start = (-run_up(c), 0.0 if stick == EAST else 2 - half, 0.02)
        script = (SETTLE, Hold(3.0 if stick == EAST else 2.5, stick))
        return Exercise(pieces, start, script, (Check("highest [m]", highest, at_most=0.1),))

    return build


def stairs(c: Character) -> Exercise:
    """Eight steps up to a landing and down again."""
    rise = min(0.3, c.step_height_m) or 0.08
    steps = [stage(0.4 * i, 10 if i == 7 else 0.4 * (i + 1), rise * (i + 1)) for i in range(8)]
    top = 8 * rise
    ground = floor(-8, 10)
    up = Hold(9.0 / c.walk_speed_mps + 0.2, EAST)

    def landing(track: Track) -> float:
        return float(track.path[track.marks[1], 2])

    checks = (
        Check("landing [m]", landing, top - 0.05, top + 0.05),
        Check("highest [m]", highest, at_most=top + 0.05),
        Check("back down [m]", end_height, -0.05, 0.05),
    )
    script = (SETTLE, up, Hold(11.0 / c.walk_speed_mps, WEST), Hold(0.5))
    nav = (
        ground,
        slope("flight", "ramp", Rect(-0.4, -3, 2.8, 3), 0.0, top, "+x"),
        stage(2.8, 10, top),
    )
    start = (-4.0, 0.0, 0.02)
    return Exercise((ground, *steps), start, script, checks, nav=nav, required=((5, 0, top),))


def ramp_ends(c: Character) -> Exercise:
    """Up a ramp to its landing, and down again, at full speed over both of its ends."""
    way = ramp(0.0, 5.0, 25)
    x, top = end_of(way)
    pieces = (floor(-run_up(c) - 4, x + 6), way, stage(x, x + 6, top))
    up = (run_up(c) + x + 3) / c.walk_speed_mps
    flight = float((c.walk_speed_mps * np.tan(np.radians(25))) ** 2 / (2 * c.gravity_mps2))

    def landing(track: Track) -> float:
        return float(track.path[track.marks[1], 2])

    def off_the_ground(track: Track) -> float:
        """Furthest above the ground on the way down [m]: only who has no step-up flies off the crest."""
        path = track.path[track.marks[1] :]
        ground = np.clip(path[:, 0], 0, x) * np.tan(np.radians(25))
        return float((path[:, 2] - ground).max())

    checks = (
        Check("landing [m]", landing, top - 0.05, top + 0.05),
        Check("highest [m]", highest, at_most=top + 0.1),
        Check("back down [m]", end_height, -0.05, 0.05),
        Check("above ground [m]", off_the_ground, at_most=0.1 if c.step_height_m else flight + 0.1),
    )
    script = (SETTLE, Hold(up, EAST), Hold(up, WEST))
    return Exercise(pieces, (-run_up(c), 0, 0.02), script, checks, required=((x + 2, 0, top),))


def curb_and_crest(c: Character) -> Exercise:
    """Running over a curb, and off the crest of a ramp with nothing behind it: neither throws."""
    way = ramp(3.0, 4.0, 25)
    x, crest = end_of(way)
    curb = stage(0, 1, 0.06)
    ground = floor(-run_up(c) - 2, x + 2 * c.walk_speed_mps)
    script = (SETTLE, Hold((run_up(c) + x + 0.5) / c.walk_speed_mps + 0.3, EAST))
    check = Check("highest [m]", highest, crest - 0.1, crest + tick_rise(c, 25) + 0.02)
    return Exercise((ground, curb, way), (-run_up(c), 0, 0.02), script, (check,))


def ledge(c: Character) -> Exercise:
    """Standing with less than half of the foot on a ledge."""
    pieces = (floor(-5, 5), stage(-4, 0, 2.0))
    stays = Check("height [m]", end_height, 1.9, 2.1)
    still = Check("drifts [m]", lambda t: float(np.ptp(t.path[t.last(2.0), 0])), at_most=0.01)
    start = (0.3 * c.radius_m, 0.0, 2.02)
    return Exercise(pieces, start, (Hold(3.0),), (stays, stands(), still), spawn=(-2, 0, 2.02))


EXERCISES = {
    "walking speed": walking_speed,
    "slope of the limit - 1 degree": slope_below(run=False),
    "slope of the limit - 1 degree, run-up": slope_below(run=True),
    "slope of the limit + 1 degree": slope_above(run=False, jump=False),
    "slope of the limit + 1 degree, run-up": slope_above(run=True, jump=False),
    "slope of the limit + 1 degree, jumping": slope_above(run=False, jump=True),
    "slope of the limit + 1 degree, run-up, jumping": slope_above(run=True, jump=True),
    "step of the step height": step_up,
    "step 5 cm too high": too_high(EAST),
    "step 5 cm too high, aslant": too_high(NORTH_EAST),
    "stairs, both ends": stairs,
    "ramp, both ends": ramp_ends,
    "curb and crest": curb_and_crest,
    "standing at a ledge": ledge,
}
