"""Planters that put geometry in the way: blocked doors, steps raised above what can be climbed."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator

import numpy as np
from scipy.spatial import cKDTree

from reachtest.connected import STRONGLY, part_labels
from reachtest.geometry import expand
from reachtest.mutants.boxes import Box
from reachtest.mutants.field import Field
from reachtest.mutants.flood import spawn_places
from reachtest.mutants.ground import Ground
from reachtest.mutants.moves import aside
from reachtest.mutants.records import Mutant, Planted
from reachtest.records import Bools, Floats, Ints

_WIDEST_M = 5.0  # a passage
_THICK_M = 0.4  # half of a blocking box
_DOOR_UP_M = 2.0  # higher than a jump and a step: nobody gets over from the same floor
_STEP_UP_M = 0.5
_DOWN_M = 0.4  # into the floor, so that no gap is left on a slope
_TELLS = ("unreached_area", "required_unreached", "navmesh_mismatch")
_PLACES = 20_000  # walked places that are looked at
_IN_VAIN = 400  # passages one after the other that are one way among several: most are told at a glance
_INTO_WALL_M = 0.2
_ROUND_M, _BESIDE_M = 8.0, 0.3  # where a way round is looked for, and between which places
_LEAST_LOST_M2 = 4.0
_UNEVEN_M = 0.2  # heights within a metre, on a stair or at a ledge


def doors(ground: Ground, rng: np.random.Generator) -> Iterator[Planted]:
    """Boxes that fill narrow passages."""
    return _barriers(ground, rng, "blocked door", _DOOR_UP_M, uneven=False)


def steps(ground: Ground, rng: np.random.Generator) -> Iterator[Planted]:
    """Steps on stairs, ramps and ledges, raised above what a jump and a step get up to."""
    return _barriers(ground, rng, "raised step", _STEP_UP_M, uneven=True)


def _barriers(
    ground: Ground, rng: np.random.Generator, kind: str, above_m: float, uneven: bool
) -> Iterator[Planted]:
    who = ground.level.character
    up = who.jump_speed_mps**2 / (2 * who.gravity_mps2) + who.step_height_m + above_m
    spawns = np.array([spawn.position for spawn in ground.level.spawns])
    seeds = spawn_places(ground.field, spawns)
    walked = ground.moves.flood(seeds)
    places = rng.permutation(ground.walked)[:_PLACES]
    if uneven:
        places = places[_uneven(ground, places)]
    in_vain = 0
    for middle, half_width, yaw in _passages(ground, places):
        centre = middle + [0.0, 0.0, (up - _DOWN_M) / 2]
        box = Box(centre, np.array([_THICK_M, half_width, (up + _DOWN_M) / 2]), yaw)
        if np.linalg.norm(spawns - middle, axis=1).min() < 2.0 or not _matters(ground, seeds, walked, box):
            in_vain += 1
            if in_vain > _IN_VAIN:
                return
            continue
        in_vain = 0
        collision = np.concatenate([ground.level.collision, box.faces()])
        yield Planted(dataclasses.replace(ground.level, collision=collision), Mutant(kind, box, _TELLS))


def _uneven(ground: Ground, places: Ints) -> Bools:
    """Which of `places` [n] are on a stair or at a ledge: walked ground within a metre differs in height."""
    at = ground.field.positions
    near = cKDTree(at[ground.walked]).query_ball_point(at[places], 1.0)
    return np.array([np.ptp(at[ground.walked[some], 2]) >= _UNEVEN_M for some in near], dtype=np.bool_)


def _passages(ground: Ground, places: Ints) -> Iterator[tuple[Floats, float, float]]:
    """The narrowest ways across at `places` [n]: the middle [3], half the width and the yaw along each.

    On either side is a wall or a drop: doors, corridors, stairs, ramps and bridges.
    """
    field = ground.field
    width, shift = np.full(len(places), np.inf), np.zeros(len(places))
    across = np.zeros(len(places))
    for direction in ((1, 0), (0, 1), (1, 1), (1, -1)):
        length = float(np.hypot(*direction)) * field.grid.cell_m
        ahead = _to_edge(field, places, direction, length)
        behind = _to_edge(field, places, (-direction[0], -direction[1]), length)
        better = ahead + behind < np.minimum(width, _WIDEST_M)
        width[better] = (ahead + behind)[better]
        shift[better] = (ahead[better] - behind[better]) / 2
        across[better] = np.arctan2(direction[1], direction[0])
    for row in np.flatnonzero(np.isfinite(width)).tolist():
        along = np.array([np.cos(across[row]), np.sin(across[row]), 0.0])
        half = float(width[row]) / 2 + ground.level.character.radius_m + _INTO_WALL_M
        yield field.positions[places[row]] + along * shift[row], half, float(across[row]) - np.pi / 2


def _to_edge(field: Field, places: Ints, direction: tuple[int, int], cell_m: float) -> Floats:
    """How far [n] the ground goes on level, to a wall or a drop [m]; infinite if farther than a passage is wide."""
    level = field.level[places]
    result, going = np.full(len(places), np.inf), np.ones(len(places), dtype=np.bool_)
    for cells in range(1, int(_WIDEST_M / cell_m) + 1):
        there, inside = aside(field, field.column[places], direction, cells)
        at = field.after(there, np.maximum(level - field.step, 0))
        column, height = np.append(field.column, -1)[at], np.append(field.level, 0)[at]
        on = inside & (column == there) & (height <= level + field.step)
        result[going & ~on] = cells * cell_m
        going &= on
    return result


def _matters(ground: Ground, seeds: Ints, walked: Bools, box: Box) -> bool:
    """Whether walking alone loses some ground: cheap, before the flood fill with jumps decides."""
    if _way_round(ground, box):
        return False
    barred = box.contains(ground.field.positions, ground.level.character.radius_m)
    lost = walked & ~ground.moves.flood(seeds, barred) & ~barred
    return bool(lost[ground.walked].sum() * ground.field.grid.cell_m**2 >= _LEAST_LOST_M2)


def _way_round(ground: Ground, box: Box) -> bool:
    """Whether within some metres of a box all ground beside it is still one: then it cuts nothing off."""
    at, moves = ground.field.positions, ground.moves
    near = np.flatnonzero(ground.sure & (np.abs(at - box.centre) < _ROUND_M).all(axis=1))
    near = near[~box.contains(at[near], ground.level.character.radius_m)]
    number = np.full(len(at), -1)
    number[near] = np.arange(len(near))
    row, place = expand(np.diff(moves.start)[near])
    there = number[moves.target[moves.start[near][row] + place]]
    row, there = row[there >= 0], there[there >= 0]
    label = part_labels(len(near), np.stack([row, there], axis=1), STRONGLY)
    beside = box.contains(at[near], ground.level.character.radius_m + _BESIDE_M)
    return bool(beside.any() and np.ptp(label[beside]) == 0)
