"""What a nav-mesh file says beside its surface: format, agent, areas, links; and which format it is at all."""

from __future__ import annotations

import json
import struct
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from reachtest.errors import BadInput
from reachtest.geometry import triangle_normals
from reachtest.levels import NAVMESH_FORMATS, load_level, read_navmesh_file
from reachtest.records import NavMesh
from tests.unit.levels.make import NAV_OBJ, WriteLevel, glb, only_problem
from tests.unit.levels.test_navmesh_aas import SQUARE, aas, lumps, reach
from tests.unit.levels.test_navmesh_detour import HABITAT, KINDS, full_tile, shared, tile_set
from tests.unit.levels.test_navmesh_godot import godot_4

FILES: dict[str, bytes] = {
    "detour": tile_set(full_tile("recast32")),
    "godot": godot_4().encode(),
    "aas": aas(lumps(SQUARE)),
    "obj": NAV_OBJ.encode(),
    "glb": glb(),
}
REAL_GLBS = (
    "three_pathfinding/level.nav.glb",
    "demo_level/demo-level-navmesh.glb",
    "tut3d/navmesh.gltf",
    "nav_test/nav_test.solo.navmesh.glb",
    "dungeon/dungeon.solo.navmesh.glb",
    "oa_dm1/oa_dm1.aas_ground.glb",
    "oa_dm1/oa_dm1.solo.navmesh.glb",
    "aggressor/aggressor.solo.navmesh.glb",
)


def read(folder: Path, data: bytes, name: str = "nav.dat", **keys: Any) -> NavMesh:
    (folder / name).write_bytes(data)
    return read_navmesh_file(folder / name, **keys)


def area(navmesh: NavMesh) -> float:
    return float(triangle_normals(navmesh.triangles)[1].sum())


# --- which format ---------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["nav.dat", "nav", "nav.bin", "nav.obj", "nav.glb"])
@pytest.mark.parametrize("kind", FILES)
def test_content_decides_whatever_the_file_is_called(tmp_path: Path, kind: str, name: str) -> None:
    found = read(tmp_path, FILES[kind], name)
    assert found.format == read(tmp_path, FILES[kind], "x", format=kind).format
    assert area(found) > 0


def test_a_gltf_with_its_buffer_beside_it(tmp_path: Path) -> None:
    import trimesh

    files = trimesh.Scene(trimesh.creation.box()).export(file_type="gltf")
    for name, data in files.items():
        (tmp_path / name).write_bytes(data)
    (tmp_path / "model.gltf").rename(tmp_path / "nav.bin")
    assert read_navmesh_file(tmp_path / "nav.bin").format == "glTF"


def test_level_says_the_format_and_is_held_to_it(write_level: WriteLevel) -> None:
    path = write_level(navmesh={"mesh": "nav.obj", "format": "obj"})
    assert load_level(path).navmesh.format == "OBJ"
    path = write_level(navmesh={"mesh": "nav.obj", "format": "detour"})
    assert "no Detour tile set" in only_problem(path)[1]
    path = write_level(navmesh={"mesh": "nav.obj", "format": "detuor"})
    where, _, remedy = only_problem(path)
    assert where == "level.yaml: navmesh.format"
    assert "detour" in remedy
    assert all(name in remedy for name in NAVMESH_FORMATS)


def test_nothing_known_lists_what_is(tmp_path: Path) -> None:
    with pytest.raises(BadInput) as raised:
        read(tmp_path, b"once upon a time")
    assert all(name in raised.value.problems[0].remedy for name in NAVMESH_FORMATS)


# --- agent, areas, links --------------------------------------------------------------------------


