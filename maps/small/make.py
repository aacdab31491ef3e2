"""Writes the files of the small map: `python maps/small/make.py`. Running it again changes no byte.

The map is a walled yard of 100 m x 100 m with a keep, decks and a bridge, rooms, lanes and cover, and two
planted bugs. `level.yaml` has both; `level-fixed.yaml` takes the same files, leaves the ramp out and gives
the monolith its collision back. The nav-mesh is the same for both, with holes for the ramp and the monolith.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import yaml
from layout import BUGS, PIECES, Corner, Piece
from mesh import glb, prism, y_up
from walkable import navmesh

HERE = Path(__file__).resolve().parent

TRUTH_HEADER = """\
# The planted bugs of level.yaml, in its own axes and units. Written by make.py.
# A finding counts if its position or exit point lies in `bounds` or within `radius_m` of `position`.
"""


def _truth_bounds(low: Corner, high: Corner) -> dict[str, list[float]]:
    """A box in level coordinates [m] as one in the file's axes."""
    corners = y_up(np.array([low, high], float))
    return {"low": corners.min(axis=0).tolist(), "high": corners.max(axis=0).tolist()}


def truth(ramp: Piece, monolith: Piece) -> dict[str, Any]:
    """What is wrong with the map, for tests that ask whether it was found."""
    ramp_top = np.array([(ramp.low[0] + ramp.high[0]) / 2, ramp.low[1], ramp.high[2]])
    middle = (np.array(monolith.low) + np.array(monolith.high)) / 2
    wall_bug = {
        "name": "stray ramp at the south wall",
        "kind": "unexpected_area",
        "also": ["fell_out_of_world"],
        "position": y_up(ramp_top).tolist(),
        # the wall top between its towers, the ramp, and the void outside down to kill_z_m
        "bounds": _truth_bounds((-46, -80, -30), (46, ramp.high[1], 6)),
        "radius_m": 8.0,
        "description": "A ramp left leaning against the south wall. It is walkable but not on the nav-mesh, "
        "leads to the top of the bounding wall, and from there one falls off the map.",
    }
    solid_bug = {
        "name": "monolith without collision",
        "kind": "inside_solid",
        "also": ["unexpected_area"],
        "position": y_up(np.array([middle[0], middle[1], 0.0])).tolist(),
        "bounds": _truth_bounds(monolith.low, monolith.high),
        "radius_m": 6.0,
        "description": "A solid block whose collision is missing. The nav-mesh goes round it, but one can "
        "walk into it.",
    }
    return {"version": 1, "frame": {"up_axis": "y", "units": "m"}, "bugs": [wall_bug, solid_bug]}


def build() -> dict[str, bytes]:
    """The files by their names relative to this folder."""
    text = TRUTH_HEADER + yaml.safe_dump(truth(*BUGS), sort_keys=False, default_flow_style=None, width=110)
    return {
        "geometry/level.glb": glb([prism(piece) for piece in PIECES]),
        "navmesh.glb": glb([navmesh(PIECES)]),
        "truth.yaml": text.encode(),
    }


def main() -> None:
    """Write the files next to this one."""
    for name, data in build().items():
        target = HERE / name
        target.parent.mkdir(exist_ok=True)
        target.write_bytes(data)


if __name__ == "__main__":
    main()
