"""Area files of Quake III: files written byte by byte, a real map's ground, and damaged files."""

from __future__ import annotations

import struct
import tracemalloc
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from reachtest.levels import load_level
from reachtest.levels.meshes.scene import Piece, Unreadable
from reachtest.levels.navmeshes.aas import read_aas
from tests.unit.levels.make import WriteLevel, only_problem

SHARED = Path(__file__).parents[4] / "shared" / "levels"
SQUARE = ((-9, -9, 0), (9, -9, 0), (9, 9, 0), (-9, 9, 0))
RAISED = tuple((x, y, z + 2) for x, y, z in SQUARE)
GROUND, SOLID, GROUNDED = 4, 1, 1
VERTEXES, EDGES, EDGE_INDEX, FACES, FACE_INDEX, AREAS, SETTINGS = 1, 3, 4, 5, 6, 7, 8

Polygon = tuple[tuple[float, ...], ...]


def lumps(*polygons: Polygon, flags: int = GROUND | SOLID, area_flags: int = GROUNDED) -> dict[int, bytes]:
    """One area for every polygon, which is its only face; item 0 of everything is a dummy."""
    vertexes: list[tuple[float, ...]] = [(0.0, 0.0, 0.0)]
    edges, edge_index = [(0, 0)], [0]
    faces, areas = [(0,) * 6], [struct.pack("<3i9f", 0, 0, 0, *[0] * 9)]
    for number, polygon in enumerate(polygons, start=1):
        base = len(vertexes)
        faces.append((0, flags, len(polygon), len(edge_index), number, 0))
        for side in range(len(polygon)):
            start, end = base + side, base + (side + 1) % len(polygon)
            backwards = side % 2  # as two faces that share an edge have it
            edge_index.append(-len(edges) if backwards else len(edges))
            edges.append((end, start) if backwards else (start, end))
        vertexes += list(polygon)
        areas.append(struct.pack("<3i9f", number, 1, number - 1, *[0] * 9))
    settings_ = [struct.pack("<7i", 0, each, 2, 1, 0, 0, 0) for each in [0] + [area_flags] * len(polygons)]
    signs = [-number if number % 2 else number for number in range(1, len(polygons) + 1)]
    return {
        VERTEXES: b"".join(struct.pack("<3f", *each) for each in vertexes),
        EDGES: b"".join(struct.pack("<2i", *each) for each in edges),
        EDGE_INDEX: struct.pack(f"<{len(edge_index)}i", *edge_index),
        FACES: b"".join(struct.pack("<6i", *each) for each in faces),
        FACE_INDEX: struct.pack(f"<{len(signs)}i", *signs),
        AREAS: b"".join(areas),
        SETTINGS: b"".join(settings_),
    }


def aas(parts: dict[int, bytes], version: int = 5) -> bytes:
    """The header, which version 5 scrambles from byte 8 on, and the lumps."""
    head, body = struct.pack("<i", 12345), b""
    for number in range(14):
        head += struct.pack("<2i", 124 + len(body), len(parts.get(number, b"")))
        body += parts.get(number, b"")
    return struct.pack("<4si", b"EAAS", version) + (scrambled(head) if version == 5 else head) + body


def reach(kind: int, start: Any, end: Any) -> bytes:
    """One record of the reachability lump."""
    return struct.pack("<3i6fiHH", 2, 0, 0, *start, *end, kind, 10, 0)


def scrambled(head: bytes) -> bytes:
    return bytes(byte ^ (i * 119 & 0xFF) for i, byte in enumerate(head))


def patched(lump: int, at: int, fmt: str, *values: Any) -> bytes:
    """A file with two ground faces, one lump overwritten from byte `at` on."""
    parts = lumps(SQUARE, RAISED)
    changed = bytearray(parts[lump])
    struct.pack_into(fmt, changed, at, *values)
    return aas({**parts, lump: bytes(changed)}, version=4)


def start_of(lump: int) -> int:
    parts = lumps(SQUARE, RAISED)
    return 124 + sum(len(parts[number]) for number in range(lump) if number in parts)