@pytest.mark.parametrize("kind", KINDS)
def test_detour_agent_areas_and_links_arrive_in_metres(tmp_path: Path, kind: str) -> None:
    found = read(tmp_path, tile_set(full_tile(kind), kind=kind), units="cm")
    raw = read(tmp_path, tile_set(full_tile(kind), kind=kind))
    assert found.polygons == 1
    assert len(found.faces) == 4
    assert found.areas is not None
    assert found.areas.tolist() == [9] * 4
    (link,) = found.links
    turn = -1 if "unreal" in kind else 1
    np.testing.assert_allclose(link.start, [0.01 * turn, 0.01 * turn, 0], atol=1e-9)  # (1, 0, -1), y up
    np.testing.assert_allclose(link.end - link.start, [0, 0, 0.05], atol=1e-9)
    assert (link.kind, link.both_ways) == ("off-mesh", True)
    assert link.radius_m == pytest.approx(0.005)
    assert raw.agent.radius_m is not None
    assert found.agent.radius_m == pytest.approx(raw.agent.radius_m / 100)


def test_habitat_settings_add_the_slope(tmp_path: Path) -> None:
    data = tile_set(full_tile("recast32"), version=2, settings_bytes=HABITAT)
    assert read(tmp_path, data).agent.slope_deg == pytest.approx(45)
    wrong = bytearray(data)
    struct.pack_into("<f", wrong, 60, float("nan"))
    with pytest.raises(BadInput, match="byte 60"):
        read(tmp_path, bytes(wrong))


def test_unreal_s_obj_export_states_its_agent(tmp_path: Path) -> None:
    lines = "# AgentHeight\nrd_agh 144.0\nrd_agr 34.0\nrd_amc 35.0\nrd_ams 44.0\nrd_cs 19.0\n"
    agent = read(tmp_path, (NAV_OBJ + lines).encode(), units="cm").agent
    assert agent.height_m == pytest.approx(1.44)
    assert agent.radius_m == pytest.approx(0.34)
    assert agent.climb_m == pytest.approx(0.35)
    assert agent.slope_deg == 44
    assert read(tmp_path, NAV_OBJ.encode()).agent.height_m is None
    for wrong in ("nan", "-1", "tall", "1e30"):
        with pytest.raises(BadInput, match="line 9"):
            read(tmp_path, (NAV_OBJ + f"rd_cs 1\nrd_agh {wrong}\n").encode())


def test_godot_agent_is_what_is_written_and_else_the_default(tmp_path: Path) -> None:
    text = godot_4() + "agent_max_slope = 30.0\n"
    found = read(tmp_path, text.encode())
    assert vars(found.agent) == {"radius_m": 0.34, "height_m": 1.5, "climb_m": 0.25, "slope_deg": 30.0}
    assert (found.polygons, len(found.faces)) == (1, 2)
    with pytest.raises(BadInput, match="line"):
        read(tmp_path, (godot_4() + "agent_height = nan\n").encode())


def test_aas_reachability_is_links_by_kind_without_walking(tmp_path: Path) -> None:
    boxes = struct.pack("<2i6f", 2, 0, -15, -15, -24, 15, 15, 32)
    boxes += struct.pack("<2i6f", 4, 1, -15, -15, -24, 15, 15, 8)
    ways = [reach(0, (0, 0, 0), (0, 0, 0)), reach(2, (0, 0, 0), (1, 0, 0)), reach(5, (0, 0, 0), (8, 0, 0))]
    ways += [reach(10 | 1 << 24, (1, 2, 3), (4, 5, 6)), reach(18, (0, 0, 0), (0, 0, 40))]
    data = aas({**lumps(SQUARE), 0: boxes, 9: b"".join(ways)})
    found = read(tmp_path, data, units=0.03125)
    assert [link.kind for link in found.links] == ["jump", "teleport", "jump pad"]
    assert found.links[1].start.tolist() == [1 / 32, 2 / 32, 3 / 32]
    assert not found.links[1].both_ways
    assert (found.agent.radius_m, found.agent.height_m) == pytest.approx((15 / 32, 56 / 32))
    wrong = aas({**lumps(SQUARE), 9: reach(5, (0, 0, float("nan")), (0, 0, 0))})
    with pytest.raises(BadInput, match=r"reachability\[0\] at byte"):
        read(tmp_path, wrong)


