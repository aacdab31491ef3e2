"""Mesh files: what is read from them, and what is wrong with them."""

from __future__ import annotations

import base64
import json
import tracemalloc
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from reachtest.levels import MESH_READERS, NAVMESH_FORMATS, check_level, load_level
from reachtest.levels.meshes.gltf import read_glb
from reachtest.levels.meshes.scene import Unreadable
from tests.unit.levels.make import NAV_OBJ, QUAD, QUAD_FACES, WriteLevel, glb, gltf_tree, only_problem

FLOOR = {"box": {"center": [0, 0, -0.5], "size": [20, 20, 1]}}
Z_UP = {"up_axis": "z"}


def with_mesh(write_level: WriteLevel, name: str, data: bytes | str, **keys: Any) -> Path:
    """The small level with one more mesh, which is what it stands on."""
    path = write_level(geometry=[FLOOR, {"mesh": name, **keys}])
    (path.parent / name).write_bytes(data.encode() if isinstance(data, str) else data)
    return path


def test_tables_hold_what_the_manual_promises() -> None:
    assert set(MESH_READERS) == {".obj", ".glb", ".gltf", ".ply", ".stl", ".xml"}
    assert set(NAVMESH_FORMATS) == {"detour", "godot", "aas", "obj", "glb", "gltf"}


def test_missing_file_lists_near_names(write_level: WriteLevel) -> None:
    where, found, remedy = only_problem(write_level(navmesh={"mesh": "Nav_.obj"}))
    assert where == "level.yaml: navmesh.mesh"
    assert "Nav_.obj does not exist" in found
    assert "did you mean 'nav.obj'?" in remedy


def test_missing_folder_is_said_as_such(write_level: WriteLevel) -> None:
    _, found, _ = only_problem(write_level(navmesh={"mesh": "art/nav.obj"}))
    assert "there is no folder art" in found


@pytest.mark.parametrize("name", ["level.fbx", "level"])
def test_wrong_type_lists_the_valid_ones(write_level: WriteLevel, name: str) -> None:
    _, found, remedy = only_problem(with_mesh(write_level, name, "x"))
    assert name in found
    assert ".glb .gltf .obj .ply .stl .xml" in remedy


def test_navmesh_types_are_fewer(write_level: WriteLevel) -> None:
    path = write_level(navmesh={"mesh": "nav.stl"})
    (path.parent / "nav.stl").write_text("solid\nendsolid\n")
    assert ".aas .bin .glb .gltf .navmesh .obj .tres .tscn" in only_problem(path)[2]


@pytest.mark.parametrize(
    ("name", "data"),
    [
        ("empty.obj", ""),
        ("points.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\n"),
        ("empty.glb", glb(gltf_tree(meshes=[], nodes=[], scenes=[{"nodes": []}]))),
    ],
)
def test_no_triangles(write_level: WriteLevel, name: str, data: bytes | str) -> None:
    where, found, _ = only_problem(with_mesh(write_level, name, data))
    assert where == "level.yaml: geometry[1].mesh"
    assert name in found


@pytest.mark.parametrize("bad", [float("nan"), float("inf")])
def test_vertices_that_are_no_numbers(write_level: WriteLevel, bad: float) -> None:
    vertices = QUAD.copy()
    vertices[2:, 1] = bad
    _, found, _ = only_problem(with_mesh(write_level, "a.glb", glb(vertices=vertices)))
    assert (
        "a.glb: 2 of 4 vertices of 'ground' are NaN, infinite or beyond 1e+07, the first is vertex 2 at"
        in found
    )


@pytest.mark.parametrize("keys", [{"translation": [1.1e7, 0, 0]}, {"scale": [1e30, 1, 1]}])
def test_places_beyond_all_levels_are_refused_after_the_node_s_transform(
    write_level: WriteLevel, keys: dict[str, Any]
) -> None:
    data = glb(gltf_tree(nodes=[{"name": "ground", "mesh": 0, **keys}]))
    assert "a.glb: 4 of 4 vertices of 'ground' are" in only_problem(with_mesh(write_level, "a.glb", data))[1]


def test_faces_out_of_range_glb(write_level: WriteLevel) -> None:
    _, found, _ = only_problem(with_mesh(write_level, "a.glb", glb(faces=[[0, 1, 2], [0, 2, 9]])))
    assert "1 faces of 'ground' name vertices outside of 0 to 3, the first is face 1" in found


