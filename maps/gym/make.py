"""Writes the files of the gym: `python maps/gym/make.py`. Running it again changes no byte.

All exercises of the `unreal` character side by side. The level passes when the character gets wherever an exercise
says it must, and nowhere that one says it must not.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))  # for the kit, and the gym itself

import numpy as np
from kit.files import level_yaml, place
from kit.mesh import glb, y_up
from kit.pieces import Corner

from gym.characters import CHARACTERS
from gym.hall import Lane, lanes, meshes, walkable

HERE = Path(__file__).resolve().parent
GENERATOR = "maps/gym/make.py"
CHARACTER = "unreal"
ABOUT = "All exercises of the gym side by side, for the unreal character."
KILL_Z_M = -15.0


def level(hall: list[Lane]) -> dict[str, Any]:
    """The level file's content."""
    return {
        "version": 1,
        "name": "gym",
        "frame": {"up_axis": "y", "units": "m"},
        "geometry": [{"mesh": "geometry/gym.glb", "role": "collision"}],
        "navmesh": {"mesh": "navmesh.glb"},
        "character": CHARACTER,
        "spawns": [{"name": lane.name, "position": place(lane.spawn)} for lane in hall],
        "kill_z_m": KILL_Z_M,
        "zones": [zone(lane, low, high) for lane in hall for low, high in lane.exercise.forbidden],
        "required": [
            {"name": lane.name, "position": place(lane.at(goal)), "within_m": 1.0}
            for lane in hall
            for goal in lane.exercise.required
        ],
        "explore": {"steps": 600_000, "goal_spacing_m": 4},
    }


def zone(lane: Lane, low: Corner, high: Corner) -> dict[str, Any]:
    """A box of a lane that nobody may get into."""
    corners = y_up(np.array([lane.at(low), lane.at(high)], float))
    centre, size = corners.mean(axis=0).round(4), np.abs(corners[1] - corners[0]).round(4)
    return {"name": lane.name, "kind": "forbidden", "box": {"center": centre.tolist(), "size": size.tolist()}}


def build() -> dict[str, bytes]:
    """The files by their names relative to this folder."""
    hall = lanes(CHARACTERS[CHARACTER])
    return {
        "geometry/gym.glb": glb(meshes(hall), GENERATOR),
        "navmesh.glb": glb([walkable(hall)], GENERATOR),
        "level.yaml": level_yaml(ABOUT, level(hall)),
    }


def main() -> None:
    """Write the files next to this one."""
    for name, data in build().items():
        target = HERE / name
        target.parent.mkdir(exist_ok=True)
        target.write_bytes(data)


if __name__ == "__main__":
    main()
