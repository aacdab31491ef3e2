"""The large map is what it claims to be: a city on the nav-mesh, six escapes, and without them no way out."""

from __future__ import annotations

import hashlib
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
import yaml
from free_space import FreeSpace
from map_modules import MAPS, scripts, triangles_of, z_up

from reachtest.columns import ColumnIndex
from reachtest.geometry import triangle_normals
from reachtest.levels import load_level
from reachtest.surface import SurfaceIndex

MAP = MAPS / "large"
GRAVITY, WALK, JUMP, STEP = 9.8, 6.0, 4.2, 0.45  # the `unreal` preset
APEX = JUMP**2 / (2 * GRAVITY)
EXPECTED_WITHIN_M = 3.0
DIGEST = """
import hashlib, sys
sys.path[:0] = [sys.argv[1], sys.argv[2]]
from make import build
for name, data in build().items():
    print(name, hashlib.sha256(data).hexdigest())
"""


@dataclass(frozen=True)
class Built:
    """The map, made anew in a folder of its own."""

    city: Any
    files: dict[str, bytes]
    folder: Path
    fixed: list[Any]  # the pieces of the fixed variant
    broken: list[Any]
    navmesh: np.ndarray  # [F, 3, 3]


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Built]:
    with scripts("large") as make:
        files = make.build()
        city = make.make_city(make.SEED)
        folder = tmp_path_factory.mktemp("large")
        (folder / "geometry").mkdir()
        for name, data in files.items():
            (folder / name).write_bytes(data)
        mended = [piece for escape in city.escapes for piece in escape.mended]
        broken = [piece for escape in city.escapes for piece in escape.broken]
        navmesh = triangles_of(folder / "navmesh.glb")
        yield Built(city, files, folder, [*city.pieces, *mended], [*city.pieces, *broken], navmesh)


@pytest.fixture(scope="module")
def columns(built: Built) -> ColumnIndex:
    """The collision geometry of the fixed variant."""
    parts = [triangles_of(built.folder / "geometry" / f"{part}.glb") for part in ("city", "mended")]
    return ColumnIndex(np.concatenate(parts))


def _document(built: Built, name: str) -> dict[str, Any]:
    return dict(yaml.safe_load(built.files[name]))


def _samples(triangles: np.ndarray, count: int) -> np.ndarray:
    """Places [n, 3] spread over the surface."""
    mesh = trimesh.Trimesh(
        triangles.reshape(-1, 3), np.arange(3 * len(triangles)).reshape(-1, 3), process=False
    )
    return np.asarray(trimesh.sample.sample_surface(mesh, count, seed=3)[0])


# --- the files


def test_text_files_are_what_make_writes(built: Built) -> None:
    for name in ("truth.yaml", "level.yaml", "level-fixed.yaml"):
        assert (MAP / name).read_bytes() == built.files[name], (
            f"{name} is stale: run python maps/large/make.py"
        )


def test_another_process_writes_the_same_bytes(built: Built) -> None:
    command = [sys.executable, "-c", DIGEST, str(MAP), str(MAPS)]
    lines = subprocess.run(command, capture_output=True, text=True, check=True).stdout.split("\n")
    expected = [f"{name} {hashlib.sha256(data).hexdigest()}" for name, data in built.files.items()]
    assert lines[:-1] == expected


def test_size(built: Built) -> None:
    level = load_level(built.folder / "level.yaml")
    extents = np.ptp(level.collision.reshape(-1, 3), axis=0)
    np.testing.assert_allclose(extents[:2], 1500.0)
    assert 50_000 < len(level.collision) < 150_000
    small = triangle_normals(triangles_of(MAPS / "small" / "navmesh.glb"))[1].sum()
    assert 180 < triangle_normals(built.navmesh)[1].sum() / small < 220