@pytest.mark.parametrize(
    ("face", "word"),
    [
        ("f 1 2 9", "line 8 is 'f 1 2 9'"),
        ("f 1 2/1/1 9/1/1", "line 8 is 'f 1 2/1/1 9/1/1'"),
        ("f 1 2 9223372036854775807", "line 8 is"),
        ("f -1 -2 -9", "line 8 is"),
        ("f 1 2 three", "line 8 is 'f 1 2 three'"),
        ("f 1 2x 3", "line 8 is 'f 1 2x 3'"),
        ("f 0 1 2", "vertex number 0 in line 8"),
        ("f 1 2", "fewer than 3 corners"),
    ],
)
def test_faces_out_of_range_obj(write_level: WriteLevel, face: str, word: str) -> None:
    _, found, _ = only_problem(with_mesh(write_level, "a.obj", f"{NAV_OBJ}{face}\n"))
    assert "a.obj" in found
    assert word in found


@pytest.mark.parametrize(
    "line",
    [
        "v 1 0",
        "v",
        "v 1 abc 0",
        "v nan 0 0",
        "v 1 0 -inf",
        "v 1,5 0 0",
        "v 1 2 3 red",
        " v 1 2 3",
        "v 1. .5 e3",
    ],
)
@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_vertices_that_are_not_three_numbers_are_named_by_line_all_at_once(
    write_level: WriteLevel, line: str, end: str
) -> None:
    text = f"{NAV_OBJ}{line}\n".replace("\n", end)
    _, found, remedy = only_problem(with_mesh(write_level, "a.obj", text + "# more\n" + f"{line}\n" * 9))
    assert f"line 8 is '{line.strip()}'; line 10 is" in found
    assert found.endswith("and 5 more")
    assert "three finite numbers" in remedy


def test_every_way_to_write_a_vertex_is_read(write_level: WriteLevel) -> None:
    vertices = ["v\t-9\t-9  +0.0", "v 9. -9 -.0e+0 1.0", "v 9E0 9 0 0.5 0.5 0.5 ", "v -9 \\\n9 0"]
    text = "\ufeff" + "\r\n".join(vertices) + "\nf\t1 2\t3\nf 1 3 \\\n4\n"
    level = load_level(with_mesh(write_level, "a.obj", text))
    assert np.abs(level.collision[12:, :, :2]).tolist() == np.full((2, 3, 2), 9.0).tolist()


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (b"v 1 \0 3", "a NUL at byte 4"),
        (b"v 1 2 3\no h\xfctte\n", "byte 0xfc in line 2"),
        (bytes(range(1, 255)), "0x80"),
    ],
)
def test_obj_that_is_no_text(write_level: WriteLevel, data: bytes, words: str) -> None:
    assert words in only_problem(with_mesh(write_level, "a.obj", data))[1]


def test_relative_numbers_before_more_vertices_would_be_misread(write_level: WriteLevel) -> None:
    text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nf -3 -2 -1\nv 5 0 0\nv 6 0 0\nv 6 1 0\nf -3 -2 -1\n"
    _, found, _ = only_problem(with_mesh(write_level, "a.obj", text))
    assert "relative vertex numbers" in found
    assert "line 4" in found


@pytest.mark.parametrize("key", ["extensionsUsed", "extensionsRequired"])
@pytest.mark.parametrize("extension", ["KHR_draco_mesh_compression", "EXT_meshopt_compression"])
def test_compression_is_refused_by_name(write_level: WriteLevel, key: str, extension: str) -> None:
    tree = gltf_tree(**{key: [extension]})
    _, found, remedy = only_problem(with_mesh(write_level, "a.glb", glb(tree)))
    assert found == f"a.glb uses {extension}, which is not read"
    assert "gltf-transform" in remedy
    path = with_mesh(write_level, "a.gltf", json.dumps(tree))
    assert extension in only_problem(path)[1]


def test_quantised_positions_are_refused(write_level: WriteLevel) -> None:
    tree = gltf_tree()
    tree["accessors"][0].update(componentType=5122, normalized=True)
    assert "quantised positions" in only_problem(with_mesh(write_level, "a.glb", glb(tree)))[1]


def test_all_that_is_not_read_is_said_at_once(write_level: WriteLevel) -> None:
    tree = gltf_tree(
        extensionsUsed=["EXT_meshopt_compression"], buffers=[{"byteLength": 72, "uri": "no.bin"}]
    )
    tree["accessors"][0].update(componentType=5122, normalized=True)
    _, found, remedy = only_problem(with_mesh(write_level, "a.gltf", json.dumps(tree)))
    for words in ("EXT_meshopt_compression", "quantised positions", "no.bin, which does not exist"):
        assert words in found
    for words in ("without compression", "dequantize", "next to the file"):
        assert words in remedy


