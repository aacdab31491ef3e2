"""The character's movement rules, for all agents at once.

Shape legend: B agents, K contact slots. Velocities are [m/s], normals point from the surface to the capsule.
The rules follow what engine characters have in common (Unreal's CharacterMovement is the reference): on walkable
ground the horizontal velocity is kept and the vertical one follows the slope; what is too steep counts as a
vertical wall, so that neither drive nor momentum climbs it; in the air there is little control.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from reachtest.records import Bools, Character, Floats

STICK_MPS = 0.02  # towards the ground, so that contact is kept; the contact takes it up
WALL_NZ = 0.02  # flatter than this against vertical: neither floor nor slope
BLOCKED_COS = 0.25  # the stick must point this much into an obstacle to want to step onto it
STICK_DIRECTIONS = np.concatenate(
    [np.zeros((1, 2)), [[np.cos(a), np.sin(a)] for a in np.arange(8) * (np.pi / 4)]]
)  # [9, 2]


@dataclass(frozen=True)
class Contacts:
    """What the capsules touch."""

    normals: Floats  # [B, K, 3] zero in empty slots
    distance: Floats  # [B, K] negative where they overlap [m]
    walkable: Bools  # [B, K]
    blocking: Bools  # [B, K] walls, steep slopes, overhangs: everything with a horizontal say that is not ground
    flat: Floats  # [B, K, 2] horizontal unit normals of the blocking ones, else zero


@dataclass(frozen=True)
class Plan:
    """The velocity every agent should have after the next physics step, as far as contacts let it."""

    velocity: Floats  # [B, 3]
    uncut: Floats  # [B, 2] horizontal velocity before obstacles took their share
    jumped: Bools  # [B]


def read_contacts(sensor: Floats, slope_cos: float) -> Contacts:
    """Sort the contact sensor's slots [B, K, 5] (found, dist, normal from the capsule)."""
    normals = -sensor[:, :, 2:5]
    found = sensor[:, :, 0] > 0
    z = normals[:, :, 2]
    walkable = found & (z >= slope_cos)
    length = np.sqrt(np.maximum(1.0 - z * z, 0.0))
    blocking = found & ~walkable & (length > WALL_NZ)
    flat = np.where(blocking[:, :, None], normals[:, :, :2] / np.where(blocking, length, 1.0)[:, :, None], 0.0)
    return Contacts(normals, sensor[:, :, 1], walkable, blocking, flat)


class Controller:
    """Plans velocities; holds no state of its own."""

    def __init__(self, character: Character, timestep_s: float) -> None:
        self.character = character
        self.dt = timestep_s
        self.slope_cos = float(np.cos(np.radians(character.slope_limit_deg)))

    def plan(
        self, velocity: Floats, contacts: Contacts, grounded: Bools, wish: Floats, jump: NDArray[np.bool_]
    ) -> Plan:
        """Velocities after the next step from the current ones [B, 3], the stick [B, 2] and the jump button [B]."""
        flat = velocity[:, :2]
        uncut = np.where(grounded[:, None], self._walk(flat, wish), self._drift(flat, wish))
        cut = cut_by_obstacles(uncut, contacts.flat)
        target = np.empty_like(velocity)
        target[:, :2] = cut
        g_dt = self.character.gravity_mps2 * self.dt
        falling = np.maximum(velocity[:, 2] - g_dt, -self.character.terminal_speed_mps)
        climb, support = self._follow_ground(contacts, cut)
        target[:, 2] = np.where(grounded, climb, falling)
        target -= np.where(grounded[:, None], STICK_MPS * support, 0.0)
        jumped = grounded & jump
        # Half a step of gravity less than the full speed: then every step lies on the exact parabola.
        target[:, 2] = np.where(jumped, self.character.jump_speed_mps - g_dt / 2, target[:, 2])
        return Plan(target, uncut, jumped)

    def _walk(self, flat: Floats, wish: Floats) -> Floats:
        """Ground velocity: friction turns it towards the stick, then it accelerates or brakes.

        The update of Unreal's UCharacterMovementComponent::CalcVelocity, in its documented parameters.
        """
        c = self.character
        pushing = (wish * wish).sum(axis=1) > 0
        speed = np.sqrt((flat * flat).sum(axis=1))
        turn = min(c.ground_friction * self.dt, 1.0)
        turned = flat - (flat - wish * speed[:, None]) * turn + wish * (c.acceleration_mps2 * self.dt)
        turned *= (c.walk_speed_mps / np.maximum(np.sqrt((turned * turned).sum(axis=1)), c.walk_speed_mps))[:, None]
        slower = np.maximum(speed - (c.ground_friction * speed + c.braking_mps2) * self.dt, 0.0)
        braked = flat * (slower / np.maximum(speed, 1e-9))[:, None]
        return np.where(pushing[:, None], turned, braked)

    def _drift(self, flat: Floats, wish: Floats) -> Floats:
        """Air velocity: a little acceleration towards the stick, never beyond the speed it has or may walk."""
        c = self.character
        speed = np.sqrt((flat * flat).sum(axis=1))
        drifted = flat + wish * (c.air_control * c.acceleration_mps2 * self.dt)
        limit = np.maximum(speed, c.walk_speed_mps)
        length = np.sqrt((drifted * drifted).sum(axis=1))
        return drifted * (limit / np.maximum(length, limit))[:, None]

    @staticmethod
    def _follow_ground(contacts: Contacts, flat: Floats) -> tuple[Floats, Floats]:
        """Vertical velocity [B] that keeps to the ground, and the normal [B, 3] of what supports the agent."""
        nz = np.where(contacts.walkable, contacts.normals[:, :, 2], 1.0)
        rise = -(contacts.normals[:, :, :2] * flat[:, None, :]).sum(axis=2) / nz
        rise = np.where(contacts.walkable, rise, -np.inf)
        best = rise.argmax(axis=1)
        rows = np.arange(len(flat))
        has = contacts.walkable[rows, best]
        up = np.array([0.0, 0.0, 1.0])
        support = np.where(has[:, None], contacts.normals[rows, best], up)
        return np.where(has, rise[rows, best], 0.0), support

    def grounded(self, velocity: Floats, contacts: Contacts, before: Bools) -> Bools:
        """Who stands: touches something walkable without moving away from it, or kept touching it."""
        leaving = (contacts.normals * velocity[:, None, :]).sum(axis=2)
        return (contacts.walkable & (before[:, None] | (leaving < 0.5))).any(axis=1)


def cut_by_obstacles(velocity: Floats, flat: Floats) -> Floats:
    """The velocity [B, 2] nearest to the wanted one that does not go into any obstacle normal [B, K, 2].

    In the plane the solution is the velocity itself, its projection on one obstacle's tangent, or a stop.
    """
    into = (velocity[:, None, :] * flat).sum(axis=2)  # [B, K]
    if not (into < 0).any():
        return velocity
    candidates = velocity[:, None, :] - np.minimum(into, 0.0)[:, :, None] * flat  # [B, K, 2]
    clear = (np.einsum("bki,bli->bkl", candidates, flat) > -1e-6).all(axis=2)
    cost = np.where(clear, -np.minimum(into, 0.0), np.inf)
    free = (into >= 0).all(axis=1)
    # An obstacle that is not pushed against is no candidate: its projection is the velocity itself.
    cost = np.where((into < 0), cost, np.inf)
    best = cost.argmin(axis=1)
    rows = np.arange(len(velocity))
    stopped = ~np.isfinite(cost[rows, best])
    cut = np.where(stopped[:, None], 0.0, candidates[rows, best])
    return np.where(free[:, None], velocity, cut)
