"""Rapier's character controller as a body that walks a level, and a plain search with it.

Rapier only moves a shape so far as obstacles let it; the rest of a character is written here: instant walking speed on
the ground; in the air the velocity it had, gravity, and as much air control as ours has.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import cos, radians
from typing import Any

import numpy as np

from reachtest.records import Floats, Level

TICK_S = 1 / 60
EPISODE_TICKS = 384  # the reference's
EPISODES_AT_ONCE = 64  # between two looks at what was found, as it is costly to weigh it
SKIN_M, SNAP_M, GROUND_M = 0.01, 0.2, 0.04
STICK_TICKS, JUMP_RATE = 20, 0.03  # a direction is held for 20 ticks on average


@dataclass
class Body:
    """One character: where its feet are, how fast it moves [m/s], and whether it stands."""

    x: float
    y: float
    z: float
    vx: float = 0.0
    vy: float = 0.0
    vz: float = 0.0
    grounded: bool = False


@dataclass(frozen=True)
class Opinion:
    """Where a character stood [n, 3] and stood last before each fall [m, 3], in level coordinates."""

    stood: Floats
    exits: Floats


class RapierCharacter:
    """Moves bodies by Rapier's KinematicCharacterController through the triangles of a level."""

    def __init__(self, rapier: Any, level: Level, step_width_m: float) -> None:
        self.character = c = level.character
        world = self._world = rapier.PhysicsWorld()
        vertices, faces = np.unique(level.collision.reshape(-1, 3).round(5), axis=0, return_inverse=True)
        triangles = faces.reshape(-1, 3)
        sides = (triangles != np.roll(triangles, 1, axis=1)).all(axis=1)
        world.add_collider(
            rapier.Collider.trimesh(vertices.astype(np.float32), triangles[sides].astype(np.uint32))
        )
        world.detect_collisions()
        world.update_query_pipeline()
        limit = radians(c.slope_limit_deg)
        rules = {
            "up": (0, 0, 1),
            "offset": SKIN_M,
            "max_slope_climb_angle": limit,
            "min_slope_slide_angle": limit,
        }
        step = rapier.CharacterAutostep(c.step_height_m, step_width_m, False)
        self._standing = rapier.KinematicCharacterController(autostep=step, snap_to_ground=SNAP_M, **rules)
        self._flying = rapier.KinematicCharacterController(autostep=None, snap_to_ground=None, **rules)
        self._shape = rapier.SharedShape.capsule_z(c.height_m / 2 - c.radius_m, c.radius_m)
        self._below = rapier.ShapeCastOptions(max_time_of_impact=GROUND_M)
        self._walkable = cos(limit)
        self._at = rapier.Isometry3.from_translation

    def tick(self, body: Body, stick: tuple[float, float], jump: bool) -> None:
        """Move `body` for one tick with the stick (unit or zero) held."""
        c = self.character
        self._push(body, stick)
        jumps = jump and body.grounded
        lost = (
            c.gravity_mps2 * TICK_S
        )  # half of it in the tick of the jump: then all lie on the exact parabola
        body.vz = c.jump_speed_mps - lost / 2 if jumps else body.vz - lost
        body.vz = max(body.vz, -c.terminal_speed_mps)
        rules = self._standing if body.grounded and not jumps else self._flying
        wanted = (body.vx * TICK_S, body.vy * TICK_S, body.vz * TICK_S)
        middle = self._at(body.x, body.y, body.z + c.height_m / 2)
        w = self._world
        moved = rules.move_shape(
            TICK_S, w.rigid_bodies, w.colliders, w.query_pipeline, self._shape, middle, wanted
        )
        by = moved.translation
        body.x, body.y, body.z = body.x + by.x, body.y + by.y, body.z + by.z
        self._keep(body, by.x / TICK_S, by.y / TICK_S, by.z / TICK_S)
        body.grounded = body.vz <= 0 and bool(moved.grounded) and self._stands(body)
        if body.grounded:
            body.vz = 0.0

    def _stands(self, body: Body) -> bool:
        """Whether what it rests on is walkable: Rapier calls a body grounded on what is too steep as well."""
        middle = self._at(body.x, body.y, body.z + self.character.height_m / 2)
        found = self._world.query_pipeline.cast_shape(middle, (0, 0, -1), self._shape, self._below)
        return found is not None and found[1].normal1.z >= self._walkable

    def _push(self, body: Body, stick: tuple[float, float]) -> None:
        """Horizontal velocity: the stick's on the ground; drift by air control off it."""
        c = self.character
        if body.grounded:
            body.vx, body.vy = stick[0] * c.walk_speed_mps, stick[1] * c.walk_speed_mps
            return
        push = c.air_control * c.acceleration_mps2 * TICK_S
        vx, vy = body.vx + stick[0] * push, body.vy + stick[1] * push
        over = max(1.0, (vx * vx + vy * vy) ** 0.5 / c.walk_speed_mps)
        body.vx, body.vy = vx / over, vy / over

    @staticmethod
    def _keep(body: Body, vx: float, vy: float, vz: float) -> None:
        """No faster than it got on: walls and ceilings take the rest."""
        before, after = (body.vx**2 + body.vy**2) ** 0.5, (vx * vx + vy * vy) ** 0.5
        share = min(1.0, before / after) if after else 0.0  # a step up may carry it further than asked
        body.vx, body.vy = vx * share, vy * share
        if body.vz > 0:
            body.vz = max(0.0, min(body.vz, vz))


