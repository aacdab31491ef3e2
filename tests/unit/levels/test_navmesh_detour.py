"""Detour nav-meshes: files written byte by byte, files that Recast wrote, and damaged ones."""

from __future__ import annotations

import json
import struct
import tracemalloc
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from reachtest.errors import BadInput
from reachtest.levels import check_level, load_level
from reachtest.levels.keys.geometry import FrameSpec
from reachtest.levels.keys.navmesh import NavMeshSpec
from reachtest.levels.meshes.read import Mesh
from reachtest.levels.meshes.scene import Unreadable
from reachtest.levels.navmeshes.detour import DetourMesh, detour_mesh, read_detour
from reachtest.levels.navmeshes.read import read_navmesh
from tests.unit.levels.make import WriteLevel, only_problem

SHARED = Path(__file__).parents[4] / "shared" / "levels"
KINDS = ("recast32", "recast64", "unreal", "unreal snap")
SQUARE = ((0, 0, 0), (0, 0, -4), (4, 0, -4), (4, 0, 0))  # y up, counter-clockwise or not is all one here


def pad(data: bytes) -> bytes:
    return data + bytes(-len(data) % 4)


@dataclass(frozen=True)
class Poly:
    """What a tile writer is told of one polygon."""

    corners: tuple[int, ...]
    flags: int = 1
    area: int = 0
    kind: int = 0
    detail: tuple[tuple[int, int, int], ...] = ()
    detail_verts: tuple[tuple[float, float, float], ...] = ()


@dataclass(frozen=True)
class Link:
    """What a tile writer is told of one off-mesh connection."""

    start: tuple[float, float, float]
    end: tuple[float, float, float]
    poly: int


def tile(
    verts: Any = SQUARE,
    polys: tuple[Poly, ...] = (Poly((0, 1, 2, 3)),),
    links: tuple[Link, ...] = (),
    kind: str = "recast32",
    details: bool = True,
    runtime_links: int = 3,
    segments: int = 0,
) -> bytes:
    """One tile, section by section; `details` False leaves the detail meshes out."""
    unreal = kind.startswith("unreal")
    ground = [poly for poly in polys if poly.kind == 0] if details else []
    detail_verts = [vertex for poly in ground for vertex in poly.detail_verts]
    detail_tris = [tri for poly in ground for tri in poly.detail]
    counts = [len(polys), len(verts), runtime_links, len(ground), len(detail_verts), len(detail_tris), 2]
    head = struct.pack("<4s5i", b"VAND", 7, 0, 0, 0, 0) + struct.pack("<8i", *counts, len(links))
    head += struct.pack("<4i", segments, len(polys), 0, 0) if unreal else struct.pack("<i", len(polys))
    head += struct.pack("<3f", 1.8, 0.34, 0.45) + struct.pack("<6f", 0, 0, -4, 4, 1, 0) + struct.pack("<f", 5)
    head += struct.pack("<i", 1) if unreal else b""
    assert len(head) == (116 if unreal else 100)
    body = [b"".join(struct.pack("<3f", *vertex) for vertex in verts)]
    body.append(b"".join(map(poly_bytes, polys)))
    body.append(bytes((12 if kind == "recast32" else 16) * runtime_links))
    meshes, vert_base, tri_base = b"", 0, 0
    for poly in ground:
        n_verts, n_tris = len(poly.detail_verts), len(poly.detail)
        meshes += struct.pack("<IIBB2x", vert_base, tri_base, n_verts, n_tris)
        vert_base, tri_base = vert_base + n_verts, tri_base + n_tris
    body += [meshes, b"".join(struct.pack("<3f", *vertex) for vertex in detail_verts)]
    body += [b"".join(struct.pack("<4B", *tri, 0) for tri in detail_tris), bytes(16 * 2)]
    body.append(b"".join(link_bytes(link, kind) for link in links))
    if unreal:
        body += [bytes((64 if "snap" in kind else 60) * segments), bytes(20), bytes(2 * len(polys))]
    return head + b"".join(map(pad, body))


