"""The traversal map is what it claims to be: all of it can be climbed, and with all its nets nobody gets out."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
import trimesh
import yaml
from map_modules import MAPS, scripts, triangles_of, z_up

from reachtest.columns import ColumnIndex
from reachtest.geometry import triangle_normals
from reachtest.levels import load_level
from reachtest.surface import SurfaceIndex

MAP = MAPS / "traversal"
GRAVITY, WALK, JUMP, STEP, RADIUS = 9.8, 6.0, 4.2, 0.45, 0.34  # the `unreal` preset
MARGIN = 0.75  # of what a jump carries
WALL_TOP_M, INSIDE_M = 8.0, 99.0


@dataclass(frozen=True)
class Built:
    """The map, made anew."""

    files: dict[str, bytes]
    pieces: list[Any]  # of both variants
    mended: list[Any]
    navmesh: np.ndarray  # [F, 3, 3]
    patch: np.ndarray  # [F] which connected patch of the nav-mesh
    truth: dict[str, Any]


@pytest.fixture(scope="module")
def built() -> Iterator[Built]:
    with scripts("traversal") as make:
        from kit.navmesh import components

        course, views = make.make_course()
        mesh = make.walkable(course, views)
        mended = [piece for view in views for piece in view.mended]
        files = make.build()
        truth = yaml.safe_load(files["truth.yaml"])
        triangles = mesh.vertices[mesh.faces]
        yield Built(files, course.pieces, mended, triangles, components(mesh.faces), truth)


def _places(entries: list[dict[str, Any]], key: str) -> np.ndarray:
    return z_up(np.array([entry[key] for entry in entries], float))


def _patch_at(built: Built, place: np.ndarray) -> int:
    """The patch of the nav-mesh at a place [3]."""
    flat = built.navmesh[:, :, :2]
    near = (flat.min(axis=1) <= place[:2] + 1e-6).all(axis=1) & (flat.max(axis=1) >= place[:2] - 1e-6).all(
        axis=1
    )
    for number in np.unique(built.patch[near]):
        triangles = built.navmesh[near & (built.patch == number)]
        if np.isfinite(ColumnIndex(triangles).highest(place[None], 0.05, 0.05)[0][0]):
            return int(number)
    raise AssertionError(f"{place} is not on the nav-mesh")


# --- the files


def test_committed_files_are_what_make_writes(built: Built) -> None:
    for name, data in built.files.items():
        assert (MAP / name).read_bytes() == data, f"{name} is stale: run python maps/traversal/make.py"
    assert sum(map(len, built.files.values())) < 300_000


@pytest.mark.parametrize("name", ["level.yaml", "level-fixed.yaml"])
def test_level_loads(name: str) -> None:
    level = load_level(MAP / name)
    assert level.explore.steps == 10_000_000
    assert level.explore.goal_spacing_m == 4


def test_level_files_differ_in_the_nets_only(built: Built) -> None:
    buggy, fixed = (yaml.safe_load(built.files[name]) for name in ("level.yaml", "level-fixed.yaml"))
    assert {key for key in buggy if buggy[key] != fixed[key]} == {"name", "geometry"}
    assert [entry["mesh"] for entry in fixed["geometry"]] == ["geometry/course.glb", "geometry/mended.glb"]
    assert [entry["mesh"] for entry in buggy["geometry"]] == ["geometry/course.glb"]


# --- the nav-mesh


def test_navmesh_has_floor_below_and_head_room_above(built: Built) -> None:
    parts = [triangles_of(MAP / "geometry" / f"{part}.glb") for part in ("course", "mended")]
    columns = ColumnIndex(np.concatenate(parts))
    index = np.arange(3 * len(built.navmesh)).reshape(-1, 3)
    mesh = trimesh.Trimesh(built.navmesh.reshape(-1, 3), index, process=False)
    places = np.concatenate(
        [trimesh.sample.sample_surface(mesh, 20_000, seed=3)[0], built.navmesh.mean(axis=1)]
    )
    assert np.isfinite(columns.highest(places, 0.26, 0.01)[0]).all()
    assert np.isnan(columns.highest(places, -0.02, 1.9)[0]).all()


def test_navmesh_goes_up_fifty_metres(built: Built) -> None:
    assert built.navmesh[:, :, 2].max() > 50
    area = triangle_normals(built.navmesh)[1]
    assert area[built.navmesh[:, :, 2].min(axis=1) > 1].sum() > 3000


def test_every_patch_can_be_got_to_by_the_jumps_and_drops_listed(built: Built) -> None:
    links = built.truth["links"]
    ends = [[_patch_at(built, place) for place in _places(links, key)] for key in ("from", "to")]
    spawn = z_up(np.array(yaml.safe_load(built.files["level.yaml"])["spawns"][0]["position"]))
    reached = {_patch_at(built, spawn)}
    while more := {b for a, b in zip(*ends, strict=True) if a in reached} - reached:
        reached |= more
    assert reached == set(range(built.patch.max() + 1))


def test_every_jump_is_within_three_quarters_of_what_a_jump_carries(built: Built) -> None:
    jumps = [link for link in built.truth["links"] if link["skill"] == "jump"]
    assert len(jumps) > 50
    for link, start, end in zip(jumps, _places(jumps, "from"), _places(jumps, "to"), strict=True):
        gap = min(_gap(a, b) for a in _platforms(built, start) for b in _platforms(built, end))
        rise = end[2] - start[2]
        assert rise <= 0.8 + 1e-6
        assert gap == pytest.approx(link["gap_m"], abs=1e-6)
        assert rise == pytest.approx(link["rise_m"], abs=1e-6)
        assert gap <= MARGIN * WALK * _air_time(rise), link


def _air_time(rise: float) -> float:
    return float(JUMP + np.sqrt(JUMP**2 - 2 * GRAVITY * rise)) / GRAVITY


def _platforms(built: Built, place: np.ndarray) -> list[Any]:
    """The platforms whose top is at a place [3]."""
    return [
        piece
        for piece in built.pieces
        if piece.kind == "platform"
        and abs(piece.high[2] - place[2]) < 1e-3
        and all(piece.low[k] <= place[k] <= piece.high[k] for k in (0, 1))
    ]


def _gap(a: Any, b: Any) -> float:
    """Horizontal distance of two footprints [m]."""
    return float(np.hypot(*(max(a.low[k] - b.high[k], b.low[k] - a.high[k], 0.0) for k in (0, 1))))


def test_drops_end_below_open_air(built: Built) -> None:
    columns = ColumnIndex(triangles_of(MAP / "geometry" / "course.glb"))
    drops = [link for link in built.truth["links"] if link["skill"] == "drop"]
    ends = _places(drops, "to")
    assert len(ends) == 2
    np.testing.assert_allclose(
        columns.highest(ends + np.array([0, 0, 60]), 100.0, 0.0)[0], ends[:, 2], atol=1e-4
    )


def test_rooms_at_the_end_of_a_drop_can_be_entered_by_it_only(built: Built) -> None:
    """Their doors are higher above the ground outside than a jump with a step on top."""
    rooms = [part for part in built.truth["parts"] if part["skill"] == "drop"]
    for room, place in zip(rooms, _places(rooms, "position"), strict=True):
        assert place[2] > JUMP**2 / (2 * GRAVITY) + STEP
        patch = _patch_at(built, place)
        into = [link for link in built.truth["links"] if _patch_at(built, _places([link], "to")[0]) == patch]
        assert [link["skill"] for link in into] == ["drop"], room["name"]


def test_parts_name_the_skills_of_the_way_to_them(built: Built) -> None:
    parts = {part["name"]: part for part in built.truth["parts"]}
    assert {part["skill"] for part in parts.values()} == {"walk", "jump", "beam", "drop"}
    for part in parts.values():
        before = parts[part["after"]]["needs"] if part["after"] else []
        assert part["needs"] == list(dict.fromkeys([*before, part["skill"]])), part["name"]
        place = _places([part], "position")[0]
        low, high = np.sort(z_up(np.array([part["bounds"]["low"], part["bounds"]["high"]])), axis=0)
        assert ((low <= place) & (place <= high)).all(), part["name"]
        _patch_at(built, place)
    assert parts["keep crown"]["needs"] == ["walk", "beam", "jump"]


def test_beams_are_narrow(built: Built) -> None:
    beams = [piece for piece in built.pieces if piece.name.endswith("beam")]
    assert len(beams) == 6
    for beam in beams:
        sides = sorted(beam.high[k] - beam.low[k] for k in (0, 1))
        assert 0.8 <= sides[0] <= 1.0 < 15 < sides[1], beam.name


# --- out of the map, and not


def _fliers(built: Built, nets: list[Any]) -> set[str]:
    """From the tops of which pieces one can jump past the nets over, or onto, the outer walls."""
    bars = [piece for piece in nets if "net" in piece.name]
    low, high = (np.array([getattr(bar, end) for bar in bars]) for end in ("low", "high"))
    angles = np.deg2rad(np.arange(0, 360, 5))
    ways = np.column_stack([np.cos(angles), np.sin(angles)])
    found = set()
    for piece in built.pieces:
        if piece.kind == "block" or piece.top <= WALL_TOP_M - JUMP**2 / (2 * GRAVITY) - STEP:
            continue
        reach = WALK * _air_time(WALL_TOP_M - piece.top - STEP) + RADIUS
        starts = _grid(piece)
        ends = starts[:, None] + reach * ways[None]
        out = np.abs(ends).max(axis=2) > INSIDE_M
        s, e = starts[np.nonzero(out)[0]], ends[out]
        barred = np.zeros(len(s), dtype=bool)
        for a, b in zip(low, high, strict=True):
            if a[2] <= piece.top + 1e-6 and b[2] >= piece.top + JUMP**2 / (2 * GRAVITY) + STEP:
                barred |= _crosses(s, e, a[:2], b[:2])
        if (~barred).any():
            found.add(piece.name)
    return found


def _grid(piece: Any) -> np.ndarray:
    """Places [n, 2] on a top, where the middle of a capsule that does not hang over a net can be."""
    low, high = (np.array(end[:2]) for end in (piece.low, piece.high))
    xs, ys = (np.linspace(a + 0.3, b - 0.3, max(2, int(b - a))) for a, b in zip(low, high, strict=True))
    return np.column_stack([grid.ravel() for grid in np.meshgrid(xs, ys)])


def _crosses(start: np.ndarray, end: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Whether segments [n, 2] cross a rectangle."""
    way = np.where(np.abs(end - start) < 1e-9, 1e-9, end - start)
    a, b = (low - start) / way, (high - start) / way
    enter, leave = np.minimum(a, b).max(axis=1), np.maximum(a, b).min(axis=1)
    return np.asarray((enter <= leave) & (leave >= 0) & (enter <= 1))


