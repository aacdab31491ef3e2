"""Floors off the nav-mesh that leaps are aimed at: what they are, and what is none."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from reachtest.explore.directed import floors
from reachtest.explore.directed.floors import floors_off
from reachtest.explore.directed.footholds import Footholds
from reachtest.explore.directed.gaps import places_to_push
from reachtest.explore.directed.places import NOWHERE
from reachtest.levels import PRESETS
from reachtest.navmesh.build import build_navmesh
from reachtest.navmesh.islands import Islands
from reachtest.navmesh.settings import settings_for
from reachtest.records import Floats, Level, NavMesh
from tests.levels import UNREAL, box, level

YARD = box([-8, -8, -1], [8, 8, 0])
STONE = box([10, 0, -1], [11.2, 1.2, 0])  # too small for the nav-mesh
SHED = box([-4, -4, 0], [-1, -1, 2.6])  # higher than anybody is tall
POST = box([10, 5, -1], [10.35, 5.35, 0])
TOP = slice(10, 12)  # the faces of a box that face up


def built(*pieces: Floats, who: str = "unreal", walked: Sequence[Floats] = (YARD,)) -> tuple[Level, Islands]:
    """The level of all pieces, and the nav-mesh of those that are `walked`."""
    where = level(*pieces, character=PRESETS[who])
    navmesh = build_navmesh(np.concatenate(walked), settings_for(where.character))
    return replace(where, navmesh=navmesh), Islands(navmesh)


def tops(where: Level, own: Islands) -> Floats:
    """The middle of each floor [I, 3]."""
    found = floors_off(where, own)
    corners = [found.navmesh.triangles[found.labels == one].reshape(-1, 3) for one in range(found.count)]
    return np.array([(some.min(axis=0) + some.max(axis=0)) / 2 for some in corners]).reshape(-1, 3)


def test_the_top_of_a_shed_and_a_stone_are_floors_and_the_inside_of_the_shed_is_none() -> None:
    around = box([-8, -8, -1], [-4.5, 8, 0]), box([-0.5, -8, -1], [8, 8, 0])
    found = tops(*built(YARD, STONE, SHED, walked=around))
    for top in (-2.5, -2.5, 2.6), (10.6, 0.6, 0.0):
        assert np.isclose(found, top, atol=0.15).all(axis=1).sum() == 1
    assert not (np.abs(found - [-2.5, -2.5, 0.0]) < 1.5).all(axis=1).any()


def test_what_is_no_wider_than_a_foot_is_no_floor() -> None:
    assert len(tops(*built(YARD, STONE, POST))) == 1


@pytest.mark.parametrize("who", PRESETS)
@pytest.mark.parametrize("walked", [YARD, box([-8, -8, -1], [2, 8, 0]), box([-6, -6, -1], [-2, -2, 0])])
def test_the_nav_mesh_keeps_its_border_and_who_stands_on_it(who: str, walked: Floats) -> None:
    """Its floor goes on where it ends, in corners and all around, and is a larger patch than it is."""
    where, own = built(YARD, STONE, who=who, walked=[walked])
    found = floors_off(where, own)
    assert (found.count == 1) == (walked is YARD)  # the stone; else the rest of the yard, too
    connected = np.ones(own.count, dtype=np.bool_)
    without, _ = places_to_push(own, connected, where.character)
    along, _ = places_to_push(own, connected, where.character, found)
    np.testing.assert_array_equal(along.positions, without.positions)


def test_a_beam_that_leads_away_from_the_nav_mesh_is_off_it() -> None:
    beam = box([8, 3, -1], [16, 3.9, 0])  # too narrow for the nav-mesh, and one walks onto it
    where, own = built(YARD, beam)
    assert np.allclose(tops(where, own), [(12.0, 3.45, 0.0)], atol=1.0)
    footholds = Footholds(own, np.ones(own.count, dtype=np.bool_), np.zeros(1, int), floors_off(where, own))
    footholds.note(np.array([[7.4, 3.4, 0.0], [14, 3.4, 0.0]]), np.ones(2, dtype=np.bool_))
    assert footholds.island.tolist() == [0, own.count]


def test_who_stands_on_a_floor_is_told_from_who_stands_on_the_nav_mesh() -> None:
    where, own = built(YARD, STONE)
    footholds = Footholds(own, np.ones(own.count, dtype=np.bool_), np.zeros(1, int), floors_off(where, own))
    footholds.note(np.array([[0, 0, 0.0], [10.6, 0.6, 0.0], [40, 0, 0]]), np.ones(3, dtype=np.bool_))
    assert footholds.island.tolist() == [0, own.count, NOWHERE]
    assert footholds.stood.tolist() == [True] * (own.count + 1)


def test_what_faces_down_is_as_good_where_all_is_turned_over() -> None:
    where, own = built(YARD[TOP], STONE[TOP])
    turned = replace(where, collision=where.collision[:, ::-1])
    assert np.allclose(tops(turned, own), [(10.6, 0.6, 0.0)], atol=0.15)


@pytest.mark.parametrize(("limit", "most"), [("MOST_CELLS", 1000), ("MOST_TRIANGLES", 20)])
def test_a_level_that_is_too_large_has_none(limit: str, most: int, monkeypatch: pytest.MonkeyPatch) -> None:
    where, own = built(YARD, STONE)
    assert floors_off(where, own).count == 1
    monkeypatch.setattr(floors, limit, most)
    assert not floors_off(where, own).count


def test_a_level_that_is_too_high_has_none() -> None:
    where, own = built(YARD, STONE, box([0, 0, 3e6], [1, 1, 3e6 + 1]))
    assert not floors_off(where, own).count


def test_without_a_nav_mesh_there_is_nothing_off_it() -> None:
    where, _ = built(YARD, STONE)
    nothing = NavMesh(
        "nav.obj", np.empty((0, 3)), np.empty((0, 3), dtype=np.int64), agent=where.navmesh.agent
    )
    assert not floors_off(replace(where, navmesh=nothing), Islands(nothing)).count


def test_a_floor_smaller_than_a_step_is_landed_on_in_its_middle() -> None:
    where, own = built(YARD, STONE)
    _, gaps = places_to_push(own, np.ones(own.count, dtype=np.bool_), UNREAL, floors_off(where, own))
    landings = np.concatenate(gaps.landings)[:, :2]
    assert (np.abs(landings - [10.6, 0.6]) < 0.6).all()
