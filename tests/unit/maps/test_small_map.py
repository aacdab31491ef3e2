"""The small map is what it claims to be: two planted bugs, and without them no way out."""

from __future__ import annotations

import fnmatch
import importlib
import sys
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
import trimesh
import yaml

from reachtest.levels import load_level
from reachtest.surface import SurfaceIndex

MAP = Path(__file__).parents[3] / "maps" / "small"
GRAVITY, WALK, JUMP, STEP, RADIUS = 9.8, 6.0, 4.2, 0.45, 0.34  # the `unreal` preset
EXPECTED_WITHIN_M = 3.0


@pytest.fixture(scope="module")
def modules() -> Iterator[dict[str, ModuleType]]:
    """The map's own scripts, imported as `python maps/small/make.py` would."""
    names = ("layout", "mesh", "walkable", "make")
    sys.path.insert(0, str(MAP))
    try:
        yield {name: importlib.import_module(name) for name in names}
    finally:
        sys.path.remove(str(MAP))
        for name in names:
            sys.modules.pop(name, None)


@pytest.fixture(scope="module")
def pieces(modules: dict[str, ModuleType]) -> list[Any]:
    return list(modules["layout"].PIECES)


def _z_up(points: np.ndarray) -> np.ndarray:
    return np.stack([points[..., 0], -points[..., 2], points[..., 1]], axis=-1)


@pytest.fixture(scope="module")
def nodes() -> dict[str, trimesh.Trimesh]:
    """The committed geometry by node name, in level coordinates."""
    scene = trimesh.load_scene(MAP / "geometry" / "level.glb")
    found = {}
    for name in scene.graph.nodes_geometry:
        matrix, geometry = scene.graph[name]
        mesh = scene.geometry[geometry].copy().apply_transform(matrix)
        mesh.vertices = _z_up(mesh.vertices)
        found[name] = mesh
    return found


@pytest.fixture(scope="module")
def navmesh() -> trimesh.Trimesh:
    """The committed nav-mesh in level coordinates."""
    mesh = trimesh.load_scene(MAP / "navmesh.glb", process=False).to_mesh()
    mesh.vertices = _z_up(mesh.vertices)
    return mesh


def _distance(points: np.ndarray, navmesh: trimesh.Trimesh) -> np.ndarray:
    """Distance [n] to the nav-mesh surface [m], infinite beyond 4 m."""
    return SurfaceIndex(np.asarray(navmesh.triangles), 4.0).distance(points)


def _level(name: str) -> dict[str, Any]:
    return dict(yaml.safe_load((MAP / name).read_text()))


def _names(level: dict[str, Any], roles: tuple[str, ...], pieces: list[Any]) -> list[str]:
    """The pieces a level file takes in one of `roles`, as often as it takes them."""
    globs = [glob for entry in level["geometry"] if entry["role"] in roles for glob in entry["nodes"]]
    return [piece.name for glob in globs for piece in pieces if fnmatch.fnmatchcase(piece.name, glob)]


# --- the files


def test_committed_files_are_what_make_writes(modules: dict[str, ModuleType]) -> None:
    for name, data in modules["make"].build().items():
        assert (MAP / name).read_bytes() == data, f"{name} is stale: run python maps/small/make.py"


def test_data_is_small() -> None:
    files = [MAP / "geometry" / "level.glb", MAP / "navmesh.glb", MAP / "truth.yaml"]
    assert sum(file.stat().st_size for file in files) < 300_000


def test_every_piece_is_a_named_closed_outward_surface(
    nodes: dict[str, trimesh.Trimesh], pieces: list[Any]
) -> None:
    assert sorted(nodes) == sorted(piece.name for piece in pieces)
    for piece in pieces:
        mesh = nodes[piece.name]
        assert mesh.is_watertight, piece.name
        assert mesh.volume > 0, piece.name
        np.testing.assert_allclose(mesh.bounds, [piece.low, piece.high], atol=1e-5, err_msg=piece.name)


