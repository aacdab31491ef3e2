"""Levels that ship with games and engines, read whole."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from reachtest.levels import check_level, load_level

SHARED = Path(__file__).parents[4] / "shared" / "levels"

# (folder, geometry, nav-mesh, triangles, extents x, y, z in source axes), as that folder's README states them
LEVELS = [
    ("nav_test", "nav_test.obj", "nav_test.solo.navmesh.glb", 1_612, (91, 22, 77)),
    ("nav_test", "nav_test.obj", "nav_test.solo.navmesh.obj", 1_612, (91, 22, 77)),
    ("dungeon", "dungeon.obj", "dungeon.solo.navmesh.glb", 10_133, (74, 40, 99)),
    ("three_pathfinding", "level.glb", "level.nav.obj", 1_612, (18, 4, 15)),
    ("demo_level", "demo-level.glb", "demo-level-navmesh.glb", 1_110, (20, 7, 20)),
    ("tut3d", "step21-static.gltf", "navmesh.gltf", 724, (100, 7, 100)),
    ("bridges", "bridges.glb", "bridges.solo.navmesh.glb", 7_158, (28, 5, 14)),
    ("oa_dm1", "oa_dm1.collision.glb", "oa_dm1.solo.navmesh.glb", 6_260, (60, 19, 37)),
    ("aggressor", "aggressor.collision.glb", "aggressor.solo.navmesh.glb", 9_310, (45, 28, 48)),
    ("c2_pandora", "pandora.m.glb", "c2_pandora.solo.navmesh.glb", 60_810, None),
]


@pytest.fixture
def level_file(tmp_path: Path) -> Path:
    if not SHARED.is_dir():
        pytest.skip("the real levels are not next to the project (../shared/levels)")
    return tmp_path / "level.yaml"


def write(path: Path, folder: str, geometry: dict[str, str], navmesh: str) -> Path:
    reach = SHARED / folder / "jolt_reach.walk.json"
    spawn = json.loads(reach.read_text())["spawn"] if reach.exists() else [0, 0, 0]
    document = {
        "version": 1,
        "frame": {"up_axis": "y"},
        "geometry": [{**geometry, "mesh": str(SHARED / folder / geometry["mesh"])}],
        "navmesh": {"mesh": str(SHARED / folder / navmesh)},
        "character": "unreal",
        "spawns": [spawn],
    }
    path.write_text(json.dumps(document))
    return path


@pytest.mark.parametrize(
    ("folder", "mesh", "navmesh", "triangles", "extents"), LEVELS, ids=[case[2] for case in LEVELS]
)
def test_real_level(
    level_file: Path, folder: str, mesh: str, navmesh: str, triangles: int, extents: tuple[float, ...] | None
) -> None:
    level = load_level(write(level_file, folder, {"mesh": mesh}, navmesh))
    check = check_level(level)
    facts = dict(check.facts)
    dropped = int(facts["collision"].split("(")[1].split()[0]) if "(" in facts["collision"] else 0
    assert len(level.collision) + dropped == triangles
    if extents:
        x, y, z = level.collision.max(axis=(0, 1)) - level.collision.min(axis=(0, 1))
        assert (x, z, y) == pytest.approx(extents, abs=0.55)
    assert check.warnings == ()
    assert float(facts["nav-mesh with a floor within 1 m"].rstrip("%")) >= 99


def test_convex_brushes_are_solids_of_their_own(level_file: Path) -> None:
    geometry = {"mesh": "oa_dm1.brushes.glb", "role": "both"}
    level = load_level(write(level_file, "oa_dm1", geometry, "oa_dm1.solo.navmesh.glb"))
    assert len(level.solids) == 529
    assert len(level.parts) == 529
