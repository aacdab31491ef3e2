"""Planters that open walls: pieces missing from the floor up, and pieces too low."""

from __future__ import annotations

import numpy as np

from reachtest.mutants.boxes import Box, cut_out, ray_hits, thickness
from reachtest.mutants.field import Field
from reachtest.mutants.ground import Ground
from reachtest.mutants.moves import aside
from reachtest.mutants.openings import FALLS, with_collision
from reachtest.mutants.records import Mutant, Planted
from reachtest.records import Floats

_DOOR_M, _WINDOW_M = 0.9, 1.3  # half widths of openings
_ABOVE_M = 0.03  # a wall begins above its floor: the floor stays
_AHEAD_M, _AWAY_M = 1.0, 1.5  # of a place to its wall: of the capsule, and of its middle
_UNEVEN_M = 0.3  # what a straight piece of wall may be off


def gap(ground: Ground, rng: np.random.Generator) -> Planted | None:
    """A piece of wall that is missing from the floor up."""
    return _opening(ground, rng, "missing wall", 0.0, _DOOR_M)


def lowered(ground: Ground, rng: np.random.Generator) -> Planted | None:
    """A piece of wall so low that it can be jumped."""
    who = ground.level.character
    apex = who.jump_speed_mps**2 / (2 * who.gravity_mps2)
    return _opening(ground, rng, "lowered wall", max(0.6 * apex, 0.6 * who.step_height_m), _WINDOW_M)


def _opening(
    ground: Ground, rng: np.random.Generator, kind: str, sill_m: float, half_m: float
) -> Planted | None:
    """A passage through a wall beside a walked place, from `sill_m` above its floor up."""
    field, who = ground.field, ground.level.character
    place = int(ground.walked[int(rng.integers(len(ground.walked)))])
    yaw = int(rng.integers(4)) * np.pi / 2
    if not _wall_ahead(field, place, yaw):
        return None
    at, forward = field.positions[place], np.array([np.cos(yaw), np.sin(yaw), 0.0])
    side = np.array([-forward[1], forward[0], 0.0])
    far, thickest = [], 0.0
    for offset in (-0.8 * half_m, 0.0, 0.8 * half_m):
        origin = at + offset * side + [0.0, 0.0, max(who.height_m / 2, sill_m + 0.3)]
        hits, _ = ray_hits(ground.level.collision, origin, forward, _AWAY_M)
        thick = thickness(ground.level.collision, origin, forward, _AWAY_M)
        if thick is None:
            return None
        far.append(float(hits[0]))
        thickest = max(thickest, thick)
    if np.ptp(far) > _UNEVEN_M:
        return None
    low, near, end = at[2] + sill_m, min(far), max(far) + thickest
    box = _tunnel(
        at, forward, yaw, (near - 0.05, end + 0.05), (low + _ABOVE_M, low + 2 * who.height_m), half_m
    )
    inner = _tunnel(at, forward, yaw, (near, end), (low, low + 2 * who.height_m), half_m)
    collision = cut_out(ground.level.collision, box)
    if thickest > 0.05:
        collision = np.concatenate([collision, inner.faces(("right", "left", "bottom", "top"), inwards=True)])
    return Planted(with_collision(ground.level, collision), Mutant(kind, box, FALLS))


def _tunnel(
    at: Floats,
    forward: Floats,
    yaw: float,
    along: tuple[float, float],
    heights: tuple[float, float],
    half_m: float,
) -> Box:
    centre = at + forward * sum(along) / 2
    half = np.array([(along[1] - along[0]) / 2, half_m, (heights[1] - heights[0]) / 2])
    return Box(np.array([centre[0], centre[1], sum(heights) / 2]), half, yaw)


def _wall_ahead(field: Field, place: int, yaw: float) -> bool:
    """Whether the way straight on is barred within a metre."""
    direction = (round(np.cos(yaw)), round(np.sin(yaw)))
    column, level = field.column[[place]], field.level[[place]]
    for cells in range(1, int(_AHEAD_M / field.grid.cell_m) + 1):
        there, inside = aside(field, column, direction, cells)
        if not inside[0]:
            return False
        if not field.free[there[0], level[0]]:
            return True
    return False