def test_level_files_differ_in_the_two_bugs_only(pieces: list[Any]) -> None:
    buggy, fixed = _level("level.yaml"), _level("level-fixed.yaml")
    everything = Counter(piece.name for piece in pieces)
    bugs = Counter(["stray ramp", "monolith"])
    assert Counter(_names(buggy, ("collision", "both"), pieces)) == everything - Counter(["monolith"])
    assert _names(buggy, ("solid", "both"), pieces) == ["monolith"]
    assert Counter(_names(fixed, ("collision", "both"), pieces)) == everything - bugs + Counter(["monolith"])
    assert _names(fixed, ("solid", "both"), pieces) == ["monolith"]
    for key in buggy.keys() - {"name", "geometry"}:
        assert buggy[key] == fixed[key], key


@pytest.mark.parametrize(
    ("file", "triangles_of_bugs"), [("level.yaml", {"stray ramp"}), ("level-fixed.yaml", {"monolith"})]
)
def test_level_loads_with_its_pieces_by_name(
    file: str, triangles_of_bugs: set[str], pieces: list[Any], nodes: dict[str, trimesh.Trimesh]
) -> None:
    level = load_level(MAP / file)
    assert [solid.name for solid in level.solids] == ["monolith"]
    solid_pieces = {p.name for p in pieces} - {"stray ramp", "monolith"} | triangles_of_bugs
    assert len(level.collision) == sum(len(nodes[name].faces) for name in solid_pieces)
    assert {part.name for part in level.parts} == solid_pieces | {"monolith"}


def test_truth_lies_where_the_bugs_are(nodes: dict[str, trimesh.Trimesh], navmesh: trimesh.Trimesh) -> None:
    bugs = yaml.safe_load((MAP / "truth.yaml").read_text())["bugs"]
    assert [bug["kind"] for bug in bugs] == ["unexpected_area", "inside_solid"]
    for bug, name in zip(bugs, ("stray ramp", "monolith"), strict=True):
        position, low, high = (np.array(v) for v in (bug["position"], *bug["bounds"].values()))
        at = _z_up(position)
        assert ((low <= position) & (position <= high)).all(), name
        assert _inside(at[None], *nodes[name].bounds).all(), name
        # Reached by an agent, either place is beyond what the paper calls expected.
        assert _distance(at[None], navmesh)[0] > EXPECTED_WITHIN_M


# --- the nav-mesh


def test_navmesh_faces_up_and_is_connected(navmesh: trimesh.Trimesh) -> None:
    assert (navmesh.face_normals[:, 2] > 0.8).all()
    merged = navmesh.copy()
    merged.merge_vertices()
    edges = Counter(map(tuple, merged.edges_sorted.tolist()))
    assert max(edges.values()) == 2
    assert len(trimesh.graph.connected_components(merged.face_adjacency, min_len=1)) == 1


def test_navmesh_covers_the_free_floor(navmesh: trimesh.Trimesh, pieces: list[Any]) -> None:
    """On the floor: exactly the places 0.4 m (square) away from whatever stands below head height."""
    rng = np.random.default_rng(0)
    points = np.column_stack([rng.uniform(-50, 50, (4000, 2)), np.zeros(4000)])
    standing = [p for p in pieces if p.name != "floor" and p.low[2] < 1.9 - 1e-6]
    low, high = (np.array([getattr(p, end)[:2] for p in standing]) for end in ("low", "high"))
    gap = np.maximum(low - points[:, None, :2], points[:, None, :2] - high).max(axis=2).min(axis=1)
    on_mesh = _distance(points, navmesh) < 1e-4
    far, near = gap > 0.5 + 1e-4, (gap < 0.4 - 1e-4)  # in between: stairs, whose slope starts a tread early
    assert on_mesh[far & ~_before_a_slope(points, pieces)].all()
    assert not on_mesh[near & ~_before_a_slope(points, pieces)].any()
    assert far.sum() > 3000 > near.sum() > 300


