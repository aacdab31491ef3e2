"""Floors off the nav-mesh that leaps are aimed at: what they are, and what is none."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from reachtest.explore.directed import floors
from reachtest.explore.directed.floors import with_floors
from reachtest.navmesh.build import build_navmesh
from reachtest.navmesh.islands import Islands
from reachtest.navmesh.settings import settings_for
from reachtest.records import Floats, Level, NavMesh
from tests.levels import UNREAL, box, level

YARD = box([-8, -8, -1], [8, 8, 0])
STONE = box([10, 0, -1], [11.2, 1.2, 0])  # too small for the nav-mesh
CRATE = box([-3, -3, 0], [-1, -1, 1.2])  # its top is left out of the nav-mesh below


def built(*pieces: Floats) -> tuple[Level, Islands]:
    """The level, and its nav-mesh of what is at height 0."""
    where = level(*pieces)
    navmesh = build_navmesh(where.collision, settings_for(UNREAL))
    low = (navmesh.triangles[:, :, 2] < 0.2).all(axis=1)
    kept = NavMesh("nav.obj", navmesh.vertices, navmesh.faces[low], agent=navmesh.agent)
    return replace(where, navmesh=kept), Islands(kept)


def tops(where: Level, own: Islands) -> list[tuple[float, float, float]]:
    """The middle of each floor that was added, to a decimetre."""
    joined = with_floors(where, own)
    assert (joined.labels[: len(own.labels)] == own.labels).all()
    result = []
    for island in range(own.count, joined.count):
        corners = joined.navmesh.triangles[joined.labels == island].reshape(-1, 3)
        x, y, z = (corners.min(axis=0) + corners.max(axis=0)) / 2
        result.append((round(x, 1), round(y, 1), round(z, 1)))
    return sorted(result)


def test_a_crate_and_a_stone_are_floors_and_the_inside_of_the_crate_is_none() -> None:
    found = tops(*built(YARD, STONE, CRATE))
    assert len(found) == 2
    assert np.allclose(found, [(-2.0, -2.0, 1.2), (10.6, 0.6, 0.0)], atol=0.15)


def test_what_erosion_took_from_the_nav_mesh_is_no_floor() -> None:
    assert not tops(*built(YARD))


def test_what_faces_down_is_as_good_where_all_is_turned_over() -> None:
    top = slice(10, 12)
    where, own = built(YARD[top], STONE[top])
    turned = replace(where, collision=where.collision[:, ::-1])
    assert any(np.allclose(top, (10.6, 0.6, 0.0), atol=0.15) for top in tops(turned, own))


@pytest.mark.parametrize(("limit", "most"), [("MOST_CELLS", 1000), ("MOST_TRIANGLES", 20)])
def test_a_level_that_is_too_large_has_none(limit: str, most: int, monkeypatch: pytest.MonkeyPatch) -> None:
    where, own = built(YARD, STONE)
    monkeypatch.setattr(floors, limit, most)
    assert with_floors(where, own) is own
