"""Solids and forbidden zones: also small ones, of one name, one in another, and on the floor."""

from __future__ import annotations

from pathlib import Path

import pytest

from reachtest import pipeline

ROOM = """
version: 1
frame: {up_axis: z, units: m}
geometry:
  - {name: floor, box: {center: [0, 0, -0.5], size: [24, 24, 1]}}
  - {name: east, box: {center: [12.5, 0, 1.5], size: [1, 26, 5]}}
  - {name: west, box: {center: [-12.5, 0, 1.5], size: [1, 26, 5]}}
  - {name: north, box: {center: [0, 12.5, 1.5], size: [26, 1, 5]}}
  - {name: south, box: {center: [0, -12.5, 1.5], size: [26, 1, 5]}}
"""
REST = """
navmesh: {build: {}}
character: unreal
spawns: [[0, 0, 0.02]]
explore: {steps: 40000}
"""
PILLARS = [(x, y) for x in (-8, -4, 4, 8) for y in (-6, 0, 6)]


def found(folder: Path, more: str, character: str = "unreal") -> dict[str, str]:
    """Title and severity, "fragile" where it is, of what a run finds in the room."""
    path = folder / "level.yaml"
    path.write_text(ROOM + more + REST.replace("unreal", character))
    options = pipeline.RunOptions(path, out=folder / "out", threads=1)
    report, _ = pipeline.run(pipeline.load(options), options)
    return {f.title: "gates" if f.gating else "fragile" if f.fragile else "told" for f in report.findings}


def zones(*boxes: str) -> str:
    return "zones:\n" + "".join(f"  - {box}\n" for box in boxes)


def forbidden(name: str, box: str) -> str:
    return f"{{name: {name}, kind: forbidden, box: {{{box}}}}}"


def test_every_thin_solid_that_one_walks_through_is_found(tmp_path: Path) -> None:
    pillars = "".join(
        f"  - {{name: p{x}/{y}, role: solid, box: {{center: [{x}, {y}, 1], size: [0.5, 0.5, 2]}}}}\n"
        for x, y in PILLARS
    )
    titles = found(tmp_path, pillars)
    assert titles == {f"The player gets into solid 'p{x}/{y}'": "gates" for x, y in PILLARS}


def test_solids_without_a_name_are_told_apart(tmp_path: Path) -> None:
    two = "".join(f"  - {{role: solid, box: {{center: [{x}, 6, 1], size: [3, 3, 2]}}}}\n" for x in (6, -6))
    titles = found(tmp_path, two)
    assert titles == {f"The player gets into solid 'box {n}'": "gates" for n in (5, 6)}


def test_zones_of_one_name_are_told_apart(tmp_path: Path) -> None:
    boxes = (f"center: [{x}, 6, 1.5], size: [4, 4, 3]" for x in (6, -6))
    titles = found(tmp_path, zones(*(forbidden("no entry", box) for box in boxes)))
    names = "no entry", "no entry 2"
    assert titles == {f"The player gets into forbidden zone '{name}'": "gates" for name in names}


def test_a_zone_in_another_and_in_one_that_is_allowed_is_found(tmp_path: Path) -> None:
    allowed = "{name: yard, kind: allowed_off_mesh, box: {center: [6, 0, 1.5], size: [10, 22, 3]}}"
    stage = forbidden("backstage", "center: [6, 0, 1.5], size: [8, 20, 3]")
    vault = forbidden("vault", "center: [8, 0, 1.5], size: [4, 4, 3]")
    titles = found(tmp_path, zones(allowed, stage, vault))
    names = "backstage", "vault"
    assert titles == {f"The player gets into forbidden zone '{name}'": "gates" for name in names}


@pytest.mark.parametrize("size_m", [6.0, 0.6])
def test_who_stands_on_the_floor_is_in_the_zone_that_begins_there(tmp_path: Path, size_m: float) -> None:
    """The character cannot jump, so its feet are never higher than the floor."""
    walker = (
        "{radius_m: 0.34, height_m: 1.8, walk_speed_mps: 6, jump_speed_mps: 0, step_height_m: 0.4, gravity_mps2: 9.8,"
        " slope_limit_deg: 45}"
    )
    box = f"center: [6, 0, 1.5], size: [{size_m}, {size_m}, 3]"
    titles = found(tmp_path, zones(forbidden("z", box)), walker)
    assert titles == {"The player gets into forbidden zone 'z'": "gates"}