def _before_a_slope(points: np.ndarray, pieces: list[Any]) -> np.ndarray:
    """Within 0.6 m of a ramp's or stairs' footprint, where the nav-mesh goes up to and over its foot."""
    slopes = [p for p in pieces if p.kind in ("ramp", "stairs") and p.on_navmesh]
    near = np.zeros(len(points), dtype=bool)
    for p in slopes:
        near |= (
            (points[:, :2] > np.array(p.low[:2]) - 0.6) & (points[:, :2] < np.array(p.high[:2]) + 0.6)
        ).all(1)
    return near


def test_navmesh_lies_on_the_surface(navmesh: trimesh.Trimesh, pieces: list[Any]) -> None:
    """Every sampled nav-mesh point has its floor within a stair's rise below, and head room above."""
    points, _ = trimesh.sample.sample_surface(navmesh, 4000, seed=1)
    for x, y, z in points:
        over = [p for p in pieces if p.low[0] <= x <= p.high[0] and p.low[1] <= y <= p.high[1]]
        heights = [float(_height(p, np.array([x]), np.array([y]))[0]) for p in over]
        support = max(h for h in heights if h <= z + 0.02)
        assert z - support <= 0.3 + 0.02, (x, y, z)
        # Nothing else up to the head: its surface is higher, so its underside has to be above.
        assert all(p.low[2] >= z + 1.76 for p, h in zip(over, heights, strict=True) if h > z + 0.02), (
            x,
            y,
            z,
        )


def test_navmesh_has_the_spawn_and_the_required_places(navmesh: trimesh.Trimesh) -> None:
    points = [_z_up(np.array(r["position"], float)) for r in _level("level.yaml")["required"]]
    points.append(_z_up(np.array(_level("level.yaml")["spawns"][0]["position"], float)))
    assert (_distance(np.array(points), navmesh) < 0.05).all()
    assert 8500 < navmesh.area < 9604  # the yard is 98 m x 98 m inside


# --- no way out of the fixed map


