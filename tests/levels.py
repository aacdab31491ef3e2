"""Small levels for tests: triangles from boxes and ramps, a level record, a character walking a script."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from reachtest.geometry import grid_surface
from reachtest.levels import PRESETS
from reachtest.records import (
    Character,
    ExploreSettings,
    Floats,
    Frame,
    GateSettings,
    HeightField,
    Level,
    NavMesh,
    Spawn,
)
from reachtest.world import MujocoSimulator

UNREAL = PRESETS["unreal"]


def box(low: Sequence[float], high: Sequence[float]) -> Floats:
    """The 12 triangles of an axis-aligned box, normals outwards."""
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
    corners = np.array(low) + corners * (np.array(high) - np.array(low))
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return corners[[[a, b, c] for p, q, r, s in quads for a, b, c in ((p, q, r), (p, r, s))]]


def slope(degrees: float, length: float = 20.0, width: float = 10.0, x: float = 0.0) -> Floats:
    """A one-sided ramp that rises along +x from z = 0."""
    c, s = length * np.cos(np.radians(degrees)), length * np.sin(np.radians(degrees))
    w = width / 2
    a, b, d, e = [x, -w, 0], [x + c, -w, s], [x + c, w, s], [x, w, 0]
    return np.array([[a, b, d], [a, d, e]], dtype=float)


def with_terrain(where: Level, field: HeightField) -> Level:
    """The level and a terrain, its triangles last."""
    collision = np.concatenate([where.collision, grid_surface(field.points)])
    field = replace(field, first=len(where.collision))
    return replace(where, collision=collision, height_fields=(*where.height_fields, field))


FLOOR = box([-60, -60, -1], [60, 60, 0])


def level(
    *pieces: Floats,
    character: Character = UNREAL,
    explore: ExploreSettings | None = None,
    kill_z_m: float = -50.0,
    spawn: Sequence[float] = (0.0, 0.0, 0.02),
    navmesh: Floats | None = None,
) -> Level:
    """A level of triangle arrays [F, 3, 3]; the nav-mesh is triangles, by default a patch of floor."""
    nav = np.array([[[-9, -9, 0], [9, -9, 0], [9, 9, 0]]], dtype=float) if navmesh is None else navmesh
    return Level(
        name="test",
        file=Path("level.yaml"),
        sha256="",
        frame=Frame(np.eye(3), "z", "m"),
        collision=np.concatenate(pieces),
        solids=(),
        parts=(),
        navmesh=NavMesh("nav.obj", nav.reshape(-1, 3), np.arange(3 * len(nav)).reshape(-1, 3)),
        character=character,
        spawns=(Spawn("spawn", np.array(spawn, dtype=float)),),
        kill_z_m=kill_z_m,
        bounds=(np.full(3, -1e3), np.full(3, 1e3)),
        zones=(),
        required=(),
        explore=explore or ExploreSettings(),
        gate=GateSettings(("fell_out_of_world", "unexpected_area")),
    )


STILL, EAST, NORTH_EAST, NORTH, WEST, SOUTH_EAST = 0, 1, 2, 3, 5, 8


class Walk:
    """One character that follows a script; remembers every control tick."""

    def __init__(
        self,
        *pieces: Floats,
        start: Sequence[float],
        character: Character = UNREAL,
        terrain: HeightField | None = None,
    ) -> None:
        where = level(*pieces, character=character, explore=ExploreSettings(action_repeat=1), spawn=start)
        self._simulator = MujocoSimulator(with_terrain(where, terrain) if terrain else where, 1, 1)
        self._simulator.restore(np.array([0]), self._simulator.place(np.array([start], dtype=float)))
        self.dt = self._simulator.step_s
        self.positions: list[Floats] = [np.array(start, dtype=float)]
        self.grounded: list[bool] = [False]

    def go(self, seconds: float, stick: int = STILL, jump: bool = False) -> Walk:
        """Hold the stick (and the jump button) for a while."""
        for _ in range(max(1, round(seconds / self.dt))):
            result = self._simulator.step(np.array([[stick, jump]], dtype=np.int8))
            self.positions.append(result.positions[0])
            self.grounded.append(bool(result.grounded[0]))
        return self

    @property
    def here(self) -> Floats:
        """Where the character is now [3]."""
        return self.positions[-1]

    @property
    def path(self) -> Floats:
        """Every position [n, 3]."""
        return np.array(self.positions)

    @property
    def velocity(self) -> Floats:
        """Velocity over every tick [n - 1, 3]."""
        return np.diff(self.path, axis=0) / self.dt