class Search:
    """Go-Explore in its simplest form: restart where few have been, walk at random."""

    def __init__(self, character: RapierCharacter, level: Level, seed: int, jumping: bool) -> None:
        self._character, self._level, self._jumping = character, level, jumping
        self._rng = np.random.default_rng(seed)
        self._cells: dict[tuple[int, int, int], Body] = {}
        self._visits: dict[tuple[int, int, int], int] = {}
        self._stood: dict[tuple[int, int, int], tuple[float, float, float]] = {}
        self._exits: list[tuple[float, float, float]] = []
        turns = np.arange(8) * (np.pi / 4)
        self._sticks = [(0.0, 0.0), *zip(np.cos(turns).tolist(), np.sin(turns).tolist(), strict=True)]

    def run(self, ticks: int) -> Opinion:
        """Episodes from the spawn and from what they found, for `ticks` ticks."""
        x, y, z = self._level.spawns[0].position.tolist()
        self._see(Body(x, y, z + SKIN_M))
        done = 0
        while done < ticks:
            weights = 1.0 / (1.0 + np.array(list(self._visits.values())))
            chosen = self._rng.choice(len(weights), EPISODES_AT_ONCE, p=weights / weights.sum())
            starts = list(self._cells.values())
            done += sum(self._episode(replace(starts[i])) for i in chosen)
        return Opinion(np.array(list(self._stood.values())), np.array(self._exits).reshape(-1, 3))

    def _episode(self, body: Body) -> int:
        rng, seen = self._rng, set()
        change = (rng.random(EPISODE_TICKS) < 1 / STICK_TICKS).tolist()
        sticks = rng.integers(0, len(self._sticks), EPISODE_TICKS).tolist()
        jumps = (rng.random(EPISODE_TICKS) < (JUMP_RATE if self._jumping else 0)).tolist()
        footing = (body.x, body.y, body.z)
        stick = self._sticks[sticks[0]]
        for t in range(EPISODE_TICKS):
            stick = self._sticks[sticks[t]] if change[t] else stick
            self._character.tick(body, stick, jumps[t])
            if self._left(body):
                self._exits.append(footing)
                break
            if body.grounded:
                footing = (body.x, body.y, body.z)
                self._stood.setdefault(
                    (int(body.x * 4 // 1), int(body.y * 4 // 1), int(body.z * 4 // 1)), footing
                )
            seen.add(self._see(body))
        for cell in seen:
            self._visits[cell] += 1
        return t + 1

    def _see(self, body: Body) -> tuple[int, int, int]:
        cell = (int(body.x // 1), int(body.y // 1), int(body.z // 1))
        if cell not in self._cells:
            self._cells[cell], self._visits[cell] = replace(body), 0
        return cell

    def _left(self, body: Body) -> bool:
        low, high = self._level.bounds
        inside = low[0] <= body.x <= high[0] and low[1] <= body.y <= high[1] and body.z <= high[2]
        return body.z < self._level.kill_z_m or not inside