def test_nobody_flies_out_of_the_fixed_map(built: Built) -> None:
    assert _fliers(built, [*built.pieces, *built.mended]) == set()


def test_four_lookouts_lead_out_of_the_other(built: Built) -> None:
    lookouts = _fliers(built, built.pieces)
    assert lookouts == {f"{side} lookout" for side in ("east", "south", "west", "north")}
    assert {bug["name"] for bug in built.truth["bugs"]} == {f"{name} without a net" for name in lookouts}


def test_whatever_one_can_land_on_in_the_fixed_map_is_near_the_navmesh(built: Built) -> None:
    """All tops but those of the outer walls, wherever they are not inside of something else."""
    pieces = [*built.pieces, *built.mended]
    surface = SurfaceIndex(built.navmesh, 3.0)
    for piece in pieces:
        if piece.name.endswith((" wall", " corner")) or piece.is_slope:
            continue
        low, high = (np.array(end[:2]) for end in (piece.low, piece.high))
        low, high = np.maximum(low, -INSIDE_M), np.minimum(high, INSIDE_M)
        xs, ys = (np.linspace(a, b, max(3, int(2 * (b - a)))) for a, b in zip(low, high, strict=True))
        flat = np.column_stack([grid.ravel() for grid in np.meshgrid(xs, ys)])
        tops = np.column_stack([flat, np.full(len(flat), piece.high[2])])
        buried = np.zeros(len(tops), dtype=bool)
        for other in pieces:
            inside = (tops >= np.array(other.low) - 1e-6) & (
                tops + np.array([0, 0, 0.1]) <= np.array(other.high) + 1e-6
            )
            buried |= inside.all(axis=1)
        assert surface.within(tops[~buried]).all(), piece.name


def test_truth_is_inside_the_bounds(built: Built) -> None:
    bounds = yaml.safe_load(built.files["level.yaml"])["bounds_m"]
    for bug in built.truth["bugs"]:
        corners = z_up(np.array([bug["bounds"]["low"], bug["bounds"]["high"]]))
        low, high = corners.min(axis=0), corners.max(axis=0)
        position = z_up(np.array(bug["position"]))
        assert ((low >= bounds["low"]) & (high <= bounds["high"])).all(), bug["name"]
        assert ((low <= position) & (position <= high)).all(), bug["name"]