# --- real files -----------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["oa_dm1", "aggressor"])
def test_reachability_of_a_real_map(tmp_path: Path, name: str) -> None:
    """The map's own reachability, written back into a file as the game has it: every kind, every place."""
    given = json.loads(shared(name, f"{name}.aas.json").read_text())["reach"]
    number = {"WALK": 2, "CROUCH": 3, "BARRIERJUMP": 4, "JUMP": 5, "LADDER": 6, "WALKOFFLEDGE": 7, "SWIM": 8}
    number |= {"WATERJUMP": 9, "TELEPORT": 10, "ELEVATOR": 11, "JUMPPAD": 18, "FUNCBOB": 19, "ROCKETJUMP": 12}
    back = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]]) * 32.0  # (x, y, z) of y up in metres, times this
    ways = [(number[w["type"]], np.array([w["start"], w["end"]]) @ back.T) for w in given]
    data = aas({**lumps(SQUARE), 9: b"".join(reach(kind, *ends) for kind, ends in ways)})
    found = read(tmp_path, data, units=0.03125)
    kept = [ends / 32 for kind, ends in ways if kind not in (2, 3)]
    assert len(found.links) == len(kept) > 50
    assert {"walk off ledge", "teleport"} & {link.kind for link in found.links}
    np.testing.assert_allclose([(link.start, link.end) for link in found.links], kept, atol=1e-3)


@pytest.mark.parametrize("file", REAL_GLBS)
def test_shipped_glb_has_the_area_that_another_reader_finds(file: str) -> None:
    import trimesh

    path = shared(*file.split("/"))
    found = read_navmesh_file(path)
    other = trimesh.load(path, force="mesh", process=False)
    assert area(found) == pytest.approx(float(other.area), rel=1e-5)
    assert len(found.faces) == int((other.area_faces > 1e-6).sum())  # the rest is no surface


def test_the_same_mesh_as_obj_and_glb() -> None:
    glb_, obj = (
        read_navmesh_file(shared("three_pathfinding", f"level.nav.{e}"), up_axis="y") for e in ("glb", "obj")
    )
    assert area(glb_) == pytest.approx(area(obj), rel=1e-3)
    assert len(glb_.faces) == len(obj.faces) == obj.polygons


# --- reachtest navmesh info -----------------------------------------------------------------------


def info(*arguments: Any) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "reachtest", "navmesh", "info", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True)


def test_info_prints_a_table_and_the_same_as_json(tmp_path: Path) -> None:
    file = tmp_path / "nav.bin"
    file.write_bytes(tile_set(full_tile("recast64"), kind="recast64"))
    shown = info(file)
    assert shown.returncode == 0, shown.stderr
    for words in ("Recast, 64-bit references", "1 off-mesh", "radius", "9: ", "islands    1, of"):
        assert words in shown.stdout
    found = json.loads(info(file, "--json").stdout)
    assert (found["polygons"], found["triangles"], found["links"]) == (1, 4, {"off-mesh": 1})
    assert found["areas_m2"]["9"] == pytest.approx(found["area_m2"])
    turned = json.loads(info(file, "--json", "--up-axis", "z", "--units", "cm").stdout)
    assert turned["area_m2"] == pytest.approx(found["area_m2"] / 1e4)
    assert turned["bounds"] != found["bounds"]


@pytest.mark.parametrize("arguments", [(), ("--units", "miles"), ("--format", "fbx")])
def test_info_of_what_is_no_navmesh_is_bad_input(tmp_path: Path, arguments: tuple[str, ...]) -> None:
    (tmp_path / "nav.bin").write_bytes(b"TESM\1\0\0\0")
    done = info(tmp_path / "nav.bin", *arguments)
    assert done.returncode == 2
    assert "problem" in done.stderr


def test_info_of_a_folder_and_of_an_empty_file(tmp_path: Path) -> None:
    (tmp_path / "nav.bin").touch()
    with pytest.raises(BadInput, match=r"nav\.bin is empty"):
        read_navmesh_file(tmp_path / "nav.bin")
    with pytest.raises(BadInput, match=r"\. is not a file; name the mesh file itself"):
        read_navmesh_file(Path("."))
