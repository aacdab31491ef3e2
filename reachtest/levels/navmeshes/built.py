"""The nav-mesh of a level that asks for one to be built."""

from __future__ import annotations

from reachtest.errors import Problem
from reachtest.levels.keys.navmesh import BuildSpec
from reachtest.navmesh.build import build_navmesh, turned_over
from reachtest.navmesh.settings import BuildSettings, settings_for
from reachtest.records import Character, Floats, NavMesh

NAME = "built nav-mesh"  # what reports call it, where others have a file
TURNED_OVER = (
    "most of what is flat enough for a floor faces down",
    "write navmesh.build.faces: any, or export the geometry with its faces turned round",
)


def build_settings(spec: BuildSpec, character: Character) -> BuildSettings:
    """The numbers in force: the file's, else the character's."""
    return settings_for(character, both_sides=spec.faces == "any", **spec.model_dump(exclude={"faces"}))


def built_navmesh(
    spec: BuildSpec, character: Character, collision: Floats, where: str
) -> tuple[NavMesh, list[Problem]]:
    """The nav-mesh over `collision` [F, 3, 3], and what is wrong with it."""
    settings = build_settings(spec, character)
    try:
        navmesh = build_navmesh(collision, settings, NAME)
    except ValueError as error:
        found = f"cell_m {settings.cell_m:.4g} and cell_height_m {settings.cell_height_m:.4g}: {error}"
        return _empty(), [Problem(where, found, "write larger ones, or check the units of the geometry")]
    if len(navmesh.faces):
        return navmesh, []
    if turned_over(collision, settings.slope_deg) and not settings.both_sides:
        return navmesh, [Problem(where, "nothing is walkable", f"{TURNED_OVER[0]}: {TURNED_OVER[1]}")]
    agent = f"a radius of {settings.radius_m:g} m and a height of {settings.height_m:g} m"
    return navmesh, [
        Problem(where, f"nothing is walkable for {agent}", "check up_axis and units of the geometry")
    ]


def _empty() -> NavMesh:
    import numpy as np

    return NavMesh(NAME, np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64))
