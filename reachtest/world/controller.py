"""The character's movement rules, for all agents at once.

Shape legend: B agents, K contact slots, n agents with obstacles. Velocities are [m/s]; normals point from the
surface to the capsule.
The rules follow what engine characters have in common (Unreal's CharacterMovement is the reference): on walkable
ground the horizontal velocity is kept and the vertical one follows the slope; what is too steep counts as a
vertical wall, so that neither drive nor momentum climbs it; in the air there is little control.

This runs at every physics step: it is written for few numpy calls, and works on the agents concerned only.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from reachtest.geometry import indices
from reachtest.records import Bools, Character, Floats, Ints
from reachtest.walking import Walk
from reachtest.world.contacts import WALL_NZ, Contacts

STICK_MPS = 0.02  # towards the ground, so that contact is kept; the contact takes it up
GROOVE_NZ = 0.2  # a normal with less of a vertical part carries nobody
GROOVE_RISE = 0.05  # sine: in one that rises more one slides
AT_REST = 0.3  # of what gravity gives in a tick: who flies is not so slow for two in a row
LEAVING_MPS = 0.5  # faster away from a surface than this is a jump, not a landing


@dataclass(frozen=True)
class Plan:
    """The velocity every agent should have after the next physics step, as far as contacts let it."""

    velocity: Floats  # [B, 3]
    uncut: Floats  # [B, 2] horizontal velocity before obstacles took their share
    jumped: Bools  # [B]


@dataclass(frozen=True)
class Stick:
    """What the gamepads say, prepared for the ticks of one agent step."""

    wish: Floats  # [B, 2] unit or zero
    jump: Bools  # [B]
    centred: Ints  # agents that push nowhere


class Controller:
    """Plans velocities; holds no state of its own."""

    def __init__(self, character: Character, timestep_s: float) -> None:
        self.character = c = character
        self.slope_cos = float(np.cos(np.radians(c.slope_limit_deg)))
        self._g_dt = c.gravity_mps2 * timestep_s
        self._rule = Walk.of(c, timestep_s)
        self._air_push = c.air_control * c.acceleration_mps2 * timestep_s

    def plan(self, velocity: Floats, contacts: Contacts, grounded: Bools, stick: Stick) -> Plan:
        """Velocities after the next physics step from the current ones [B, 3] and who stands [B]."""
        uncut = self._walk(velocity[:, :2], stick)
        flying = indices(~grounded)
        if len(flying):
            uncut[flying] = self._drift(velocity[flying, :2], stick.wish[flying])
        cut = uncut
        if len(contacts.ids):
            cut = uncut.copy()
            cut[contacts.ids] = cut_by_obstacles(uncut[contacts.ids], contacts.flat)
        target = np.empty_like(velocity)
        target[:, :2] = cut
        self._follow_ground(target, contacts)
        if len(flying):
            fall = velocity[flying, 2] - self._g_dt
            target[flying, :2] = cut[flying]
            target[flying, 2] = np.maximum(fall, -self.character.terminal_speed_mps)
        jumped = grounded & stick.jump
        # Half a step of gravity less than the full speed: then every step lies on the exact parabola.
        target[jumped, 2] = self.character.jump_speed_mps - self._g_dt / 2
        return Plan(target, uncut, jumped)

    def grounded(self, velocity: Floats, contacts: Contacts, before: Bools) -> Bools:
        """Who stands [B]: touches something walkable without moving away from it, or kept touching it, or rests in
        a groove."""
        touches: Bools = np.asarray(contacts.walkable.any(axis=1))
        unsure = indices(touches & ~before)
        if len(unsure):
            leaving = (contacts.normals[unsure] * velocity[unsure, None, :]).sum(axis=2)
            touches[unsure] = (contacts.walkable[unsure] & (leaving < LEAVING_MPS)).any(axis=1)
        resting = contacts.ids[~touches[contacts.ids] & (np.abs(velocity[contacts.ids, 2]) < LEAVING_MPS)]
        if len(resting):
            touches[resting] = self._in_groove(contacts.normals[resting])
        return touches

    def jammed(self, velocity: Floats, contacts: Contacts, stands: Bools) -> Ints:
        """Who [n] of those that do not stand [B] is held up by something in a slot, a crevice or a funnel.

        Nothing moves. If that lasts, one has landed, and may jump out (Unreal's PhysFalling, where a move ends as it
        begins); for a tick everybody is at rest at the top of a jump.
        """
        ids = contacts.ids[~stands[contacts.ids]]
        ids = ids[np.abs(velocity[ids]).max(axis=1, initial=0.0) < AT_REST * self._g_dt]
        return ids[(contacts.normals[ids, :, 2] > GROOVE_NZ).any(axis=1)]

    def _in_groove(self, normals: Floats) -> Bools:
        """Who [n] of contact `normals` [n, K, 3] is carried by two sides of a level groove, none of them walkable: the
        edges of a gap that is too narrow, the foot of two roofs. From there one may jump (Unreal's PhysFalling, which
        calls it a ditch). Along a wall there is none: the joints of its blocks would be one."""
        rises = normals[:, :, 2]
        carries, wall = rises > GROOVE_NZ, (rises < WALL_NZ) & (normals[:, :, :2] != 0.0).any(axis=2)
        result: Bools = np.asarray((carries.sum(axis=1) > 1) & ~wall.any(axis=1), dtype=np.bool_)
        rows = indices(result)
        if len(rows):
            sides = np.where(carries[rows, :, None], normals[rows], 0.0)
            along = np.cross(sides[:, :, None], sides[:, None])
            level = np.abs(along[..., 2]) <= GROOVE_RISE * np.linalg.norm(along, axis=3)
            opposed = sides @ sides.transpose(0, 2, 1) < 0.0
            result[rows] = (opposed & level).any(axis=(1, 2))
        return result

    def _walk(self, flat: Floats, stick: Stick) -> Floats:
        """Ground velocity [B, 2]: towards the stick, or braking."""
        speed = np.hypot(flat[:, 0], flat[:, 1])
        result = self._rule.towards(flat, speed, stick.wish)
        if len(stick.centred):
            result[stick.centred] = self._rule.braked(flat[stick.centred], speed[stick.centred])
        return result

    def _drift(self, flat: Floats, wish: Floats) -> Floats:
        """Air velocity: a little acceleration towards the stick, never beyond the speed it has or may walk."""
        limit = np.maximum(np.hypot(flat[:, 0], flat[:, 1]), self.character.walk_speed_mps)
        drifted = flat + wish * self._air_push
        length = np.hypot(drifted[:, 0], drifted[:, 1])
        return np.asarray(drifted * (limit / np.maximum(length, limit))[:, None], dtype=np.float64)

    @staticmethod
    def _follow_ground(target: Floats, contacts: Contacts) -> None:
        """Complete horizontal velocities `target` [B, 3] so that they keep to the ground, in place.

        Of several walkable contacts the one that rises most counts. Without any the velocity is level.
        """
        normals = contacts.normals
        rise = -(normals[:, :, 0] * target[:, 0, None] + normals[:, :, 1] * target[:, 1, None])
        rise = np.where(contacts.walkable, rise / np.maximum(normals[:, :, 2], 0.1), -np.inf)
        best = rise.argmax(axis=1)
        rows = np.arange(len(target))
        steepest = rise[rows, best]
        has = steepest > -np.inf
        target[:, 2] = np.where(has, steepest, -STICK_MPS)
        target -= (STICK_MPS * has)[:, None] * normals[rows, best]


def cut_by_obstacles(velocity: Floats, flat: Floats) -> Floats:
    """The velocity [n, 2] nearest to the wanted one that does not go into any obstacle normal [n, K, 2].

    In the plane the solution is the velocity itself, its projection on one obstacle's tangent, or a stop.
    """
    into = np.minimum(flat[:, :, 0] * velocity[:, 0, None] + flat[:, :, 1] * velocity[:, 1, None], 0.0)
    if not into.any():
        return velocity
    candidates = velocity[:, None, :] - into[:, :, None] * flat  # [n, K, 2]
    clear = (candidates @ flat.transpose(0, 2, 1)).min(axis=2) > -1e-6
    # What is not pushed against is no candidate (its projection is the velocity itself), unless nothing is.
    pushed = into < 0
    free = ~pushed.any(axis=1, keepdims=True)
    cost = np.where(clear & (pushed | free), -into, np.inf)
    best = cost.argmin(axis=1)
    rows = np.arange(len(velocity))
    possible = cost[rows, best] < np.inf
    return np.asarray(candidates[rows, best] * possible[:, None], dtype=np.float64)
