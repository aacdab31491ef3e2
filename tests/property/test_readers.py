"""Readers and frames, whatever they are given."""

from __future__ import annotations

import tempfile
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from reachtest.errors import BadInput
from reachtest.levels import MESH_READERS, NAVMESH_FORMATS, read_navmesh_file
from reachtest.levels.frames import UNITS, UP_AXES, make_frame, unit_name
from reachtest.levels.keys.geometry import FrameSpec, MeshSpec
from reachtest.levels.meshes.read import Mesh, read_mesh
from reachtest.levels.meshes.solids import find_leaks
from tests.unit.levels.make import NAV_OBJ, glb
from tests.unit.levels.test_navmesh_aas import SQUARE, aas, lumps, reach
from tests.unit.levels.test_navmesh_detour import HABITAT, KINDS, full_tile, tile_set
from tests.unit.levels.test_navmesh_godot import NODES, godot_4, scene

coordinates = st.floats(-1e5, 1e5, allow_nan=False)
points = st.tuples(coordinates, coordinates, coordinates)
units = st.one_of(st.sampled_from(sorted(UNITS)), st.floats(1e-4, 1e3))
frames = st.builds(make_frame, st.sampled_from(sorted(UP_AXES)), units, st.floats(1e-2, 1e2), st.booleans())


def read(data: bytes, suffix: str) -> Mesh:
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / f"m{suffix}").write_bytes(data)
        spec = MeshSpec.model_validate({"mesh": f"m{suffix}", "up_axis": "z"})
        return read_mesh(
            spec, Path(folder), FrameSpec.model_validate({}), MESH_READERS, "level.yaml: geometry[0]"
        )


def box(suffix: str) -> bytes:
    import trimesh

    mesh = trimesh.creation.box(extents=[2, 3, 4])
    data = mesh.export(file_type=suffix.removeprefix("."))
    return data if isinstance(data, bytes) else str(data).encode()


BOXES = {suffix: box(suffix) for suffix in (".obj", ".glb", ".ply", ".stl")}


@given(frames, points)
def test_frame_there_and_back(frame, point) -> None:
    there = frame.to_level(np.array(point))
    np.testing.assert_allclose(frame.to_source(there), point, rtol=1e-9, atol=1e-6)


@given(frames, points, points)
def test_frame_only_scales_distances(frame, one, other) -> None:
    scale = np.cbrt(abs(np.linalg.det(frame.matrix)))
    before = np.linalg.norm(np.subtract(one, other))
    after = np.linalg.norm(frame.to_level(np.array(one)) - frame.to_level(np.array(other)))
    assert after == pytest.approx(before * scale, rel=1e-6, abs=1e-6)


@given(st.sampled_from(sorted(UP_AXES)), units)
def test_up_is_up(up_axis, unit) -> None:
    up = {"y": [0.0, 1.0, 0.0], "z": [0.0, 0.0, 1.0]}[up_axis]
    frame = make_frame(up_axis, unit)
    assert frame.to_level(np.array(up))[2] > 0
    assert np.linalg.det(frame.matrix) > 0


@given(st.sampled_from(sorted(UNITS)))
def test_unit_names_are_found_again(name) -> None:
    assert unit_name(UNITS[name]) == name


@pytest.mark.parametrize("suffix", BOXES)
def test_same_box_from_every_format(suffix: str) -> None:
    triangles = read(BOXES[suffix], suffix).pieces[0].triangles
    assert triangles.shape == (12, 3, 3)
    assert find_leaks(triangles).closed
    assert np.linalg.det(triangles).sum() / 6 == pytest.approx(24, rel=1e-5)


@settings(max_examples=150, deadline=None)
@given(st.sampled_from(sorted(BOXES)), st.data())
def test_damaged_files_are_refused_or_read_but_never_crash(suffix, data) -> None:
    whole = bytearray(BOXES[suffix])
    cut = data.draw(st.integers(0, len(whole)))
    for at in data.draw(st.lists(st.integers(0, len(whole) - 1), max_size=4)):
        whole[at] = data.draw(st.integers(0, 255))
    problems, pieces = (), ()
    try:
        pieces = read(bytes(whole[:cut]), suffix).pieces
    except BadInput as error:
        problems = error.problems
    assert bool(pieces) != bool(problems)
    assert all(problem.remedy and f"m{suffix}" in problem.found for problem in problems)
    assert all(np.isfinite(piece.triangles).all() for piece in pieces)


