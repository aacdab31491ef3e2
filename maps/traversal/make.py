"""Writes the files of the traversal map: `python maps/traversal/make.py`. Running it again changes no byte.

A walled place of 200 m x 200 m with towers, beams, jump chains and shafts up to 50 m high, and four lookouts
that each miss a net in `level.yaml` and have it in `level-fixed.yaml`. The nav-mesh is the same for both.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))  # for the kit

import grounds
import lookouts
import towers
from course import Course
from kit.files import level_yaml, place, truth_yaml
from kit.mesh import Mesh, glb, nodes
from kit.navmesh import navmesh
from lookouts import BEYOND_M, HALF_M, KILL_Z_M, Lookout

HERE = Path(__file__).resolve().parent
GENERATOR = "maps/traversal/make.py"
ABOUT = "A climbing map with four lookouts that miss a net, which truth.yaml describes."
ABOUT_FIXED = "The traversal map with all its nets."


def make_course() -> tuple[Course, list[Lookout]]:
    """The pieces, parts and links that both variants have, and the lookouts with their bugs."""
    course = Course()
    lookouts.walls(course)
    towers.build(course)
    grounds.build(course)
    return course, lookouts.build(course)


def walkable(course: Course, views: list[Lookout]) -> Mesh:
    """The nav-mesh, as it should be: inside of the nets."""
    return navmesh([*course.pieces, *(piece for view in views for piece in view.mended)])


def level(course: Course, name: str, parts: tuple[str, ...]) -> dict[str, Any]:
    """The level file's content."""
    reach = HALF_M + BEYOND_M
    tops = {part.name: part.at for part in course.parts}
    places = {name: tops[name] for name in ("keep crown", "north-west shaft", "vault room", "nest")}
    return {
        "version": 1,
        "name": name,
        "frame": {"up_axis": "y", "units": "m"},
        "geometry": [{"mesh": f"geometry/{part}.glb", "role": "collision"} for part in parts],
        "navmesh": {"mesh": "navmesh.glb"},
        "character": "unreal",
        "spawns": [{"name": "below the keep", "position": place((20, -20, 0.02))}],
        "kill_z_m": KILL_Z_M,
        "bounds_m": {"low": [-reach, -reach, KILL_Z_M - 5], "high": [reach, reach, 80.0]},
        "required": [{"name": name, "position": place(at), "within_m": 1.5} for name, at in places.items()],
        "explore": {"steps": 10_000_000, "goal_spacing_m": 4},
    }


def build() -> dict[str, bytes]:
    """The files by their names relative to this folder."""
    course, views = make_course()
    mended = [piece for view in views for piece in view.mended]
    return {
        "geometry/course.glb": glb(nodes(course.pieces), GENERATOR),
        "geometry/mended.glb": glb(nodes(mended), GENERATOR),
        "navmesh.glb": glb([walkable(course, views)], GENERATOR),
        "truth.yaml": truth_yaml([view.bug for view in views], **course.truth()),
        "level.yaml": level_yaml(ABOUT, level(course, "traversal", ("course",))),
        "level-fixed.yaml": level_yaml(ABOUT_FIXED, level(course, "traversal-fixed", ("course", "mended"))),
    }


def main() -> None:
    """Write the files next to this one."""
    for name, data in build().items():
        target = HERE / name
        target.parent.mkdir(exist_ok=True)
        target.write_bytes(data)


if __name__ == "__main__":
    main()