def poly_bytes(poly: Poly) -> bytes:
    spare = (0xFFFF,) * (6 - len(poly.corners))  # slots that are not used hold anything
    area_and_kind = poly.area | poly.kind << 6
    return struct.pack(
        "<I6H6HHBB", 0, *poly.corners, *spare, *[0] * 6, poly.flags, len(poly.corners), area_and_kind
    )


def link_bytes(link: Link, kind: str) -> bytes:
    height = struct.pack("<f", -1) if "snap" in kind else b""
    return (
        struct.pack("<7f", *link.start, *link.end, 0.5) + height + struct.pack("<HBBI", link.poly, 1, 2, 77)
    )


def tile_set(*tiles: bytes, kind: str = "recast32", version: int = 1, settings_bytes: bytes = b"") -> bytes:
    """A set of tiles, which its kind writes with references of 32 or 64 bits."""
    params = struct.pack("<5f2i", 0, 0, 0, 10, 10, len(tiles), 64)
    entry = "<Ii" if kind == "recast32" else "<QiI"
    end = () if kind == "recast32" else (0xCDCDCDCD,)
    body = b"".join(struct.pack(entry, 7 + i, len(data), *end) + data for i, data in enumerate(tiles))
    return struct.pack("<4sii", b"TESM", version, len(tiles)) + params + settings_bytes + body


HABITAT = struct.pack("<13f4?", *[0.05] * 5, 45.0, *[0.05] * 7, True, True, True, False)
PEAK = Poly(  # a roof of four triangles over the square, its tip a detail vertex
    (0, 1, 2, 3),
    flags=5,
    area=9,
    detail=((0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)),
    detail_verts=((2, 3, -2),),
)
FAR = tuple((x + 10, y, z) for x, y, z in SQUARE)
LADDER = Link((1, 0, -1), (1, 5, -1), 1)
LADDER_POLY = Poly((4, 5), flags=8, area=3, kind=1)


def full_tile(kind: str) -> bytes:
    """A roof with a detail mesh, and a ladder."""
    verts = (*SQUARE, LADDER.start, LADDER.end)
    return tile(verts, (PEAK, LADDER_POLY), (LADDER,), kind=kind)


def area(vertices: Any, faces: Any) -> float:
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2)


def surface_area(mesh: DetourMesh) -> float:
    return area(mesh.surface.vertices, mesh.surface.faces)


@pytest.mark.parametrize("kind", KINDS)
def test_detail_mesh_areas_flags_and_links_of_every_layout(kind: str) -> None:
    mesh = detour_mesh(tile_set(full_tile(kind), full_tile(kind), kind=kind))
    assert mesh.tiles == 2
    assert mesh.layout.startswith("Unreal" if "unreal" in kind else "Recast")
    assert ("64" in mesh.layout) == (kind == "recast64")
    surface = mesh.surface
    assert surface_area(mesh) == pytest.approx(2 * 4 * 4 * np.hypot(2, 3) / 2)
    assert surface.faces.shape == (8, 3)
    assert surface.polygon.tolist() == [0] * 4 + [1] * 4
    assert surface.area.tolist() == [9, 9]  # the ladder is no ground
    assert surface.flags.tolist() == [5, 5]
    links = surface.off_mesh
    turn = -1 if "unreal" in kind else 1
    np.testing.assert_array_equal(links.ends[1], [[turn, 0, -turn], [turn, 5, -turn]])
    assert (links.radius.tolist(), links.both_ways.tolist()) == ([0.5] * 2, [True] * 2)
    assert (links.area.tolist(), links.flags.tolist(), links.user_id.tolist()) == ([3] * 2, [8] * 2, [77] * 2)
    sizes = (mesh.agent_height, mesh.agent_radius, mesh.agent_climb)
    assert sizes == pytest.approx((1.8, 0.34, 0.45))