@pytest.mark.parametrize(
    ("part", "index", "change", "words"),
    [
        ("accessors", 0, {"count": 300_000_000, "bufferView": None}, "accessors[0] has no bufferView"),
        ("accessors", 1, {"count": 300_000_000, "bufferView": None}, "its count of 300,000,000"),
        ("accessors", 0, {"count": 3_000}, "accessors[0] needs 36,000 bytes"),
        ("accessors", 1, {"byteOffset": 4}, "accessors[1] needs 28 bytes"),
        ("accessors", 1, {"count": 5}, "5 corners"),
        ("accessors", 1, {"type": "VEC9"}, "accessors[1].type is 'VEC9'"),
        ("accessors", 1, {"bufferView": 7}, "names bufferViews[7], and there are 2"),
        ("bufferViews", 0, {"byteStride": 8}, "byteStride 8, less than the 12 bytes"),
        ("bufferViews", 1, {"byteLength": 240}, "ends at byte 288 of buffers[0], which has 72"),
        ("bufferViews", 1, {"buffer": 3}, "names buffers[3], and there are 1"),
        ("nodes", 0, {"mesh": 4}, "nodes[0] names meshes[4], and there are 1"),
        ("nodes", 0, {"matrix": [1.0]}, "nodes[0].matrix is [1.0]"),
        ("scenes", 0, {"nodes": [9]}, "scenes[0] names nodes[9]"),
    ],
)
def test_gltf_that_points_nowhere_is_refused_by_number_and_in_little_memory(
    tmp_path: Path, part: str, index: int, change: dict[str, Any], words: str
) -> None:
    tree = gltf_tree()
    entry = {**tree[part][index], **change}
    tree[part][index] = {key: value for key, value in entry.items() if value is not None}
    data = glb(tree)
    tracemalloc.start()
    try:
        with pytest.raises(Unreadable) as raised:
            read_glb(data, tmp_path / "a.glb")
        assert tracemalloc.get_traced_memory()[1] < 1_000_000
    finally:
        tracemalloc.stop()
    assert words in raised.value.found


def test_all_mistakes_of_a_gltf_at_once(write_level: WriteLevel) -> None:
    tree = gltf_tree(nodes=5)
    del tree["accessors"][1]["type"]
    _, found, _ = only_problem(with_mesh(write_level, "a.glb", glb(tree)))
    assert "nodes is 5" in found
    assert "accessors[1].type is missing" in found