@pytest.mark.parametrize("suffix", [".glb", ".ply", ".stl"])
def test_binary_file_cut_anywhere_is_refused(suffix: str) -> None:
    whole = BOXES[suffix]
    for cut in range(0, len(whole) - 1, 37):
        with pytest.raises(BadInput):
            read(whole[:cut], suffix)


# --- nav-mesh files -------------------------------------------------------------------------------

NAVMESHES = {
    **{kind: tile_set(full_tile(kind), kind=kind) for kind in KINDS},
    "habitat": tile_set(full_tile("recast32"), version=2, settings_bytes=HABITAT),
    "aas 4": aas({**lumps(SQUARE), 9: reach(5, (0, 0, 0), (1, 1, 1))}, version=4),
    "aas 5": aas({**lumps(SQUARE), 9: reach(5, (0, 0, 0), (1, 1, 1))}),
    "godot": (godot_4() + "agent_height = 1.8\n").encode(),
    "godot scene": scene(NODES).encode(),
    "obj": (NAV_OBJ + "rd_agh 1.8\nrd_agr 0.4\n").encode(),
    "glb": glb(),
}
MOST_BYTES = 64 << 20  # for files of a few kB


def navmesh_or_refused(data: bytes, format_: str = "auto") -> bool:
    """Whether the file is read; all that may be raised is BadInput, and memory stays in proportion."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "nav"
        file.write_bytes(data)
        found, problems = None, ()
        tracemalloc.start()
        try:
            found = read_navmesh_file(file, format=format_)
        except BadInput as error:
            problems = error.problems
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
    assert peak < MOST_BYTES
    if found is None:
        assert problems
        assert all(problem.found and problem.remedy for problem in problems)
        return False
    assert np.isfinite(found.triangles).all()
    assert all(np.isfinite([*link.start, *link.end, link.radius_m]).all() for link in found.links)
    assert found.areas is None or len(found.areas) == len(found.faces)
    numbers = [number for number in vars(found.agent).values() if number is not None]
    assert all(0 <= number < np.inf for number in numbers)
    return True


@pytest.mark.parametrize("name", NAVMESHES)
def test_navmesh_cut_off_at_any_place_is_no_crash(name: str) -> None:
    whole = NAVMESHES[name]
    assert navmesh_or_refused(whole)
    cuts = range(0, len(whole), max(1, len(whole) // 150))
    read = [cut for cut in cuts if navmesh_or_refused(whole[:cut])]
    assert not read or name in ("obj", "godot", "godot scene")  # text may end at the end of a line


@settings(max_examples=300, deadline=None)
@given(st.sampled_from(sorted(NAVMESHES)), st.data())
def test_navmesh_with_flipped_bits_is_read_or_refused(name: str, data: st.DataObject) -> None:
    damaged = bytearray(NAVMESHES[name])
    for at in data.draw(st.lists(st.integers(0, len(damaged) - 1), min_size=1, max_size=4)):
        damaged[at] ^= 1 << data.draw(st.integers(0, 7))
    navmesh_or_refused(bytes(damaged))


@settings(max_examples=200, deadline=None)
@given(st.sampled_from(sorted(NAVMESHES)), st.data())
def test_navmesh_with_nan_or_huge_numbers_is_read_or_refused(name: str, data: st.DataObject) -> None:
    damaged = bytearray(NAVMESHES[name])
    at = 4 * data.draw(st.integers(0, len(damaged) // 4 - 1))
    number = (
        b"\0\0\xc0\x7f",
        b"\0\0\x80\x7f",
        b"\xff\xff\xff\x7f",
        b"\xff\xff\xff\xff",
        b"\0\0\0\x80",
        b" nan",
    )
    damaged[at : at + 4] = data.draw(st.sampled_from(number))
    navmesh_or_refused(bytes(damaged))


@pytest.mark.parametrize("format_", NAVMESH_FORMATS)
@pytest.mark.parametrize("name", NAVMESHES)
def test_navmesh_read_as_another_format_is_refused(name: str, format_: str) -> None:
    own = next(iter(f for f in ("aas", "godot", "obj", "glb") if name.startswith(f)), "detour")
    assert navmesh_or_refused(NAVMESHES[name], format_) == (format_ == own)