def test_level_files_differ_in_the_escapes_only(built: Built) -> None:
    buggy, fixed = _document(built, "level.yaml"), _document(built, "level-fixed.yaml")
    assert buggy.keys() == fixed.keys()
    assert {key for key in buggy if buggy[key] != fixed[key]} == {"name", "geometry"}
    meshes = [[entry["mesh"] for entry in level["geometry"]] for level in (buggy, fixed)]
    assert meshes == [
        ["geometry/city.glb", "geometry/broken.glb"],
        ["geometry/city.glb", "geometry/mended.glb"],
    ]
    assert len(load_level(built.folder / "level-fixed.yaml").spawns) == 16


# --- the nav-mesh


def test_navmesh_is_one_piece(built: Built) -> None:
    mesh = trimesh.Trimesh(built.navmesh.reshape(-1, 3), np.arange(built.navmesh.size // 3).reshape(-1, 3))
    assert (mesh.face_normals[:, 2] > 0.85).all()
    assert len(trimesh.graph.connected_components(mesh.face_adjacency, min_len=1)) == 1
    assert len(mesh.faces) == len(built.navmesh)


def test_navmesh_has_floor_below_and_head_room_above(built: Built, columns: ColumnIndex) -> None:
    places = _samples(built.navmesh, 20_000)
    floor, _ = columns.highest(
        places, 0.26, 0.01
    )  # between two treads a slope is a riser of 0.25 m above them
    assert np.isfinite(floor).all()
    overhead, _ = columns.highest(places, -0.02, 1.9)
    assert np.isnan(overhead).all()


def test_every_roof_with_stairs_is_on_the_navmesh(built: Built) -> None:
    middle = built.navmesh.mean(axis=1)
    area = triangle_normals(built.navmesh)[1]
    assert len(built.city.roofs) > 300
    for roof in built.city.roofs:
        rect = roof.rect
        there = (np.abs(middle[:, 2] - roof.top) < 1e-3) & (middle[:, 0] > rect.x0) & (middle[:, 0] < rect.x1)
        there &= (middle[:, 1] > rect.y0) & (middle[:, 1] < rect.y1)
        assert area[there].sum() > 0.7 * rect.width * rect.depth, roof.name


def test_spawns_and_required_places_are_on_the_navmesh_and_apart(built: Built) -> None:
    level = _document(built, "level.yaml")
    spawns = z_up(np.array([spawn["position"] for spawn in level["spawns"]]))
    places = z_up(np.array([place["position"] for place in level["required"]]))
    below, _ = ColumnIndex(built.navmesh).highest(np.concatenate([spawns, places]), 0.05, 0.05)
    assert np.isfinite(below).all()
    assert len(spawns) == 16
    assert np.ptp(spawns[:, :2], axis=0).min() > 900
    apart = np.linalg.norm(spawns[:, None] - spawns[None], axis=2) + 1e3 * np.eye(16)
    assert apart.min() > 200


# --- no way out of the fixed map, six out of the other


def _area(built: Built, west: int, south: int, east: int, north: int) -> tuple[float, float, float, float]:
    """The area between four streets, counted from the west and south wall; 0 is the street along the wall."""
    crossings = built.city.streets.crossings
    xs = sorted({x for _, _, x, _ in crossings})
    ys = sorted({y for _, _, _, y in crossings})
    return xs[west], ys[south], xs[east], ys[north]


@pytest.mark.parametrize("corner", [(5, 5), (1, 6), (9, 10)])
def test_whatever_can_be_got_to_in_the_city_is_near_the_navmesh(
    built: Built, corner: tuple[int, int]
) -> None:
    """Over four blocks: without a limit to how far a jump carries, and with the step height on top of it."""
    west, south = corner
    area = _area(built, west, south, west + 2, south + 2)
    space = FreeSpace(built.fixed, area)
    reached = space.reached((area[0] + 1.0, area[1] + 1.0), APEX + STEP)
    points = space.points(reached)
    roofs = [roof for roof in built.city.roofs if _within(roof.rect, area)]
    assert roofs
    assert points[:, 2].max() > min(roof.top for roof in roofs) + 1
    some = points[np.random.default_rng(0).choice(len(points), 100_000)]
    low, high = points.min(axis=0)[:2] - 4, points.max(axis=0)[:2] + 4
    flat = built.navmesh[:, :, :2]
    near = (flat.max(axis=1) > low).all(axis=1) & (flat.min(axis=1) < high).all(axis=1)
    away = ~SurfaceIndex(built.navmesh[near], EXPECTED_WITHIN_M).within(some)
    assert not away.any(), some[away][:5]


def _within(rect: Any, area: tuple[float, float, float, float]) -> bool:
    return bool(rect.x0 > area[0] and rect.y0 > area[1] and rect.x1 < area[2] and rect.y1 < area[3])


def _at_the_wall(position: np.ndarray) -> tuple[float, float, float, float]:
    """45 m to either side of an escape, 17 m inside of the walls and 10 m outside."""
    x, y = np.round(position[:2])
    return (-760.0, y - 45, -732.0, y + 45) if x < -740 else (x - 45, -760.0, x + 45, -732.0)


@pytest.mark.parametrize("number", range(6))
def test_escapes_are_there_and_mended(built: Built, number: int) -> None:
    position = z_up(np.array(_document(built, "truth.yaml")["bugs"][number]["position"]))
    area = _at_the_wall(position)
    start = (-735.0, area[3] - 1) if position[0] < -740 else (area[2] - 1, -735.0)
    # In the broken variant less than the jump's apex has to be enough, in the mended one more must not be.
    assert _gets_out(FreeSpace(built.broken, area), start, 0.75)
    assert not _gets_out(FreeSpace(built.fixed, area), start, APEX + STEP)


def _gets_out(space: FreeSpace, start: tuple[float, float], jump_m: float) -> bool:
    reached = space.reached(start, jump_m)
    return bool((reached[0] & ~space.ground).any())


def test_the_wall_is_within_a_jump_of_the_roof_without_parapet(built: Built) -> None:
    """The one escape that takes a long jump."""
    roof = next(
        piece for piece in built.city.pieces if piece.name == "pump house" and piece.kind == "platform"
    )
    wall = min(
        (piece for piece in built.city.pieces if piece.name.startswith("south wall")),
        key=lambda piece: abs(piece.low[0] - roof.low[0]) + abs(piece.high[0] - roof.high[0]),
    )
    assert wall.high[2] == roof.high[2]
    assert roof.low[1] - wall.high[1] < 0.75 * WALK * 2 * JUMP / GRAVITY


def test_walls_are_closed_all_round_in_the_fixed_map(built: Built) -> None:
    """The middle line of the walls, every 0.25 m: all of it under something at least 4.5 m high."""
    line = np.arange(-749.875, 750, 0.25)
    ends = np.full(len(line), 749.5)
    ring = np.concatenate(
        [np.column_stack(p) for p in ((line, ends), (line, -ends), (ends, line), (-ends, line))]
    )
    covered = np.zeros(len(ring), dtype=bool)
    for piece in built.fixed:
        if piece.low[2] <= 0 and piece.high[2] >= 4.5:
            covered |= ((ring > piece.low[:2]) & (ring < piece.high[:2])).all(axis=1)
    assert covered.all()


def test_truth_is_inside_the_bounds_and_at_the_west_and_south_edge(built: Built) -> None:
    bugs = _document(built, "truth.yaml")["bugs"]
    bounds = _document(built, "level.yaml")["bounds_m"]
    edges = []
    for bug in bugs:
        position = z_up(np.array(bug["position"]))
        corners = z_up(np.array([bug["bounds"]["low"], bug["bounds"]["high"]]))
        low, high = corners.min(axis=0), corners.max(axis=0)
        assert ((low >= bounds["low"]) & (high <= bounds["high"])).all(), bug["name"]
        assert ((low <= position) & (position <= high)).all(), bug["name"]
        edges.append("west" if position[0] < -740 else "south" if position[1] < -740 else "elsewhere")
    assert edges == ["west"] * 3 + ["south"] * 3
