"""The gym as a level: every exercise a lane, with what must be reached and what must not."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
import trimesh
from map_modules import MAPS, scripts, triangles_of

from reachtest.levels import load_level
from reachtest.records import Level
from reachtest.surface import SurfaceIndex

MAP = MAPS / "gym"


@pytest.fixture(scope="module")
def make() -> Iterator[Any]:
    with scripts("gym") as module:
        yield module


@pytest.fixture(scope="module")
def level() -> Level:
    return load_level(MAP / "level.yaml")


def test_committed_files_are_what_make_writes(make: Any) -> None:
    files = make.build()
    for name, data in files.items():
        assert (MAP / name).read_bytes() == data, f"{name} is stale: run python maps/gym/make.py"
    assert sum(map(len, files.values())) < 300_000


def test_every_exercise_is_a_lane_with_a_spawn(make: Any, level: Level) -> None:
    names = list(make.lanes(make.CHARACTERS[make.CHARACTER]))
    assert [spawn.name for spawn in level.spawns] == [lane.name for lane in names]
    assert {part.name for part in level.parts} >= {spawn.name for spawn in level.spawns}


def test_lanes_do_not_touch(make: Any) -> None:
    outer = [lane.moved(wall) for lane in make.lanes(make.CHARACTERS[make.CHARACTER]) for wall in lane.walls]
    names = list(dict.fromkeys(wall.name for wall in outer))
    south = [min(wall.low[1] for wall in outer if wall.name == name) for name in names]
    north = [max(wall.high[1] for wall in outer if wall.name == name) for name in names]
    assert all(a < b for a, b in zip(north[:-1], south[1:], strict=True))


def test_spawns_and_required_places_are_on_the_navmesh(level: Level) -> None:
    places = np.array([s.position for s in level.spawns] + [r.position for r in level.required])
    assert (SurfaceIndex(level.navmesh.triangles, 3.0).distance(places) < 0.5).all()


def test_navmesh_is_nowhere_that_is_forbidden(level: Level) -> None:
    centres = level.navmesh.triangles.mean(axis=1)
    for zone in level.zones:
        assert not ((centres > zone.low) & (centres < zone.high)).all(axis=1).any(), zone.name


def test_every_node_is_closed() -> None:
    scene = trimesh.load_scene(MAP / "geometry" / "gym.glb")
    assert len(triangles_of(MAP / "geometry" / "gym.glb")) > 2000
    for name in scene.graph.nodes_geometry:
        _, geometry = scene.graph[name]
        faces = scene.geometry[geometry].faces
        if name == "tessellated floor at terminal velocity (shapes)":
            continue  # a sheet on purpose
        edges = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        assert (np.unique(edges, axis=0, return_counts=True)[1] % 2 == 0).all(), name
        assert scene.geometry[geometry].volume > 0, name