def _height(piece: Any, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Height of the top surface of `piece` [m] at places [n] above it."""
    axis = 0 if piece.uphill[1] == "x" else 1
    share = ((x if axis == 0 else y) - piece.low[axis]) / (piece.high[axis] - piece.low[axis])
    share = share if piece.uphill[0] == "+" else 1 - share
    if piece.kind == "stairs":  # of four steps
        share = np.minimum(np.floor(share * 4) + 1, 4) / 4
    elif piece.kind != "ramp":
        share = np.ones(len(x))
    return np.asarray(piece.low[2] + share * (piece.high[2] - piece.low[2]))


def _reach(rise: float) -> float:
    """How far [m] a jump at walking speed carries, edge to edge, to a place `rise` [m] higher; -1 if nowhere.

    Generous: the step-up counts as extra height of the jump, and the capsule hangs over both edges.
    """
    square = JUMP**2 - 2 * GRAVITY * (rise - STEP)
    return -1.0 if square < 0 else WALK * (JUMP + square**0.5) / GRAVITY + 2 * RADIUS


def _gap(a: Any, b: Any) -> float:
    """Horizontal distance of the footprints [m]."""
    apart = [max(a.low[i] - b.high[i], b.low[i] - a.high[i], 0.0) for i in (0, 1)]
    return float(np.hypot(*apart))


def _reachable(pieces: list[Any]) -> set[str]:
    """Names of pieces that could be stood on, jumping from the highest point of each, from the floor on."""
    reached = {"floor"}
    while True:
        tops = [p for p in pieces if p.name in reached]
        more = {
            p.name
            for p in pieces
            if p.name not in reached
            and any(
                _reach((p.low[2] if p.kind == "ramp" else p.high[2]) - a.high[2]) >= _gap(a, p) for a in tops
            )
        }
        if not more:
            return reached
        reached |= more


def _fixed(pieces: list[Any]) -> list[Any]:
    names = _names(_level("level-fixed.yaml"), ("collision", "both"), pieces)
    return [p for p in pieces if p.name in names]


def test_no_jump_leads_out_of_the_fixed_map(pieces: list[Any]) -> None:
    reached = _reachable(_fixed(pieces))
    outer = {p.name for p in pieces if p.name.endswith(("wall", "tower"))}
    assert len(outer) == 8
    assert not reached & outer
    assert not reached & {"monolith", "pillar 1", "room wall 1"}
    walkable = {p.name for p in pieces if p.on_navmesh and p.kind != "block"}
    assert walkable <= reached


def test_the_stray_ramp_leads_onto_the_south_wall(pieces: list[Any]) -> None:
    """And so the proof above can fail."""
    reached = _reachable([p for p in pieces if p.name != "monolith"])
    assert "south wall" in reached
    assert not reached & {"south-west tower", "south-east tower"}


def test_whatever_can_be_stood_on_in_the_fixed_map_is_near_the_navmesh(
    pieces: list[Any], navmesh: trimesh.Trimesh
) -> None:
    fixed = _fixed(pieces)
    reached = _reachable(fixed)
    for piece in fixed:
        if piece.name in reached:
            x, y = (
                np.linspace(piece.low[i], piece.high[i], max(5, int(piece.high[i] - piece.low[i])))
                for i in (0, 1)
            )
            xs, ys = (grid.ravel() for grid in np.meshgrid(x, y))
            inside = (np.abs(xs) < 49) & (np.abs(ys) < 49)  # the floor goes on under the outer walls
            places = np.column_stack([xs, ys, _height(piece, xs, ys)])[inside]
            others = [p for p in fixed if p is not piece and p.high[2] > piece.high[2]]
            buried = np.any([_inside(places, p.low, p.high) for p in others], axis=0)
            assert (_distance(places[~buried], navmesh) <= EXPECTED_WITHIN_M - 0.1).all(), piece.name


def _inside(places: np.ndarray, low: Any, high: Any) -> np.ndarray:
    """Whether `places` [n, 3] are in the closed box [n]."""
    return np.asarray(((places >= np.array(low) - 1e-5) & (places <= np.array(high) + 1e-5)).all(axis=1))


def test_whoever_jumps_off_anything_in_the_fixed_map_stays_near_the_navmesh(
    pieces: list[Any], navmesh: trimesh.Trimesh
) -> None:
    """Along the whole flight, from every edge, straight ahead and slantwise, at full speed and below."""
    fixed = _fixed(pieces)
    reached = _reachable(fixed)
    time = np.arange(0, 1.4, 1 / 15)
    rise = JUMP * time - GRAVITY / 2 * time**2
    for piece in (p for p in fixed if p.name in reached and p.high[2] > 1.2):
        paths = [
            np.column_stack([start[:2] + np.outer(time, velocity), start[2] + rise])
            for start, normal in _edges(piece)
            for velocity in _velocities(normal)
        ]
        flight = np.concatenate(paths)
        flight = flight[(flight[:, 2] > 0) & (np.abs(flight[:, :2]) < 49).all(axis=1)]
        assert (_distance(flight, navmesh) <= EXPECTED_WITHIN_M).all(), piece.name


def _edges(piece: Any) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Points on the rim, a capsule radius outside, with the outward normal."""
    low, high = np.array(piece.low[:2], float), np.array(piece.high[:2], float)
    for axis in (0, 1):
        for sign, end in ((-1, low), (1, high)):
            normal = np.zeros(2)
            normal[axis] = sign
            for share in np.linspace(0, 1, 5):
                point = low + share * (high - low)
                point[axis] = end[axis]
                height = _height(piece, point[:1], point[1:])
                yield np.concatenate([point + RADIUS * normal, height]), normal


def _velocities(normal: np.ndarray) -> Iterator[np.ndarray]:
    across = normal[::-1]
    for turn in np.deg2rad([-45, 0, 45]):
        for speed in (WALK, WALK / 2):
            yield speed * (np.cos(turn) * normal + np.sin(turn) * across)
