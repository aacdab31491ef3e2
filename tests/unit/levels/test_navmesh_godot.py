"""Nav-meshes of Godot: resources and scenes as its versions write them, and damaged ones."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from reachtest.levels import load_level
from reachtest.levels.meshes.scene import Piece, Unreadable
from reachtest.levels.navmeshes.godot import read_godot
from tests.unit.levels.make import WriteLevel, only_problem

SHARED = Path(__file__).parents[4] / "shared" / "levels"
POINTS = "-9, 0.5, -9, -9, 0.5, 9, 9, 0.5, 9, 9, 0.5, -9"
RESOURCE = '[gd_resource type="NavigationMesh" format=3]\n\n[resource]\n'
BARE = "polygons = [PackedInt32Array(0, 1, 2, 3)]\n"
TYPED = "polygons = Array[PackedInt32Array]([PackedInt32Array(0, 1, 2), PackedInt32Array(0, 2, 3)])\n"
GODOT_3 = (
    '[gd_resource type="NavigationMesh" format=2]\n\n[resource]\n'
    f"vertices = PoolVector3Array( {POINTS} )\n"
    "polygons = [ PoolIntArray( 0, 1, 2 ), PoolIntArray( 0, 2, 3 ) ]\nagent/height = 2.0\n"
)


def godot_4(polygons: str = BARE, points: str = POINTS) -> str:
    return f"{RESOURCE}vertices = PackedVector3Array({points})\n{polygons}agent_radius = 0.34\n"


def scene(nodes: str, script: str = "") -> str:
    head = "[gd_scene load_steps=3 format=3]\n\n"
    source = f'[sub_resource type="GDScript" id="code"]\nscript/source = "{script}"\n\n'
    head += source if script else ""
    head += '[sub_resource type="NavigationMesh" id="mesh_a1"]\n'
    return f"{head}vertices = PackedVector3Array({POINTS})\n{BARE}\n{nodes}"


REGION = 'type="NavigationRegion3D"'
USES = 'navigation_mesh = SubResource("mesh_a1")\n'
NODES = (
    '[node name="World" type="Node3D"]\n\n'
    '[node name="Wing" type="Node3D" parent="."]\ntransform = Transform3D(0, 0, 1, 0, 1, 0, -1, 0, 0, 100, 0, 0)\n\n'
    f'[node name="Floor" {REGION} parent="Wing"]\ntransform = Transform3D(1, 0, 0, 0, 1, 0, 0, 0, 1, 10, 2, 0)\n{USES}'
)


def read(text: str) -> list[Piece]:
    return read_godot(text.encode(), Path("hall.tres")).pieces


@pytest.mark.parametrize(
    "text", [godot_4(), godot_4(TYPED), GODOT_3, GODOT_3.replace("\n", "\r\n")], ids=["4", "4.4", "3", "CRLF"]
)
def test_every_version_gives_the_same_square(text: str) -> None:
    (piece,) = read(text)
    assert piece.name == "hall"
    np.testing.assert_array_equal(piece.faces, [[0, 1, 2], [0, 2, 3]])
    assert set(map(tuple, piece.vertices.tolist())) == {(x, 0.5, z) for x in (-9, 9) for z in (-9, 9)}


@pytest.mark.parametrize("suffix", ["tres", "tscn"])
def test_level_takes_it_as_y_up_and_metres(write_level: WriteLevel, suffix: str) -> None:
    floor = {"box": {"center": [0, 0, -50], "size": [2000, 2000, 100]}}
    frame = {"up_axis": "z", "units": "cm"}
    path = write_level(navmesh={"mesh": f"nav.{suffix}"}, frame=frame, geometry=[floor])
    path.with_name(f"nav.{suffix}").write_text(godot_4() if suffix == "tres" else scene(""))
    vertices = load_level(path).navmesh.vertices
    np.testing.assert_allclose([vertices.min(axis=0), vertices.max(axis=0)], [[-9, -9, 0.5], [9, 9, 0.5]])


def test_region_stands_where_its_node_and_the_parents_put_it() -> None:
    (piece,) = read(scene(NODES))
    assert piece.name == "Floor"
    # (-9, 0.5, -9) goes by (10, 2, 0), then (x, y, z) -> (z, y, -x), then by (100, 0, 0)
    np.testing.assert_allclose(piece.vertices[0], [91, 2.5, -1])


def test_mesh_of_two_regions_is_there_twice_and_without_a_region_once() -> None:
    twice = '[node name="World" type="Node3D"]\n' + "".join(
        f'[node name="{name}" {REGION} parent="."]\n{USES}' for name in ("A", "B")
    )
    assert [piece.name for piece in read(scene(twice))] == ["A", "B"]
    assert [piece.name for piece in read(scene(""))] == ["hall"]


def test_godot_3_scene_numbers_its_resources() -> None:
    text = (
        '[gd_scene format=2]\n[sub_resource type="NavigationMesh" id=1]\n'
        f"vertices = PoolVector3Array( {POINTS} )\npolygons = [ PoolIntArray( 0, 1, 2, 3 ) ]\n"
        '[node name="Nav" type="NavigationMeshInstance"]\n'
        "transform = Transform( 1, 0, 0, 0, 1, 0, 0, 0, 1, 5, 0, 0 )\nnavmesh = SubResource( 1 )\n"
    )
    (piece,) = read(text)
    assert (piece.name, piece.vertices[:, 0].min()) == ("Nav", -4)


def test_what_a_script_says_is_not_read() -> None:
    script = 'vertices = PackedVector3Array(7)\n[resource]\nvar a = \\"(\\"\n; x'
    np.testing.assert_array_equal(read(scene(NODES, script))[0].vertices, read(scene(NODES))[0].vertices)


@pytest.mark.parametrize(
    ("text", "found"),
    [
        (godot_4(points=f"{POINTS}, 1"), "13 coordinates of vertices, no multiple of 3, in line 4"),
        (godot_4(points=POINTS.replace("0.5", "nan", 1)), "with nan, NaN, infinite or too far away, in line 4"),
        (godot_4(points=POINTS.replace("0.5", "inf", 1)), "with inf, NaN, infinite or too far away, in line 4"),
        (godot_4(points=POINTS.replace("0.5", "1e9", 1)), "with 1e9, NaN, infinite or too far away, in line 4"),
        (godot_4(points=POINTS.replace("0.5", "0,\n5x", 1)), "'5x', which is no number, in line 5"),
        (godot_4(BARE.replace("3)", "4)")), "corner outside of the 4 vertices in line 5"),
        (godot_4(BARE.replace("0,", "-1,")), "corner outside of the 4 vertices in line 5"),
        (godot_4(BARE.replace("0, 1, ", "")), "a polygon with 2 corners in line 5"),
        (godot_4("polygons = [PackedInt32Array(0, 1"), "no complete PackedInt32Array in line 5"),
        (godot_4("polygons = 3\n"), "polygons that are no list in line 5"),
        (RESOURCE + "vertices = PackedVector3Array(1, 2", "vertices without an end or of an unknown type in line 4"),
        (scene(NODES.replace("100, 0, 0", "100, 0")), "a transform of 11 numbers in line 10"),
        (scene(NODES + 'x = "never closed\n'), "a string without an end, which starts in line 15"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_said_with_its_line(text: str, found: str) -> None:
    with pytest.raises(Unreadable) as raised:
        read(text)
    assert raised.value.found.endswith(found)


@pytest.mark.parametrize("text", ["", RESOURCE, godot_4("polygons = []\n"), godot_4("")])
def test_mesh_that_was_never_baked(text: str) -> None:
    with pytest.raises(Unreadable, match="holds no triangles") as raised:
        read(text)
    assert "bake" in raised.value.remedy
    assert ("line 3 are empty" in raised.value.found) == bool(text)


def test_binary_resource_is_refused_by_its_line() -> None:
    with pytest.raises(Unreadable, match="is no UTF-8 text in line 2") as raised:
        read_godot(b"RSRC\n\xff\xfe", Path("a.tres"))
    assert "as text" in raised.value.remedy


def test_problem_of_a_level_names_the_file(write_level: WriteLevel) -> None:
    path = write_level(navmesh={"mesh": "nav.tres"})
    path.with_name("nav.tres").write_text(godot_4("polygons = 3\n"))
    where, found, _ = only_problem(path)
    assert (where, found) == ("level.yaml: navmesh.mesh", "nav.tres has polygons that are no list in line 5")


@pytest.mark.skipif(not SHARED.exists(), reason="no real levels beside the project")
def test_real_navmesh_written_as_godot_does() -> None:
    lines = (SHARED / "three_pathfinding" / "level.nav.obj").read_text().splitlines()
    points = np.array([line.split()[1:4] for line in lines if line.startswith("v ")], dtype=np.float64)
    corners = [
        [int(w.split("/")[0]) - 1 for w in line.split()[1:]] for line in lines if line.startswith("f ")
    ]
    arrays = ", ".join(f"PackedInt32Array({', '.join(map(str, each))})" for each in corners)
    (piece,) = read(godot_4(f"polygons = [{arrays}]\n", ", ".join(map(str, points.ravel()))))
    np.testing.assert_array_equal(piece.vertices, points)
    assert len(piece.faces) == sum(len(each) - 2 for each in corners) > 100


@settings(max_examples=150, deadline=None)
@given(st.sampled_from([godot_4(), GODOT_3, scene(NODES)]), st.data())
def test_damage_is_refused_or_gives_a_sound_mesh(text: str, data: st.DataObject) -> None:
    raw = bytearray(text.encode())
    at = data.draw(st.integers(0, len(raw) - 1))
    if data.draw(st.booleans()):
        del raw[at:]
    else:
        raw[at] = data.draw(st.integers(0, 255))
    said, pieces = "", []
    try:
        pieces = read_godot(bytes(raw), Path("a.tres")).pieces
    except Unreadable as error:
        said = error.found
    assert bool(pieces) or "line" in said or "no baked NavigationMesh" in said
    for piece in pieces:
        assert len(piece.faces)
        assert 0 <= piece.faces.min() <= piece.faces.max() < len(piece.vertices)
        assert np.isfinite(piece.vertices).all()