def test_arrays_that_nobody_reads_cost_nothing_and_may_be_wrong(write_level: WriteLevel) -> None:
    tree = gltf_tree()
    tree["accessors"] += [{"componentType": 5126, "count": 300_000_000, "type": "VEC3"}]
    tree["bufferViews"] += [{"buffer": 0, "byteOffset": 72, "byteLength": 1000}]
    tree["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = 2
    path = with_mesh(write_level, "a.glb", glb(tree), **Z_UP)
    assert len(load_level(path).collision) == 14


@pytest.mark.parametrize(
    ("at", "byte", "words"),
    [
        (4, 1, "version 1 at byte 4"),
        (12, 250, "has a chunk of"),
        (16, 0, "at byte 16"),
        (21, 0, "at byte 21"),
        (24, 255, "at byte 24"),
    ],
)
def test_damaged_glb_names_the_byte(write_level: WriteLevel, at: int, byte: int, words: str) -> None:
    data = bytearray(glb())
    data[at] = byte
    if at == 12:
        data[at + 1] = byte
    assert words in only_problem(with_mesh(write_level, "a.glb", bytes(data)))[1]


def test_buffer_file_that_is_not_there(write_level: WriteLevel) -> None:
    tree = gltf_tree(buffers=[{"uri": "level%20data.bin", "byteLength": 72}])
    path = with_mesh(write_level, "a.gltf", json.dumps(tree), **Z_UP)
    assert "names the buffer level data.bin, which does not exist" in only_problem(path)[1]
    (path.parent / "level data.bin").write_bytes(QUAD.tobytes() + QUAD_FACES.tobytes())
    first = load_level(path)
    assert len(first.collision) == 14
    (path.parent / "level data.bin").write_bytes((QUAD * 0.5).tobytes() + QUAD_FACES.tobytes())
    assert load_level(path).sha256 != first.sha256


@pytest.mark.parametrize("keep", [3, 16, 100, -1])
def test_truncated_glb(write_level: WriteLevel, keep: int) -> None:
    where, found, remedy = only_problem(with_mesh(write_level, "a.glb", glb()[:keep]))
    assert where == "level.yaml: geometry[1].mesh"
    assert found.startswith("a.glb")
    assert "again" in remedy or "export" in remedy


@pytest.mark.parametrize(
    ("name", "data"), [("a.glb", b"\0" * 200), ("a.ply", b"ply\nformat"), ("a.stl", b"\1" * 90)]
)
def test_corrupt_file(write_level: WriteLevel, name: str, data: bytes) -> None:
    where, found, _ = only_problem(with_mesh(write_level, name, data))
    assert where == "level.yaml: geometry[1].mesh"
    assert name in found


def test_degenerate_triangles_are_left_out_and_counted(write_level: WriteLevel) -> None:
    text = NAV_OBJ + "f 1 1 2\nf 1 2 2\n"
    level = load_level(with_mesh(write_level, "a.obj", text))
    assert len(level.collision) == 14
    assert dict(check_level(level).facts)["collision"] == "14 triangles (2 degenerate ones left out)"


def test_mesh_scaled_to_nothing(write_level: WriteLevel) -> None:
    where, found, remedy = only_problem(with_mesh(write_level, "a.obj", NAV_OBJ, scale=1e-9))
    assert where == "level.yaml: geometry[1].mesh"
    assert "all triangles of a.obj are thinner" in found
    assert "scale" in remedy


def test_gltf_is_y_up_and_obj_follows_the_frame(write_level: WriteLevel) -> None:
    path = with_mesh(write_level, "a.glb", glb(vertices=[[0, 1, 2], [3, 1, 2], [3, 1, -4], [0, 5, -4]]))
    np.testing.assert_allclose(load_level(path).collision[12, 0], [0, -2, 1])
    path = with_mesh(
        write_level, "a.glb", glb(vertices=[[0, 1, 2], [3, 1, 2], [3, 1, -4], [0, 5, -4]]), **Z_UP
    )
    np.testing.assert_allclose(load_level(path).collision[12, 0], [0, 1, 2])


def test_units_scale_and_flip(write_level: WriteLevel) -> None:
    obj = "v 100 0 0\nv 300 0 0\nv 300 400 0\nf 1 2 3\n"
    path = with_mesh(write_level, "a.obj", obj, units="cm", scale=2.0, flip_x=True)
    triangle = load_level(path).collision[12]
    assert {tuple(corner) for corner in triangle.tolist()} == {(-2, 0, 0), (-6, 0, 0), (-6, 8, 0)}
    assert np.cross(triangle[1] - triangle[0], triangle[2] - triangle[0])[2] > 0  # still seen from above


def test_node_transforms_nest_and_mirrored_nodes_keep_facing_up(write_level: WriteLevel) -> None:
    nodes = [
        {"name": "parent", "translation": [1, 0, 0], "children": [1]},
        {"name": "mirrored", "mesh": 0, "translation": [0, 2, 0], "scale": [-0.1, 1, 1]},
    ]
    quad = np.array([[0, 0, 0], [10, 0, 0], [10, 0, -3], [0, 0, -3]])
    level = load_level(with_mesh(write_level, "a.glb", glb(gltf_tree(nodes=nodes), vertices=quad)))
    added = level.collision[12:]
    np.testing.assert_allclose([added.min(axis=(0, 1)), added.max(axis=(0, 1))], [[0, 0, 2], [1, 3, 2]])
    normals = np.cross(added[:, 1] - added[:, 0], added[:, 2] - added[:, 0])
    assert (normals[:, 2] > 0).all()
    assert level.parts[1].name == "mirrored"


def test_nodes_choose_by_pattern_and_name_the_places(write_level: WriteLevel) -> None:
    nodes = [
        {"name": name, "mesh": 0, "translation": [x, 0, 0]}
        for x, name in enumerate(["wall_a", "wall_b", "fx"])
    ]
    data = glb(gltf_tree(nodes=nodes, scenes=[{"nodes": [0, 1, 2]}]))
    level = load_level(with_mesh(write_level, "a.glb", data, nodes=["wall_*"], **Z_UP))
    assert [part.name for part in level.parts] == ["box 0", "wall_a", "wall_b"]
    where, found, remedy = only_problem(with_mesh(write_level, "a.glb", data, nodes=["wal_a", "fx"]))
    assert where == "level.yaml: geometry[1].nodes[0]"
    assert "matches no node" in found
    assert "did you mean 'wall_a'?" in remedy


def test_node_of_several_materials_is_one_part_in_the_same_order_every_time(write_level: WriteLevel) -> None:
    primitives = [{"attributes": {"POSITION": 0}, "indices": 1, "material": index} for index in (0, 1)]
    primitives += [{"attributes": {"POSITION": 0}, "mode": 1}]  # lines do not matter
    tree = gltf_tree(meshes=[{"primitives": primitives}], materials=[{}, {}])
    path = with_mesh(write_level, "a.glb", glb(tree), nodes=["ground"], **Z_UP)
    level, again = load_level(path), load_level(path)
    assert [part.name for part in level.parts] == ["box 0", "ground"]
    assert len(level.collision) == 16
    np.testing.assert_array_equal(level.collision, again.collision)


def test_mesh_under_a_camera_stays_in_its_place(write_level: WriteLevel) -> None:
    nodes = [{"camera": 0, "children": [1], "translation": [0, 0, 0.25]}, {"name": "ground", "mesh": 0}]
    tree = gltf_tree(nodes=nodes, cameras=[{"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}}])
    level = load_level(with_mesh(write_level, "a.glb", glb(tree), **Z_UP))
    assert (level.collision[12:, :, 2] == 0.25).all()


def test_obj_groups_are_parts_and_the_file_is_one_without_groups(write_level: WriteLevel) -> None:
    vertices = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
    level = load_level(with_mesh(write_level, "a.obj", f"{vertices}o left\nf 1 2 3\no right\nf 1 3 4\n"))
    assert [part.name for part in level.parts][1:] == ["left", "right"]
    level = load_level(with_mesh(write_level, "hall.obj", f"{vertices}f 1 2 3 4\nusemtl b\nf 4 3 2\n"))
    assert [part.name for part in level.parts][1:] == ["hall"]
    assert len(level.collision) == 15


@pytest.mark.parametrize("suffix", ["obj", "ply", "stl", "glb"])
def test_solid_mesh_in_every_format(write_level: WriteLevel, suffix: str) -> None:
    import trimesh

    box = trimesh.creation.box(extents=[2, 2, 2]).apply_translation([5, 5, 3])
    data = box.export(file_type=suffix)
    level = load_level(with_mesh(write_level, f"a.{suffix}", data, role="solid", up_axis="z"))
    solid = level.solids[0].triangles
    assert solid.shape == (12, 3, 3)
    np.testing.assert_allclose([solid.min(axis=(0, 1)), solid.max(axis=(0, 1))], [[4, 4, 2], [6, 6, 4]])


def test_inside_out_solid_is_turned_outwards(write_level: WriteLevel) -> None:
    import trimesh

    box = trimesh.creation.box(extents=[2, 2, 2]).apply_translation([5, 5, 3])
    box.invert()
    solid = load_level(with_mesh(write_level, "a.ply", box.export(file_type="ply"), role="solid")).solids[0]
    assert np.linalg.det(solid.triangles).sum() / 6 == pytest.approx(8)


def test_open_solid_says_how_open_and_where(write_level: WriteLevel) -> None:
    import trimesh

    box = trimesh.creation.box(extents=[2, 2, 2]).apply_translation([5, 5, 3])
    box.update_faces(np.arange(12) != 4)
    where, found, _ = only_problem(with_mesh(write_level, "a.ply", box.export(file_type="ply"), role="solid"))
    assert where == "level.yaml: geometry[1]"
    assert "not watertight: 3 of 18 edges are open" in found


def test_solid_with_turned_faces(write_level: WriteLevel) -> None:
    import trimesh

    box = trimesh.creation.box(extents=[2, 2, 2]).apply_translation([5, 5, 3])
    box.faces[0] = box.faces[0][::-1]
    found = only_problem(with_mesh(write_level, "a.ply", box.export(file_type="ply"), role="both"))[1]
    assert "faces look opposite ways" in found


def test_embedded_buffers(write_level: WriteLevel) -> None:
    uri = (
        "data:application/octet-stream;base64,"
        + base64.b64encode(QUAD.tobytes() + QUAD_FACES.tobytes()).decode()
    )
    tree = gltf_tree(buffers=[{"byteLength": 72, "uri": uri}])
    assert len(load_level(with_mesh(write_level, "a.gltf", json.dumps(tree), **Z_UP)).collision) == 14