@pytest.mark.parametrize("kind", KINDS)
def test_tile_without_links_does_not_decide_the_layout(kind: str) -> None:
    plain = tile(kind=kind, runtime_links=0)
    mesh = detour_mesh(tile_set(plain, full_tile(kind), kind=kind))
    assert len(mesh.surface.off_mesh.ends) == 1
    assert mesh.layout.endswith("snap heights") == (kind == "unreal snap")


@pytest.mark.parametrize("details", [True, False])
@pytest.mark.parametrize("sides", [3, 4, 5, 6])
def test_polygon_without_detail_is_a_fan(sides: int, details: bool) -> None:
    angles = np.arange(sides) * 2 * np.pi / sides
    ring = [(np.cos(angle), 0.5, np.sin(angle)) for angle in angles]
    verts = [*SQUARE, *ring]
    polys = (Poly((0, 1, 2)), Poly(tuple(range(4, 4 + sides))))
    mesh = detour_mesh(tile_set(tile(verts, polys, details=details)))
    assert surface_area(mesh) == pytest.approx(8 + sides * np.sin(2 * np.pi / sides) / 2, rel=1e-6)
    assert mesh.surface.polygon.tolist() == [0] + [1] * (sides - 2)


def test_detail_and_fan_side_by_side_keep_their_polygons() -> None:
    verts = (*FAR, *SQUARE)
    roof = Poly((4, 5, 6, 7), detail=PEAK.detail, detail_verts=PEAK.detail_verts, area=2)
    mesh = detour_mesh(tile_set(tile(verts, (Poly((0, 1, 2, 3), area=1), roof))))
    surface = mesh.surface
    assert surface.polygon.tolist() == [0, 0, 1, 1, 1, 1]
    corners = surface.vertices[surface.faces]
    assert (corners[:2, :, 0] >= 10).all()
    assert (corners[2:, :, 0] <= 4).all()


def test_unreal_lies_where_unreals_own_exporters_put_the_geometry() -> None:
    place = np.array([300.0, -200.0, 50.0])  # in Unreal's axes, z up, left-handed
    recast = [(-(place[0] + x), place[2] + y, -(place[1] + z)) for x, y, z in SQUARE]
    mesh = detour_mesh(tile_set(tile(recast, kind="unreal"), kind="unreal"))
    expected = [(place[0] + x, place[2] + y, place[1] + z) for x, y, z in SQUARE]  # glTF: (X, Z, Y)
    assert {tuple(v) for v in mesh.surface.vertices.tolist()} == set(expected)


@pytest.mark.parametrize("segments", [0, 2])
@pytest.mark.parametrize("kind", ["unreal", "unreal snap"])
def test_unreal_segment_links_are_passed_over(kind: str, segments: int) -> None:
    mesh = detour_mesh(tile_set(tile(kind=kind, segments=segments), kind=kind))
    assert surface_area(mesh) == 16


@pytest.mark.parametrize("kind", KINDS)
def test_habitat(kind: str) -> None:
    """Version 1 is Recast's own; version 2 puts its build settings before the tiles."""
    plain = detour_mesh(tile_set(full_tile(kind), kind=kind))
    for version, between in ((1, b""), (2, HABITAT), (2, b"")):
        mesh = detour_mesh(tile_set(full_tile(kind), kind=kind, version=version, settings_bytes=between))
        assert surface_area(mesh) == surface_area(plain)
        assert mesh.layout == (f"Habitat 2 ({plain.layout})" if between else plain.layout)
        assert mesh.agent_slope == (pytest.approx(45.0) if between else None)


@pytest.mark.parametrize("kind", ["recast32", "recast64", "unreal"])
def test_bare_tile(kind: str) -> None:
    assert surface_area(detour_mesh(tile(kind=kind))) == 16


def test_zero_reference_ends_the_list() -> None:
    data = tile_set(tile())
    longer = data[:8] + struct.pack("<i", 2) + data[12:]
    assert detour_mesh(longer + bytes(8)).tiles == 1
    with pytest.raises(Unreadable, match="after 1 of the 2 tiles"):
        detour_mesh(longer)
    with pytest.raises(Unreadable, match=f"after its last tile, from byte {len(data) + 8}"):
        detour_mesh(longer + bytes(8) + b"rest")


