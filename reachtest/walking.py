"""How a walking character's horizontal velocity follows the stick: the rule it moves by, and leaps are worked out with.

The update of Unreal's UCharacterMovementComponent::CalcVelocity, in its documented parameters.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from reachtest.records import Bools, Character, Floats, Ints

STICK_DIRECTIONS = np.concatenate(
    [np.zeros((1, 2)), [[np.cos(a), np.sin(a)] for a in np.arange(8) * (np.pi / 4)]]
)  # [9, 2] what an action's stick means: centred, then by 45 degrees
AT_REST_MPS = 0.05


@dataclass(frozen=True)
class Walk:
    """The rule for one time step."""

    turn: float  # share of the velocity that turns towards the stick
    push: float  # [m/s] that are added towards it
    brake: float  # [m/s] that are lost without a stick
    most: float  # [m/s]
    step_s: float  # [s]

    @classmethod
    def of(cls, who: Character, timestep_s: float) -> Walk:
        """The rule of `who` for steps of `timestep_s`."""
        turn = min(who.ground_friction * timestep_s, 1.0)
        push, brake = who.acceleration_mps2 * timestep_s, who.braking_mps2 * timestep_s
        return cls(turn, push, brake, who.walk_speed_mps, timestep_s)

    def towards(self, flat: Floats, speed: Floats, wish: Floats) -> Floats:
        """Velocities [B, 2] a step after `flat` [B, 2], which are so fast [B], with sticks `wish` [B, 2] (unit or 0).

        Friction turns them towards the stick, then they grow, at the most to walking speed.
        """
        result = flat * (1.0 - self.turn) + wish * (speed * self.turn + self.push)[:, None]
        reached = np.hypot(result[:, 0], result[:, 1])
        result *= (self.most / np.maximum(reached, self.most))[:, None]
        return result

    def braked(self, flat: Floats, speed: Floats) -> Floats:
        """Velocities [n, 2] one step after `flat` [n, 2], which are so fast [n], without a stick."""
        after = np.maximum(speed * (1.0 - self.turn) - self.brake, 0.0)
        return np.asarray(flat * (after / np.maximum(speed, 1e-9))[:, None], dtype=np.float64)

    def step(self, velocity: Floats, sticks: Ints) -> Floats:
        """Velocities [n, 2] one step after `velocity` [n, 2] with `sticks` [n], 0 to 8."""
        speed = np.hypot(velocity[:, 0], velocity[:, 1])
        pushed = self.towards(velocity, speed, STICK_DIRECTIONS[sticks])
        return np.where(sticks[:, None] > 0, pushed, self.braked(velocity, speed))

    def run_out(self, velocity: Floats, steps: int) -> tuple[Floats, Bools]:
        """How far [n, 2] who has `velocity` [n, 2] gets in `steps` without a stick, and who is at rest [n] by then."""
        way = np.zeros_like(velocity)
        for _ in range(steps):
            velocity = self.braked(velocity, np.hypot(velocity[:, 0], velocity[:, 1]))
            way += velocity * self.step_s
        return way, np.hypot(velocity[:, 0], velocity[:, 1]) < AT_REST_MPS

    def way(self, sticks: Ints, repeat: int) -> Floats:
        """Where [n, T + 1, 2] one is, from rest at (0, 0) on, who pushes `sticks` [n, T], each for `repeat` steps."""
        places = np.zeros((len(sticks), sticks.shape[1] + 1, 2))
        place, velocity = places[:, 0].copy(), np.zeros((len(sticks), 2))
        for number, stick in enumerate(sticks.T, start=1):
            for _ in range(repeat):
                velocity = self.step(velocity, stick)
                place += velocity * self.step_s
            places[:, number] = place
        return places
