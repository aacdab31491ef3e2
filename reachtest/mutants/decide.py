"""Whether a mutant really changes what can be reached: decided by flood fills before and after, not by a test run.

New places have to be reached for sure now and to be impossible before; lost ones were reached for sure and are
impossible now (see `flood`). What counts is what the tester is there to tell: a way out of the world where there was
none, places off the nav-mesh, the inside of a solid, a trap, goals cut off.

Shape legend: n places.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from reachtest.geometry import inside_closed_surface
from reachtest.mutants.boxes import Box
from reachtest.mutants.field import Field, build_field, window
from reachtest.mutants.flood import POSSIBLE, SURE, reach, spawn_places
from reachtest.mutants.ground import Ground
from reachtest.mutants.moves import moves_of
from reachtest.navmesh.allowed import expected_surface
from reachtest.records import Bools, Character, Floats, Level

_AROUND = np.array([10.0, 10.0, 0.0])  # [m] a window that holds the way in and the first places beyond
_NEW_M = 1.0  # farther from every place that was possible: a few cells
_NEW_EXIT_M = 6.0  # as near, two ways out are one bug
_SAME_M = 0.35  # a place of one field in the other: two cells
_LEAST_PLACES = 12  # 0.35 m2: fewer may be rounding
_LEAST_INSIDE = 4  # where the whole width is inside, a few are enough
_LEAST_LOST_M2 = 4.0
_SLIM = 0.5  # of the radius gets possibly past a barrier: in voxels a gap as wide as the character is none


@dataclass(frozen=True)
class Change:
    """What a mutant changes."""

    reasons: tuple[str, ...]  # "fell", "off_mesh", "inside_solid", "trap", "lost"; none: it does not count
    places: Floats  # [n, 3] the new or lost places


def opened(ground: Ground, mutated: Level, box: Box) -> Change:
    """What geometry that was taken away at `box` opens up, within some metres of it."""
    low, high = box.bounds
    who = mutated.character
    grid = window(ground.field.grid, low - _AROUND, high + _AROUND)
    field = build_field(mutated.collision, who, grid, mutated.kill_z_m, ground.top_m)
    moves = moves_of(field)
    seeds = np.flatnonzero(_near(field.positions, ground.sure_places, _SAME_M))
    reached = reach(field, moves, who, seeds, SURE)
    before = ground.field.positions[ground.possible]
    new = reached & ~_near(field.positions, before, _NEW_M)
    exits = ground.field.positions[ground.possible & ground.moves.falls]
    ways_out = reached & moves.falls & ~_near(field.positions, exits, _NEW_EXIT_M)
    at = field.positions
    off_mesh = new.copy()
    off_mesh[new] = np.isinf(expected_surface(ground.level).distance(at[new]))
    inside = reached & _in_new_solid(ground, mutated, at)
    trapped = new & box.contains(at, _SAME_M)
    trapped &= not _leads_back(ground, field, trapped, box)
    found = {"fell": ways_out, "off_mesh": off_mesh, "inside_solid": inside, "trap": trapped}
    enough = {"fell": 1, "off_mesh": _LEAST_PLACES, "inside_solid": _LEAST_INSIDE, "trap": _LEAST_PLACES}
    real = {name: places for name, places in found.items() if places.sum() >= enough[name]}
    return Change(tuple(real), np.concatenate([np.zeros((0, 3)), *(at[places] for places in real.values())]))


def cut_off(ground: Ground, mutated: Level, box: Box) -> Change:
    """The goals that geometry added at `box` cuts off, wherever they are."""
    who = _slim(mutated.character)
    spawns = np.array([spawn.position for spawn in mutated.spawns])
    if _gets_past(ground, mutated, box, spawns):
        return Change((), np.zeros((0, 3)))
    field = build_field(mutated.collision, who, ground.field.grid, mutated.kill_z_m, ground.top_m)
    reached = reach(field, moves_of(field), who, spawn_places(field, spawns), POSSIBLE)
    after = field.positions[reached]
    before = ground.field.positions[ground.walked]
    lost = before[~_near(before, after, _SAME_M) & ~box.contains(before, 2 * mutated.character.radius_m)]
    within = ground.level.explore.goal_radius_m
    goals = _near(ground.goals, before, within) & ~_near(ground.goals, after, within)
    goals &= _near(ground.goals, lost, within)
    real = len(lost) * ground.field.grid.cell_m**2 >= _LEAST_LOST_M2 and goals.any()
    return Change(("lost",) if real else (), lost if real else lost[:0])


def _slim(who: Character) -> Character:
    return dataclasses.replace(who, radius_m=_SLIM * who.radius_m)


def _gets_past(ground: Ground, mutated: Level, box: Box, spawns: Floats) -> bool:
    """Whether one possibly gets past a barrier within some metres of it: cheap, before the whole level is asked."""
    low, high = box.bounds
    who, known = _slim(mutated.character), ground.field
    barred = box.contains(known.positions, mutated.character.radius_m)
    still = ground.moves.flood(spawn_places(known, spawns), barred)
    lost = ground.walked[~still[ground.walked] & ~barred[ground.walked]]
    lost = lost[(np.abs(known.positions[lost] - box.centre) < _AROUND[0] / 2).all(axis=1)]
    grid = window(known.grid, low - _AROUND, high + _AROUND)
    field = build_field(mutated.collision, who, grid, mutated.kill_z_m, ground.top_m)
    seeds = np.flatnonzero(_near(field.positions, known.positions[still & ground.sure], _SAME_M))
    reached = reach(field, moves_of(field), who, seeds, POSSIBLE)
    return bool(_near(known.positions[lost], field.positions[reached], _SAME_M).all())


def _leads_back(ground: Ground, field: Field, trapped: Bools, box: Box) -> bool:
    """Whether the way goes on from the places `trapped` to others, or out of the world."""
    if not trapped.any():
        return False
    moves = moves_of(field)
    on = reach(field, moves, ground.level.character, np.flatnonzero(trapped), POSSIBLE)
    return bool((on & (moves.falls | ~box.contains(field.positions, 2 * _SAME_M))).any())


def _in_new_solid(ground: Ground, mutated: Level, places: Floats) -> Bools:
    """Where [n] the character is in a solid that the mutant added, in its whole width: more than touching it."""
    r = ground.level.character.radius_m
    result = np.zeros(len(places), dtype=np.bool_)
    for solid in mutated.solids[len(ground.level.solids) :]:
        inside = np.ones(len(places), dtype=np.bool_)
        for x, y in ((0.0, 0.0), (r, 0.0), (-r, 0.0), (0.0, r), (0.0, -r)):
            inside[inside] = inside_closed_surface(places[inside] + [x, y, r], solid.triangles)
        result |= inside
    return result


def _near(points: Floats, others: Floats, within_m: float) -> Bools:
    """Which of `points` [n, 3] have one of `others` within a distance."""
    if not len(points) or not len(others):
        return np.zeros(len(points), dtype=np.bool_)
    away, _ = cKDTree(others).query(points, distance_upper_bound=within_m)
    return np.asarray(np.isfinite(away), dtype=np.bool_)