def read(data: bytes) -> Piece:
    (piece,) = read_aas(data, Path("q3dm1.aas")).pieces
    return piece


def areas_and_rise(piece: Piece) -> tuple[float, float]:
    """Area in all, and the share of it that faces up."""
    a, b, c = piece.triangles.transpose(1, 0, 2)
    normals = np.cross(b - a, c - a) / 2
    sizes = np.linalg.norm(normals, axis=1)
    return float(sizes.sum()), float(sizes[normals[:, 2] > 0].sum() / sizes.sum())


@pytest.mark.parametrize("version", [4, 5])
@pytest.mark.parametrize("turned", [False, True])
def test_ground_faces_are_the_surface_and_face_up(version: int, turned: bool) -> None:
    piece = read(aas(lumps(SQUARE[::-1] if turned else SQUARE, RAISED), version))
    assert piece.name == "q3dm1"
    assert areas_and_rise(piece) == pytest.approx((2 * 18 * 18, 1.0))
    assert set(map(tuple, piece.vertices.tolist())) == {*SQUARE, *RAISED}


@pytest.mark.parametrize("kept", [{"flags": SOLID}, {"area_flags": 4}])
def test_walls_and_water_are_no_surface(kept: dict[str, int]) -> None:
    with pytest.raises(Unreadable, match=r"none of its 2 faces \(lump at byte 52\)") as raised:
        read(aas(lumps(SQUARE, **kept)))
    assert "-optimize" in raised.value.remedy


def test_face_of_two_areas_is_there_once() -> None:
    parts = lumps(SQUARE, RAISED)
    piece = read(aas({**parts, FACE_INDEX: struct.pack("<2i", 1, -1)}))
    assert areas_and_rise(piece)[0] == pytest.approx(18 * 18)


@pytest.mark.parametrize("units", [0.5, "in"])
def test_level_takes_it_as_z_up_in_its_own_units(write_level: WriteLevel, units: float | str) -> None:
    path = write_level(navmesh={"mesh": "nav.aas", "units": units})
    path.with_name("nav.aas").write_bytes(aas(lumps(RAISED)))
    high = load_level(path).navmesh.vertices.max(axis=0)
    np.testing.assert_allclose(high, np.array([9, 9, 2]) * (0.0254 if units == "in" else 0.5))


@pytest.mark.parametrize(
    ("lump", "at", "value", "found"),
    [
        (VERTEXES, 12, ("<f", float("nan")), "vertexes[1] at byte {} that is NaN"),
        (VERTEXES, 24, ("<f", float("inf")), "vertexes[2] at byte {} that is NaN"),
        (VERTEXES, 24, ("<f", 1e9), "vertexes[2] at byte {} that is NaN, infinite or too far away"),
        (EDGES, 8, ("<i", 9), "edges[1] at byte {} with an end outside of the 9 vertexes"),
        (EDGES, 8, ("<i", -1), "edges[1] at byte {} with an end outside"),
        (EDGE_INDEX, 4, ("<i", 9), "edge index[1] at byte {} outside of the 9 edges"),
        (EDGE_INDEX, 4, ("<i", -(2**31)), "edge index[1] at byte {} outside of the 9 edges"),
        (EDGE_INDEX, 4, ("<i", 4), "faces[1] at byte {} whose edges are no closed loop"),
        (FACES, 24 + 8, ("<i", 2), "faces[1] at byte {} with fewer than 3 edges"),
        (FACES, 24 + 8, ("<i", 2**31 - 1), "faces[1] at byte {} beyond the 9 of the edge index"),
        (FACES, 24 + 8, ("<2i", 8, 1), "faces[2] at byte {} with more than the 9 of the edge index in all"),
        (FACE_INDEX, 0, ("<i", 3), "face index[0] at byte {} outside of the 3 faces"),
        (AREAS, 48 + 4, ("<i", -1), "areas[1] at byte {} beyond the 2 of the face index"),
        (AREAS, 48 + 8, ("<i", 2), "areas[1] at byte {} beyond the 2 of the face index"),
    ],
)
def test_numbers_out_of_range_are_named(lump: int, at: int, value: tuple[Any, ...], found: str) -> None:
    sizes = {VERTEXES: 12, EDGES: 8, EDGE_INDEX: 4, FACES: 24, FACE_INDEX: 4, AREAS: 48}
    named = FACES if found.startswith("faces") else lump
    row = int(found.partition("[")[2].partition("]")[0])
    with pytest.raises(Unreadable) as raised:
        read(patched(lump, at, *value))
    assert found.format(start_of(named) + row * sizes[named]) in raised.value.found


