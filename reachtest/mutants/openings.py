"""Planters that take ground away, or a solid's collision: holes, pits, bare solids."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator

import numpy as np

from reachtest.connected import grouped, part_labels
from reachtest.mutants.boxes import Box, cut_out, thickness
from reachtest.mutants.ground import Ground
from reachtest.mutants.records import Mutant, Planted, Planter
from reachtest.records import Floats, Ints, Level, Solid

Once = Callable[[Ground, np.random.Generator], Planted | None]  # None: no luck with this draw

_HOLE_M = 0.8  # half a side: the capsule's diameter and as much again
_PIT_M = 1.2
_FLAT_M = 0.1  # a lid that is cut out has to lie in one plane, nearly
_SMALLEST_M, _LARGEST_M = 0.8, 15.0  # sides of a solid
_BESIDE_M, _LEAST_BESIDE = 0.7, 10  # walked places at the foot of a solid
_SOLID = "mutant"
FALLS = ("fell_out_of_world", "unexpected_area", "stuck", "no_return")


_DRAWS = 3000  # most places are no place for a bug; a draw that fits nothing is cheap


def drawn(once: Once) -> Planter:
    """A planter that tries at one random place after the other."""

    def planter(ground: Ground, rng: np.random.Generator) -> Iterator[Planted]:
        for _ in range(_DRAWS):
            if (planted := once(ground, rng)) is not None:
                yield planted

    return planter


def hole(ground: Ground, rng: np.random.Generator) -> Planted | None:
    """A hole through the floor."""
    at = _flat_place(ground, rng, _HOLE_M)
    if at is None:
        return None
    collision = ground.level.collision
    thick = thickness(collision, at + [0.0, 0.0, 0.5], np.array([0.0, 0.0, -1.0]), 0.5 + 2 * _FLAT_M)
    if thick is None:
        return None
    bottom = at[2] - _FLAT_M - thick
    box = _between(at, bottom - _FLAT_M, at[2] + 2 * _FLAT_M, _HOLE_M)
    cut = cut_out(collision, box)
    if thick > _FLAT_M:  # what is thick has an inside, which nobody is to get into
        shaft = _between(at, bottom, at[2], _HOLE_M)
        cut = np.concatenate([cut, shaft.faces(("back", "front", "right", "left"), inwards=True)])
    return Planted(with_collision(ground.level, cut), Mutant("hole", box, FALLS))


def pit(ground: Ground, rng: np.random.Generator) -> Planted | None:
    """A square pit deeper than the character jumps and steps."""
    at = _flat_place(ground, rng, _PIT_M)
    if at is None:
        return None
    who = ground.level.character
    deep = who.jump_speed_mps**2 / (2 * who.gravity_mps2) + who.step_height_m + 1.0
    box = _between(at, at[2] - deep, at[2] + 2 * _FLAT_M, _PIT_M)
    walls = _between(at, at[2] - deep, at[2], _PIT_M)
    sides = walls.faces(("back", "front", "right", "left", "bottom"), inwards=True)
    collision = np.concatenate([cut_out(ground.level.collision, box), sides])
    return Planted(
        with_collision(ground.level, collision), Mutant("pit", box, ("stuck", "no_return", "unexpected_area"))
    )


def bare_solids(ground: Ground, rng: np.random.Generator) -> Iterator[Planted]:
    """Closed bodies of the level's geometry that nothing collides with any more."""
    places = ground.field.positions[ground.walked]
    bodies = closed_bodies(ground.level.collision)
    for number in rng.permutation(len(bodies)).tolist():
        body = ground.level.collision[bodies[number]]
        low, high = body.min(axis=(0, 1)), body.max(axis=(0, 1))
        beside = ((places > low - _BESIDE_M) & (places < high + _BESIDE_M)).all(axis=1)
        if (beside & (places[:, 2] < high[2] - _BESIDE_M)).sum() < _LEAST_BESIDE:
            continue
        level = with_collision(ground.level, np.delete(ground.level.collision, bodies[number], axis=0))
        level = dataclasses.replace(level, solids=(Solid(_SOLID, body), *level.solids))
        box = Box((low + high) / 2, (high - low) / 2)
        yield Planted(level, Mutant("bare solid", box, ("inside_solid", *FALLS)))


def closed_bodies(triangles: Floats) -> list[Ints]:
    """Indices of the triangles [F, 3, 3] of every closed body of a character's size, by connected corners."""
    _, vertex = np.unique(np.rint(triangles.reshape(-1, 3) * 1e3), axis=0, return_inverse=True)
    faces = vertex.reshape(-1, 3)
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    label = part_labels(int(faces.max()) + 1, edges)
    result = []
    for members in grouped(label[faces[:, 0]]):
        sides = np.ptp(triangles[members].reshape(-1, 3), axis=0)
        if sides.min() < _SMALLEST_M or sides.max() > _LARGEST_M or sides[2] < 2 * _SMALLEST_M:
            continue
        own = faces[members]
        ways = np.concatenate([own[:, [0, 1]], own[:, [1, 2]], own[:, [2, 0]]])
        _, there = np.unique(ways, axis=0, return_counts=True)
        if len(np.unique(np.sort(ways, axis=1), axis=0)) * 2 == len(ways) == there.sum() == len(there):
            result.append(members)
    return result


def with_collision(level: Level, collision: Floats) -> Level:
    """The level with other collision triangles [F, 3, 3]."""
    return dataclasses.replace(level, collision=collision)


def _between(at: Floats, low_m: float, high_m: float, half_m: float) -> Box:
    middle, half = (low_m + high_m) / 2, (high_m - low_m) / 2
    return Box(np.array([at[0], at[1], middle]), np.array([half_m, half_m, half]))


def _flat_place(ground: Ground, rng: np.random.Generator, half_m: float) -> Floats | None:
    """A walked place [3] with flat walked ground around it, half a metre farther than `half_m`."""
    places = ground.field.positions[ground.walked]
    at = places[int(rng.integers(len(places)))]
    reach, cell = half_m + 0.5, ground.field.grid.cell_m
    away = np.abs(places - at)
    near = (away[:, :2] <= reach).all(axis=1) & (away[:, 2] < 2.0)
    whole = (2 * int(reach / cell) + 1) ** 2
    flat = near.sum() >= 0.95 * whole and away[near, 2].max() <= _FLAT_M
    clear = np.linalg.norm(np.array([s.position for s in ground.level.spawns]) - at, axis=1).min() > 3.0
    return at if flat and clear else None
