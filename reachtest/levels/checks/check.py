"""Is the level plausible? What would make every result wrong is an error, what looks odd a warning."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from reachtest.columns import ColumnIndex
from reachtest.errors import Problem
from reachtest.geometry import body_inside, triangle_normals
from reachtest.levels.checks.navmesh import check_navmesh
from reachtest.levels.checks.spawns import check_spawns
from reachtest.levels.frames import UNITS
from reachtest.levels.reading import ReadLevel
from reachtest.records import Floats, Level

SMALLEST_M, LARGEST_M = 2.0, 50_000.0  # of levels: smaller than a lift, larger than any streamed world
USUAL_M = 60.0  # a middling level; decides only which unit a message proposes


@dataclass(frozen=True)
class Check:
    """What a look at the level brought."""

    problems: tuple[Problem, ...]
    warnings: tuple[Problem, ...]
    facts: tuple[tuple[str, str], ...]


def check_level(level: Level) -> Check:
    """Check spawns, nav-mesh, sizes and places of a level, and say how it was understood."""
    # A grid of 500 x 500 at most, so that a level in wrong units does not take longer to check.
    index = ColumnIndex(level.collision, cell_m=max(1.0, float(_extents(level).max()) / 500))
    nav_problems, nav_warnings, floor_share = check_navmesh(level, index)
    problems = [*check_spawns(level, index), *nav_problems, *_too_fast(level)]
    return Check(tuple(problems), (*_size(level), *nav_warnings, *_places(level)), _facts(level, floor_share))


def _extents(level: Level) -> Floats:
    return np.asarray(level.collision.max(axis=(0, 1)) - level.collision.min(axis=(0, 1)))


def _size(level: Level) -> list[Problem]:
    """Warnings about sizes that a level in these units should not have."""
    where, extents = f"{level.file.name}: geometry", _extents(level)
    largest, found = float(extents.max()), f"spans {_metres(extents)}"
    if not SMALLEST_M <= largest <= LARGEST_M:
        return [Problem(where, found, _likely_unit(level, largest))]
    if level.character.height_m > largest / 2:
        found = f"{found}, and the character is {level.character.height_m:g} m tall"
        return [Problem(where, found, f"check the character's numbers; {_likely_unit(level, largest)}")]
    return []


def _likely_unit(level: Level, largest: float) -> str:
    now = level.frame.unit_m
    sizes = {unit: largest / now * length for unit, length in UNITS.items() if abs(length / now - 1) > 1e-6}
    unit = min(sizes, key=lambda name: abs(np.log(sizes[name] / USUAL_M)))
    if not 5 <= sizes[unit] <= 5000:
        return "check units and scale of the meshes"
    return f"if the meshes are in {unit} it spans {sizes[unit]:.3g} m: write units: {unit}"


def _too_fast(level: Level) -> list[Problem]:
    """A character that moves farther than its radius in a physics step goes through walls."""
    who, hz = level.character, level.explore.physics_hz
    fastest = max(who.walk_speed_mps, who.jump_speed_mps)
    if fastest <= who.radius_m * hz:
        return []
    found = f"{hz:g} Hz: at {fastest:g} m/s a character of {who.radius_m:g} m radius would pass through walls"
    need = int(np.ceil(fastest / who.radius_m))
    return [Problem(f"{level.file.name}: explore.physics_hz", found, f"at least {need} for this character")]


def _places(level: Level) -> list[Problem]:
    """Warnings about places that nobody can get to."""
    low, high = level.bounds
    problems = []
    remedy = "check the position, or bounds_m and kill_z_m"
    for index, place in enumerate(level.required):
        for solid in level.solids:
            if body_inside(place.position[None], level.character, solid.triangles)[0]:
                where, found = f"{level.file.name}: required[{index}]", f"{place.name!r} lies inside of solid"
                problems.append(Problem(where, f"{found} {solid.name!r}", "check the position"))
        if (
            (place.position < low).any()
            or (place.position > high).any()
            or place.position[2] < level.kill_z_m
        ):
            where = f"{level.file.name}: required[{index}]"
            problems.append(Problem(where, f"{place.name!r} lies outside of the level's bounds", remedy))
    for index, zone in enumerate(level.zones):
        if (zone.high < low).any() or (zone.low > high).any():
            where = f"{level.file.name}: zones[{index}]"
            problems.append(Problem(where, f"{zone.name!r} lies outside of the level's bounds", remedy))
    return problems


def _metres(values: Floats) -> str:
    return " x ".join(f"{value:.4g}" for value in values) + " m"


def _facts(level: Level, floor_share: float) -> tuple[tuple[str, str], ...]:
    reading = level.reading if isinstance(level, ReadLevel) else None
    dropped = reading.degenerate_collision if reading else 0
    dropped_nav = reading.degenerate_navmesh if reading else 0
    who = level.character
    low, high = level.bounds
    area = triangle_normals(level.navmesh.triangles)[1].sum()
    facts = [
        ("level", level.name),
        ("axes and units", f"{level.frame.up_axis} up, {level.frame.units}"),
        ("collision", f"{len(level.collision):,} triangles{_left_out(dropped)}"),
        ("extents", f"{_metres(_extents(level))} (x, y, z with z up)"),
        ("solids", f"{len(level.solids):,}"),
        ("nav-mesh", f"{len(level.navmesh.faces):,} triangles{_left_out(dropped_nav)}, {area:,.0f} m2"),
        ("nav-mesh with a floor within 1 m", f"{floor_share:.0%}"),
        ("character", f"radius {who.radius_m:g} m, height {who.height_m:g} m, step {who.step_height_m:g} m"),
        ("movement", f"walk {who.walk_speed_mps:g} m/s, jump {who.jump_speed_mps:g} m/s, {_limits(level)}"),
        ("spawns", ", ".join(f"{spawn.name} {_point(spawn.position)}" for spawn in level.spawns[:8])),
        ("kill_z", f"{level.kill_z_m:.4g} m"),
        ("bounds", f"{_point(low)} to {_point(high)} m"),
        ("explored with", f"{level.explore.steps:,} agent steps{_time(level.explore.time_budget_s)}"),
        ("fails on", ", ".join(level.gate.fail_on) or "nothing"),
    ]
    if reading:
        frame = reading.navmesh_frame
        facts.insert(6, ("nav-mesh axes and units", f"{frame.up_axis} up, {frame.units}"))
    return tuple(facts)


def _limits(level: Level) -> str:
    return f"slope {level.character.slope_limit_deg:g} deg, gravity {level.character.gravity_mps2:g} m/s2"


def _time(budget_s: float | None) -> str:
    return "" if budget_s is None else f", {budget_s:,.0f} s at most"


def _left_out(count: int) -> str:
    return f" ({count:,} degenerate ones left out)" if count else ""


def _point(values: Floats) -> str:
    return "(" + ", ".join(f"{value:.4g}" for value in values) + ")"