@pytest.mark.parametrize("suffix", [".bin", ".navmesh", ".BIN"])
@pytest.mark.parametrize("kind", ["recast32", "unreal"])
def test_level_takes_any_of_them_by_content_in_its_axes_and_units(
    write_level: WriteLevel, suffix: str, kind: str
) -> None:
    wide = np.array([(-900, 0, -900), (-900, 0, 900), (900, 0, 900), (900, 0, -900)])
    path = write_level(navmesh={"mesh": f"nav{suffix}", "units": "cm"})
    (path.parent / f"nav{suffix}").write_bytes(tile_set(tile(wide, kind=kind), kind=kind))
    level = load_level(path)
    assert len(level.navmesh.faces) == 2
    low, high = level.navmesh.vertices.min(axis=0), level.navmesh.vertices.max(axis=0)
    np.testing.assert_allclose([low, high], [[-9, -9, 0], [9, 9, 0]], atol=1e-6)
    normals = np.cross(*(np.diff(level.navmesh.triangles, axis=1).transpose(1, 0, 2)))
    assert (normals[:, 2] > 0).all()


def test_declared_up_axis_wins(write_level: WriteLevel) -> None:
    flat = [(-9, -9, 0), (9, -9, 0), (9, 9, 0), (-9, 9, 0)]
    path = write_level(navmesh={"mesh": "nav.bin", "up_axis": "z"})
    (path.parent / "nav.bin").write_bytes(tile_set(tile(flat)))
    assert (load_level(path).navmesh.vertices[:, 2] == 0).all()


def test_problem_names_key_file_and_byte(write_level: WriteLevel) -> None:
    path = write_level(navmesh={"mesh": "nav.bin"})
    (path.parent / "nav.bin").write_bytes(tile_set(tile())[:-1])
    where, found, remedy = only_problem(path)
    assert where == "level.yaml: navmesh.mesh"
    assert found.startswith("nav.bin has a tile of")
    assert "at byte 48" in found
    assert "export it again" in remedy


NAN, FAR_AWAY = struct.pack("<f", np.nan), struct.pack("<f", 1e30)
VERTS, POLYS = 48 + 100, 48 + 100 + 6 * 12  # of a set of one full tile with 32-bit references
DETAILS = POLYS + 2 * 32 + 3 * 12
TRIS = DETAILS + 12 + 12
OFF_MESH = TRIS + 4 * 4 + 2 * 16
WRONG = {  # what is put where, and the message
    "magic": (0, b"JUNK", "byte 0"),
    "set version": (4, b"\x09", "version 9 at byte 4"),
    "no tiles": (8, b"\0", "0 tiles at byte 8"),
    "negative tiles": (8, b"\xff" * 4, "-1 tiles at byte 8"),
    "too many tiles": (8, b"\xff\xff\xff\x7f", "after 1 of the 2147483647 tiles"),
    "size": (44, b"\xff\xff\xff\x7f", "tile of 2147483647 bytes at byte 48"),
    "negative size": (44, b"\xff" * 4, "tile of -1 bytes at byte 48"),
    "tile magic": (48, b"JUNK", "no tile"),
    "tile version": (52, b"\x08", "version 8 at byte 52"),
    "negative count": (48 + 24, b"\xff" * 4, "-1 polys at byte 72"),
    "huge count": (48 + 28, b"\xff\xff\xff\x7f", "add up to"),
    "agent": (48 + 60, NAN, "byte 108"),
    "vertex NaN": (VERTS + 12, NAN, f"verts[1] at byte {VERTS + 12}"),
    "vertex far": (VERTS + 24, FAR_AWAY, f"verts[2] at byte {VERTS + 24}"),
    "corner": (POLYS + 4, b"\x06", f"polys[0] at byte {POLYS}"),
    "corners": (POLYS + 30, b"\x07", f"polys[0] at byte {POLYS}"),
    "two corners": (POLYS + 30, b"\x02", f"polys[0] at byte {POLYS}"),
    "kind": (POLYS + 32 + 31, b"\xc0", f"polys[1] at byte {POLYS + 32}"),
    "detail vertices": (DETAILS + 8, b"\x02", f"detail_meshes[0] at byte {DETAILS}"),
    "detail triangles": (DETAILS + 9, b"\x05", f"detail_meshes[0] at byte {DETAILS}"),
    "detail base": (DETAILS + 4, b"\xff" * 4, f"detail_meshes[0] at byte {DETAILS}"),
    "detail vertex": (DETAILS + 12, NAN, f"detail_verts[0] at byte {DETAILS + 12}"),
    "detail corner": (TRIS + 4 + 2, b"\x05", f"detail_tris[1] at byte {TRIS + 4}"),
    "link NaN": (OFF_MESH + 12, NAN, f"off_mesh[0] at byte {OFF_MESH}"),
    "link radius": (OFF_MESH + 24, NAN, f"off_mesh[0] at byte {OFF_MESH}"),
    "link polygon": (OFF_MESH + 28, b"\x02", f"off_mesh[0] at byte {OFF_MESH}"),
}