@pytest.mark.parametrize(
    ("data", "found"),
    [
        (b"", "starts with b''"),
        (b"IBSP" + bytes(200), "starts with b'IBSP', which is no area file"),
        (aas(lumps(SQUARE))[:100], "ends at byte 100, within its header of 124 bytes"),
        (aas(lumps(SQUARE), version=8), "has version 8 at byte 4"),
        (aas(lumps(SQUARE))[:-1], "states lump 8 of 56 bytes from byte"),
        (aas({**lumps(SQUARE), EDGES: bytes(15)}), "has 15 bytes of edges at byte 184, no multiple of 8"),
        (aas({**lumps(SQUARE), SETTINGS: bytes(28)}), "has 2 areas but 1 area settings"),
        (aas({}), "holds no triangles"),
    ],
)
def test_files_that_are_cut_off_or_something_else(data: bytes, found: str) -> None:
    with pytest.raises(Unreadable) as raised:
        read(data)
    assert found in raised.value.found


@pytest.mark.parametrize("place", [(2**31 - 1, 12), (124, 2**31 - 1), (-4, 12), (124, -12)])
def test_lumps_outside_of_the_file_cost_no_memory(place: tuple[int, int]) -> None:
    data = bytearray(aas(lumps(SQUARE), version=4))
    struct.pack_into("<2i", data, 12 + 8 * VERTEXES, *place)
    tracemalloc.start()
    with pytest.raises(Unreadable, match=r"states lump 1 of .* at byte 20, where the file has"):
        read(bytes(data))
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 1e6


def test_problem_of_a_level_names_the_file(write_level: WriteLevel) -> None:
    path = write_level(navmesh={"mesh": "nav.aas"})
    path.with_name("nav.aas").write_bytes(aas(lumps(SQUARE), version=7))
    where, found, _ = only_problem(path)
    assert (where, found) == ("level.yaml: navmesh.mesh", "nav.aas has version 7 at byte 4")


@pytest.mark.skipif(not SHARED.exists(), reason="no real levels beside the project")
def test_ground_of_a_real_map() -> None:
    import trimesh

    mesh = trimesh.load_mesh(SHARED / "oa_dm1" / "oa_dm1.aas_ground.glb", process=False)
    triangles = (mesh.triangles @ np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]])) * 32  # as the game has it
    piece = read(aas(lumps(*(tuple(map(tuple, each)) for each in triangles.tolist()))))
    size, up = areas_and_rise(piece)
    assert size == pytest.approx(mesh.area * 32**2, rel=1e-4)
    assert len(piece.faces) == len(mesh.faces) > 500
    assert up == pytest.approx(1.0)


@settings(max_examples=200, deadline=None)
@given(st.data())
def test_damage_is_refused_or_gives_a_sound_mesh(data: st.DataObject) -> None:
    raw = bytearray(aas(lumps(SQUARE, RAISED), version=data.draw(st.sampled_from([4, 5]))))
    at = data.draw(st.integers(0, len(raw) - 1))
    cut = data.draw(st.booleans())
    if cut:
        del raw[at:]
    else:
        raw[at] ^= data.draw(st.integers(1, 255))
    said, pieces = "", []
    try:
        pieces = read_aas(bytes(raw), Path("a.aas")).pieces
    except Unreadable as error:
        said = error.found
    assert bool(pieces) or "byte" in said
    assert not (cut and pieces)
    for piece in pieces:
        assert 0 <= piece.faces.min() <= piece.faces.max() < len(piece.vertices)
        assert np.isfinite(piece.vertices).all()
        assert len(piece.faces) <= 4
