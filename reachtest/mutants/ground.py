"""The unmutated level as the flood fill sees it: what may be mutated, and what a mutant is compared with.

Shape legend: N places, G goals, W walked places, n of them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from reachtest.mutants.field import Field, build_field, level_grid
from reachtest.mutants.flood import POSSIBLE, SURE, reach, spawn_places
from reachtest.mutants.moves import Moves, moves_of
from reachtest.records import Bools, Floats, Ints, Level
from reachtest.surface import SurfaceIndex

ON_MESH_M = 0.5  # a nav-mesh floats, and ends a radius off the walls


@dataclass(frozen=True)
class Ground:
    """A level, and where one gets to in it."""

    level: Level
    goals: Floats  # [G, 3] what the tester has to reach
    field: Field
    moves: Moves
    sure: Bools  # [N] places that are reached
    possible: Bools  # [N] places that may be
    walked: Ints  # [W] reached for sure, walkable, and on the nav-mesh

    @property
    def sure_places(self) -> Floats:
        """Positions [n, 3] of what is reached."""
        return self.field.positions[self.sure]

    @property
    def top_m(self) -> float:
        """Where fields of this level end."""
        return float(self.level.collision[:, :, 2].max())


def survey_ground(level: Level, goals: Floats) -> Ground:
    """Flood the level from its spawns."""
    who = level.character
    grid = level_grid(level.collision, who)
    top = float(level.collision[:, :, 2].max())
    field = build_field(level.collision, who, grid, level.kill_z_m, top)
    moves = moves_of(field)
    seeds = spawn_places(field, np.array([spawn.position for spawn in level.spawns]))
    sure = reach(field, moves, who, seeds, SURE)
    possible = reach(field, moves, who, seeds, POSSIBLE)
    standing = np.flatnonzero(sure & field.walkable)
    on_mesh = SurfaceIndex(level.navmesh.triangles, ON_MESH_M).within(field.positions[standing])
    return Ground(level, goals, field, moves, sure, possible, standing[on_mesh])