@pytest.mark.parametrize("name", WRONG)
def test_wrong_number_is_named_by_its_byte(name: str) -> None:
    at, wrong, words = WRONG[name]
    good = tile_set(full_tile("recast32"))
    with pytest.raises(Unreadable) as raised:
        detour_mesh(good[:at] + wrong + good[at + len(wrong) :])
    assert words in raised.value.found
    assert "byte" in raised.value.found
    assert raised.value.remedy


@pytest.mark.parametrize(("magic", "words"), [(b"MSET", "big-endian"), (b"TEST", "tile cache")])
def test_kindred_files_are_named(magic: bytes, words: str) -> None:
    with pytest.raises(Unreadable, match=words):
        detour_mesh(magic + bytes(200))


@pytest.mark.parametrize("polys", [(), (Poly((0, 1), kind=1),)], ids=["no polygons", "a link alone"])
def test_no_ground_is_no_mesh(polys: tuple[Poly, ...]) -> None:
    with pytest.raises(Unreadable, match="no triangles in 1 tiles, the first at byte 48"):
        detour_mesh(tile_set(tile(polys=polys)))


def test_shared_triangles_and_huge_counts_take_no_memory() -> None:
    """Half a megabyte that claims 4 million triangles, and a header that claims 2 thousand million tiles."""
    corners = Poly((0, 1, 2, 3), detail=((0, 1, 2),) * 255)
    data = bytearray(tile(polys=(corners, *[Poly((0, 1, 2, 3))] * 16_000), runtime_links=0))
    details = 100 + 4 * 12 + 16_001 * 32
    for poly in range(16_001):
        data[details + 12 * poly : details + 12 * (poly + 1)] = struct.pack("<IIBB2x", 0, 0, 0, 255)
    tracemalloc.start()
    with pytest.raises(Unreadable, match="more than the 255 detail triangles"):
        detour_mesh(bytes(data))
    with pytest.raises(Unreadable):
        detour_mesh(struct.pack("<4sii", b"TESM", 1, 2**31 - 1) + tile_set(tile())[12:])
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 30e6


# --- files that Recast wrote ----------------------------------------------------------------------


def obj_or_glb(path: Path) -> tuple[Any, Any]:
    """Vertices and faces, by a reader that has nothing to do with ours."""
    import trimesh

    mesh = trimesh.load(path, force="mesh", process=False)
    return np.asarray(mesh.vertices), np.asarray(mesh.faces)


def shared(folder: str, name: str) -> Path:
    path = SHARED / folder / name
    if not path.is_file():
        pytest.skip(f"{path.name} is not next to the project (../shared/levels)")
    return path


