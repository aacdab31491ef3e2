"""Writes the files of the large map: `python maps/large/make.py`. Running it again changes no byte.

A walled city of 1.5 km x 1.5 km with six planted escapes on its west and south edge. `level.yaml` has them;
in `level-fixed.yaml` they are mended. The nav-mesh is the same for both. The meshes are too large to be
committed: run this once after a checkout.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))  # for the kit

import numpy as np
from border import BEYOND_M, KILL_Z_M, OUTER_M
from city import City, make_city
from kit.files import level_yaml, place, truth_yaml
from kit.mesh import Mesh, glb, nodes
from kit.navmesh import components, kept, navmesh
from streets import AVENUE_M

HERE = Path(__file__).resolve().parent
SEED = 7
GENERATOR = "maps/large/make.py"
ABOUT = "A walled city of 1.5 km x 1.5 km with six planted escapes, which truth.yaml describes."
ABOUT_FIXED = "The large map with its six escapes mended."


def walkable(city: City) -> Mesh:
    """The nav-mesh: what one can walk to from the streets. It goes round what is there only with the bugs."""
    broken = [replace(piece, kind="block") for escape in city.escapes for piece in escape.broken]
    mended = [piece for escape in city.escapes for piece in escape.mended]
    mesh = navmesh([*city.pieces, *mended, *broken])
    patch = components(mesh.faces)
    return kept(mesh, patch == np.bincount(patch).argmax())


def spawns(city: City) -> list[dict[str, Any]]:
    """Sixteen of them on crossings all over the city."""
    columns, rows = len(city.streets.columns) - 1, len(city.streets.rows) - 1
    chosen = [(columns * (2 * i + 1) // 8, rows * (2 * j + 1) // 8) for j in range(4) for i in range(4)]
    found = []
    for i, j, x, y in city.streets.crossings:
        if (i, j) in chosen:
            avenue = city.streets.rows[j + 1][0] - city.streets.rows[j][1] == AVENUE_M
            name = f"crossing {chr(ord('A') + i)}{j + 1}"
            found.append({"name": name, "position": place((x, y + 9.0 if avenue else y, 0.02))})
    return found


def required(city: City) -> list[dict[str, Any]]:
    """A bridge, a roof and the viaduct."""
    deck = city.bridges[len(city.bridges) // 2 // 3 * 3]
    roof = city.roofs[-1]
    road = [piece for piece in city.pieces if piece.name.startswith("viaduct") and piece.kind == "platform"]
    places = [
        (deck.name, (*deck.footprint.middle, deck.top)),
        (roof.name, (roof.rect.x0 + 2, roof.rect.y0 + 2, roof.top)),
        ("middle of the viaduct", (*road[len(road) // 2].footprint.middle, road[0].top)),
    ]
    return [{"name": name, "position": place(at), "within_m": 1} for name, at in places]


def level(city: City, name: str, variant: str) -> dict[str, Any]:
    """The level file's content."""
    meshes = [{"mesh": f"geometry/{part}.glb", "role": "collision"} for part in ("city", variant)]
    reach = OUTER_M + BEYOND_M
    return {
        "version": 1,
        "name": name,
        "frame": {"up_axis": "y", "units": "m"},
        "geometry": meshes,
        "navmesh": {"mesh": "navmesh.glb"},
        "character": "unreal",
        "spawns": spawns(city),
        "kill_z_m": KILL_Z_M,
        "bounds_m": {"low": [-reach, -reach, KILL_Z_M - 5], "high": [reach, reach, 120.0]},
        "required": required(city),
        "explore": {"steps": 10_000_000, "goal_spacing_m": 8},
    }


def build(seed: int = SEED) -> dict[str, bytes]:
    """The files by their names relative to this folder."""
    city = make_city(seed)
    broken = [piece for escape in city.escapes for piece in escape.broken]
    mended = [piece for escape in city.escapes for piece in escape.mended]
    return {
        "geometry/city.glb": glb(nodes(city.pieces), GENERATOR),
        "geometry/broken.glb": glb(nodes(broken), GENERATOR),
        "geometry/mended.glb": glb(nodes(mended), GENERATOR),
        "navmesh.glb": glb([walkable(city)], GENERATOR),
        "truth.yaml": truth_yaml([escape.bug for escape in city.escapes]),
        "level.yaml": level_yaml(ABOUT, level(city, "large", "broken")),
        "level-fixed.yaml": level_yaml(ABOUT_FIXED, level(city, "large-fixed", "mended")),
    }


def main() -> None:
    """Write the files next to this one."""
    for name, data in build().items():
        target = HERE / name
        target.parent.mkdir(exist_ok=True)
        target.write_bytes(data)


if __name__ == "__main__":
    main()
