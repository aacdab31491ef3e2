"""Can the character stand where it starts?"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from reachtest.columns import ColumnIndex
from reachtest.errors import Problem
from reachtest.geometry import inside_closed_surface, point_triangle_distance, triangle_normals
from reachtest.records import Character, Floats, Level, Spawn

FLOOR_BELOW_M = 2.0  # a drop from here is a start, a longer one a mistake
FEET_SUNK_M = 0.3  # feet this deep in the floor are still on it
OVERLAP_M = 0.05  # what a simulator pushes out without a jolt
_AXIS_SAMPLES = (
    9  # 0.14 m apart on a 1.76 m capsule: the distance is then 1 cm off at most, at the overlap limit
)
_EVER_M = 1e6


def check_spawns(level: Level, index: ColumnIndex) -> list[Problem]:
    """Problems of spawns in the air, in walls, in solids, and outside of the world."""
    normals, _ = triangle_normals(level.collision)
    problems = []
    for number, spawn in enumerate(level.spawns):
        where = f"{level.file.name}: spawns[{number}]"
        for found, remedy in _complaints(level, index, normals, spawn):
            problems.append(
                Problem(where, f"{spawn.name!r} at {_place(level, spawn.position)} {found}", remedy)
            )
    return problems


def _complaints(level: Level, index: ColumnIndex, normals: Floats, spawn: Spawn) -> Iterator[tuple[str, str]]:
    low, high = level.bounds
    feet = spawn.position
    if feet[2] < level.kill_z_m:
        yield f"is below kill_z ({level.kill_z_m:g} m, z up)", "raise the spawn or lower kill_z_m"
    if (feet < low).any() or (feet > high).any():
        yield "is outside of the level's bounds", "move the spawn, check frame.units, or widen bounds_m"
        return
    body = feet + np.array([0.0, 0.0, level.character.height_m / 2])
    inside = [solid.name for solid in level.solids if inside_closed_surface(body[None], solid.triangles)[0]]
    if inside:
        yield f"is inside of the solid {inside[0]!r}", "move the spawn out of it"
        return
    for zone in level.zones:
        if zone.kind == "forbidden" and zone.holds(feet[None])[0]:
            yield (
                f"is in the forbidden zone {zone.name!r}, so that every run fails",
                "move the spawn or the zone",
            )
    yield from _footing(level, index, normals, feet)


def _footing(level: Level, index: ColumnIndex, normals: Floats, feet: Floats) -> Iterator[tuple[str, str]]:
    """Complaints about the floor below the feet and about what stands in the way of the body."""
    ray, who = feet[None], level.character
    through = index.highest(ray, -FEET_SUNK_M, who.height_m)[0][0]
    if np.isfinite(through):
        found = f"has a surface going through it, {through - feet[2]:.2f} m above the feet"
        yield found, f"if that is the floor, write position: {_place(level, _at(feet, through), '[]')}"
        return
    if not np.isfinite(index.highest(ray, FLOOR_BELOW_M, FEET_SUNK_M)[0][0]):
        below = index.highest(ray, _EVER_M, FEET_SUNK_M)[0][0]
        if np.isfinite(below):
            found = f"is in the air: the next floor is {feet[2] - below:.2f} m below the feet"
            yield found, f"to put the feet on it, write position: {_place(level, _at(feet, below), '[]')}"
        else:
            remedy = "put it above the level's floor, and check frame.up_axis and frame.units"
            yield "is in the air: there is no floor below it at all", remedy
    depth = wall_overlap(feet, who, level.collision, normals)
    if depth > OVERLAP_M:
        yield f"is {depth:.2f} m deep in a wall", f"move it {depth:.2f} m away from the wall"


def _at(feet: Floats, z: float) -> Floats:
    return np.array([feet[0], feet[1], z])


def _place(level: Level, position: Floats, brackets: str = "()") -> str:
    """A position in the file's own axes and units."""
    values = ", ".join(f"{value:.6g}" for value in np.round(level.frame.to_source(position), 4) + 0.0)
    return f"{brackets[0]}{values}{brackets[1]}"


def wall_overlap(feet: Floats, who: Character, triangles: Floats, normals: Floats) -> float:
    """How deep the capsule standing at `feet` [3] reaches into walls and ceilings [m]; 0 where it is free.

    The capsule's axis is sampled. What the feet may touch does not count: steps up to the step height, and
    floors, which only that part of the axis is tested against that is clear of the steepest slope underfoot.
    """
    steepest = np.cos(np.deg2rad(who.slope_limit_deg))
    reach = np.array([who.radius_m, who.radius_m, 0.0])
    low, high = feet - reach, feet + reach + np.array([0.0, 0.0, who.height_m])
    near = (triangles.min(axis=1) <= high).all(axis=1) & (triangles.max(axis=1) >= low).all(axis=1)
    near &= triangles[:, :, 2].max(axis=1) > feet[2] + who.step_height_m
    floor = np.abs(normals[:, 2]) >= steepest
    bottom, top = who.radius_m, who.height_m - who.radius_m
    lift = max(FEET_SUNK_M, who.radius_m * (1 / steepest - 1))
    nearest = min(
        _axis_distance(feet, bottom, top, triangles[near & ~floor]),
        _axis_distance(feet, min(bottom + lift, top), top, triangles[near & floor]),
    )
    return max(0.0, who.radius_m - nearest)


def _axis_distance(feet: Floats, bottom: float, top: float, triangles: Floats) -> float:
    """Distance of the upright segment from `bottom` to `top` above `feet` to `triangles` [F, 3, 3] [m]."""
    if not len(triangles):
        return float("inf")
    axis = feet + np.outer(np.linspace(bottom, top, _AXIS_SAMPLES), [0.0, 0.0, 1.0])
    points = np.repeat(axis, len(triangles), axis=0)
    return float(point_triangle_distance(points, np.tile(triangles, (_AXIS_SAMPLES, 1, 1))).min())