@pytest.mark.parametrize(
    ("folder", "other", "polygons", "triangles"),
    [
        ("nav_test", "nav_test.solo.navmesh.obj", 307, 1950),
        ("nav_test", "nav_test.solo.navmesh.glb", 307, 1950),
        ("dungeon", "dungeon.solo.navmesh.glb", 290, 1418),
    ],
)
def test_recasts_own_file_is_the_mesh_that_it_exports(
    folder: str, other: str, polygons: int, triangles: int
) -> None:
    mesh = detour_mesh(shared(folder, f"{folder}.solo.navmesh.bin").read_bytes())
    surface = mesh.surface
    vertices, faces = obj_or_glb(shared(folder, other))
    assert len(surface.area) == len(np.unique(surface.polygon)) == polygons
    assert len(surface.faces) == len(faces) == triangles
    assert surface_area(mesh) == pytest.approx(area(vertices, faces), rel=1e-6)
    ours, theirs = (np.sort(v[f].mean(axis=1).round(3), axis=0) for v, f in
                    ((surface.vertices, surface.faces), (vertices, faces)))  # fmt: skip
    np.testing.assert_allclose(ours, theirs, atol=2e-3)
    assert (mesh.agent_height, mesh.agent_radius) == pytest.approx((1.8, 0.34))


@pytest.mark.parametrize("folder", ["nav_test", "dungeon"])
def test_polygons_without_their_detail_cover_the_same_ground(folder: str) -> None:
    """Seen from above, the fans of the polygons and the detail meshes are the same area."""
    data = shared(folder, f"{folder}.solo.navmesh.bin").read_bytes()
    polys, verts, links, details, detail_verts, detail_tris = struct.unpack_from("<6i", data, 48 + 24)
    start = 48 + 100 + 12 * verts + 32 * polys + 12 * links
    size = 12 * details + 12 * detail_verts + 4 * detail_tris
    bare = bytearray(data[:start] + data[start + size :])
    struct.pack_into("<3i", bare, 48 + 36, 0, 0, 0)
    struct.pack_into("<i", bare, 44, len(data) - 48 - size)
    from_above = [
        area(surface.vertices * [1, 0, 1], surface.faces)
        for surface in (detour_mesh(data).surface, detour_mesh(bytes(bare)).surface)
    ]
    assert from_above[0] == pytest.approx(from_above[1], rel=1e-3)


@pytest.mark.parametrize("other", ["obj", "glb"])
def test_level_reads_the_same_navmesh_from_both_formats(tmp_path: Path, other: str) -> None:
    spec = {"up_axis": "y", "units": "m"}
    meshes = []
    for suffix in ("bin", other):
        path = shared("nav_test", f"nav_test.solo.navmesh.{suffix}")
        meshes.append(read(path, **spec))
    low, high = ([op(m) for m in meshes] for op in (lowest, highest))
    np.testing.assert_allclose(low[0], low[1], atol=1e-4)
    np.testing.assert_allclose(high[0], high[1], atol=1e-4)


@pytest.mark.parametrize("folder", ["nav_test", "dungeon"])
def test_real_level_with_its_tile_set_is_plausible(tmp_path: Path, folder: str) -> None:
    navmesh = shared(folder, f"{folder}.solo.navmesh.bin")
    spawn = json.loads(shared(folder, "jolt_reach.walk.json").read_text())["spawn"]
    document = {
        "version": 1,
        "frame": {"up_axis": "y"},
        "geometry": [{"mesh": str(shared(folder, f"{folder}.obj"))}],
        "navmesh": {"mesh": str(navmesh)},
        "character": "unreal",
        "spawns": [spawn],
    }
    (tmp_path / "level.yaml").write_text(json.dumps(document))
    check = check_level(load_level(tmp_path / "level.yaml"))
    assert check.warnings == ()
    assert float(dict(check.facts)["nav-mesh with a floor within 1 m"].rstrip("%")) >= 99


def lowest(mesh: Mesh) -> Any:
    return np.concatenate([piece.vertices for piece in mesh.pieces]).min(axis=0)


def highest(mesh: Mesh) -> Any:
    return np.concatenate([piece.vertices for piece in mesh.pieces]).max(axis=0)


