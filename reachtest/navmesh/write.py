"""Writes a nav-mesh as a file that the same level file can name under `navmesh.mesh`, without further keys."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from reachtest.files import write_whole
from reachtest.records import Floats, Frame, NavAgent, NavMesh

TYPES = (".glb", ".obj")


def write_navmesh(navmesh: NavMesh, frame: Frame, path: Path) -> None:
    """Write `navmesh` in the level's units: glTF with y up, as its standard asks, OBJ with the level's own axes.

    OBJ also states the agent, in the lines in which Recast's exporters do.

    The file is written whole or not at all. Raises ValueError for a type that is not in TYPES.
    """
    import trimesh

    kind = path.suffix.lower()
    if kind not in TYPES:
        raise ValueError(f"{path.name} is of type {kind!r}, not one of {', '.join(TYPES)}")
    points = _y_up(navmesh.vertices, frame) if kind == ".glb" else frame.to_source(navmesh.vertices)
    mesh = trimesh.Trimesh(points, navmesh.faces, process=False)
    data = mesh.export(file_type=kind[1:])
    if isinstance(data, str):
        data = (_agent_lines(navmesh.agent, frame) + data).encode("utf-8")
    write_whole(path, lambda part: part.write_bytes(data))


def _agent_lines(agent: NavAgent, frame: Frame) -> str:
    unit_m = frame.unit_m
    lengths = {"rd_agr": agent.radius_m, "rd_agh": agent.height_m, "rd_amc": agent.climb_m}
    numbers = {key: None if length is None else length / unit_m for key, length in lengths.items()}
    numbers["rd_ams"] = agent.slope_deg
    return "".join(f"{key} {number:.9g}\n" for key, number in numbers.items() if number is not None)


def _y_up(points: Floats, frame: Frame) -> Floats:
    return np.asarray(points[:, [0, 2, 1]] * [1.0, 1.0, -1.0] / frame.unit_m)
