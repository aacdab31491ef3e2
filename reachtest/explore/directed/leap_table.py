"""What becomes of each leap that can be asked for: where it takes off, and where it lands if nothing is in the way.

Shape legend: L leaps, as `aimed_leap` counts them; n characters.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from reachtest.explore.aimed import AIMED_LEAPS, LEAP_FLIGHT_STEPS, WAIT_STEPS, aimed_leap
from reachtest.explore.directed.gaps import flight_s
from reachtest.records import Bools, Character, ExploreSettings, Floats
from reachtest.walking import STICK_DIRECTIONS, Walk

RISE_M = 0.05  # within it flights last as long


@dataclass(frozen=True)
class TakeOffs:
    """Where the leaps take off when they begin at rest, how fast, and where they push in the air."""

    places: Floats  # [L, 2]
    velocities: Floats  # [L, 2]
    pushes: Floats  # [L, 2] unit vectors


class LeapTable:
    """All leaps of a character, from rest at (0, 0)."""

    def __init__(self, who: Character, settings: ExploreSettings) -> None:
        self._who, self._settings = who, settings
        self._rule = Walk.of(who, 1.0 / settings.physics_hz)
        self.take_offs = _take_offs(self._rule, settings)
        self._lands: dict[int, Floats] = {}  # [L, 2] by rise

    def lands(self, rise_m: float) -> Floats:
        """Where they land [L, 2], `rise_m` higher than they take off."""
        rise = round(rise_m / RISE_M)
        if rise not in self._lands:
            flown = self._flown(float(flight_s(self._who, rise * RISE_M)))
            self._lands[rise] = self.take_offs.places + flown
        return self._lands[rise]

    def run_out(self, velocity: Floats) -> tuple[Floats, Bools]:
        """How far [n, 2] who has `velocity` [n, 2] gets before the leap begins, and who is at rest [n] by then."""
        return self._rule.run_out(velocity, WAIT_STEPS * self._settings.action_repeat)

    def _flown(self, time_s: float) -> Floats:
        """How far they get in the air within `time_s` [L, 2]: the stick pushes on there, as far as it can."""
        who, velocity = self._who, self.take_offs.velocities
        pushed_s = min(time_s, LEAP_FLIGHT_STEPS * self._settings.action_repeat / self._settings.physics_hz)
        after = velocity + who.air_control * who.acceleration_mps2 * pushed_s * self.take_offs.pushes
        most = np.maximum(np.hypot(velocity[:, 0], velocity[:, 1]), who.walk_speed_mps)
        after *= (most / np.maximum(np.hypot(after[:, 0], after[:, 1]), most))[:, None]
        return np.asarray((velocity + after) / 2 * pushed_s + after * (time_s - pushed_s), dtype=np.float64)


def _take_offs(rule: Walk, settings: ExploreSettings) -> TakeOffs:
    leaps = [aimed_leap(number) for number in range(AIMED_LEAPS)]
    last = np.array([leap[:, 1].argmax() for leap in leaps])
    sticks = np.zeros((AIMED_LEAPS, last.max() + 1), dtype=np.int64)
    for number, leap in enumerate(leaps):
        sticks[number, : last[number] + 1] = leap[: last[number] + 1, 0]
    place, velocity = np.zeros((AIMED_LEAPS, 2)), np.zeros((AIMED_LEAPS, 2))
    places, velocities = place.copy(), velocity.copy()
    for step, stick in enumerate(sticks.T):
        for tick in range(settings.action_repeat):
            velocity = rule.step(velocity, stick)
            if tick == 0:  # it jumps with the velocity of this tick, before it moves
                now = last == step
                places[now], velocities[now] = place[now], velocity[now]
            place = place + velocity / settings.physics_hz
    return TakeOffs(places, velocities, STICK_DIRECTIONS[sticks[np.arange(AIMED_LEAPS), last]])