def read(path: Path, **keys: Any) -> Mesh:
    spec = NavMeshSpec.model_validate({"mesh": path.name, **keys})
    return read_navmesh(spec, path.parent, FrameSpec.model_validate({}), "level.yaml: navmesh").mesh


# --- damaged files --------------------------------------------------------------------------------

WHOLE = {
    **{kind: tile_set(full_tile(kind), tile(FAR, kind=kind), kind=kind) for kind in KINDS},
    "habitat": tile_set(full_tile("recast32"), version=2, settings_bytes=HABITAT),
    "bare": full_tile("recast32"),  # in 64 bits, cut by 4 bytes a link, it is a tile of 32 bits
}


def whole_or_refused(data: bytes) -> bool:
    """Whether the file is read; anything but a mesh that holds together or Unreadable is a failure."""
    problem, pieces = "", []
    try:
        pieces = read_detour(data, Path("nav.bin")).pieces
    except Unreadable as error:
        problem = error.found
    if problem:
        assert "byte" in problem
        return False
    (piece,), surface = pieces, detour_mesh(data).surface
    assert len(piece.faces) > 0
    assert np.isfinite(piece.vertices).all()
    assert piece.faces.min() >= 0
    assert piece.faces.max() < len(piece.vertices)
    assert len(surface.polygon) == len(surface.faces)
    assert surface.polygon.max() < len(surface.area) == len(surface.flags)
    return True


@pytest.mark.parametrize("kind", WHOLE)
def test_file_cut_anywhere_is_refused(kind: str) -> None:
    assert whole_or_refused(WHOLE[kind])
    assert not any(whole_or_refused(WHOLE[kind][:cut]) for cut in range(len(WHOLE[kind])))


@pytest.mark.filterwarnings("error")
@settings(max_examples=400, deadline=None)
@given(st.sampled_from(sorted(WHOLE)), st.data())
def test_damaged_file_is_refused_or_a_mesh(kind: str, data: st.DataObject) -> None:
    damaged = bytearray(WHOLE[kind])
    for at in data.draw(st.lists(st.integers(0, len(damaged) - 1), min_size=1, max_size=3)):
        damaged[at] = data.draw(st.integers(0, 255))
    cut = data.draw(st.one_of(st.just(len(damaged)), st.integers(0, len(damaged))))
    whole_or_refused(bytes(damaged[:cut]))


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("kind", WHOLE)
def test_any_one_byte_may_be_wrong(kind: str) -> None:
    refused = 0
    for at in range(len(WHOLE[kind])):
        for bits in (0xFF, 0x01):
            damaged = bytearray(WHOLE[kind])
            damaged[at] ^= bits
            refused += not whole_or_refused(bytes(damaged))
    assert refused > 0


@pytest.mark.filterwarnings("error")
@settings(max_examples=60, deadline=None)
@given(st.data())
def test_damaged_real_file(tmp_path_factory: pytest.TempPathFactory, data: st.DataObject) -> None:
    damaged = bytearray(shared("nav_test", "nav_test.solo.navmesh.bin").read_bytes())
    for at in data.draw(st.lists(st.integers(0, len(damaged) - 1), min_size=1, max_size=3)):
        damaged[at] = data.draw(st.integers(0, 255))
    cut = data.draw(st.one_of(st.just(len(damaged)), st.integers(0, len(damaged))))
    path = tmp_path_factory.mktemp("nav") / "nav.bin"
    path.write_bytes(damaged[:cut])
    problems, pieces = (), ()
    try:
        pieces = read(path).pieces
    except BadInput as error:
        problems = error.problems
    assert bool(pieces) != bool(problems)
    assert all("nav.bin" in problem.found and problem.remedy for problem in problems)
    assert not any("cannot be read" in problem.found for problem in problems)
    assert all(np.isfinite(piece.triangles).all() for piece in pieces)


@given(st.binary(max_size=300))
def test_any_bytes(data: bytes) -> None:
    for start in (b"", b"TESM\1\0\0\0\1\0\0\0", b"VAND\7\0\0\0"):
        assert not whole_or_refused(start + data)
