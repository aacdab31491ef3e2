"""Islands: what belongs together though it shares no vertex, what does not, and what links connect."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from reachtest.levels import load_level
from reachtest.navmesh.coverage import goal_islands
from reachtest.navmesh.islands import Islands, islands
from reachtest.records import NavAgent
from tests.unit.navmesh.make import REAL, SHARED, link, navmesh, rectangle

ROOM = rectangle((0, 0), (4, 4))


def count(*pieces, climb_m=None, **changes) -> int:
    return len(set(islands(navmesh(*pieces, **changes), climb_m).tolist()))


@pytest.mark.parametrize(
    ("other", "together"),
    [
        (rectangle((4, 0), (8, 4)), True),  # a shared border, vertices of their own
        (rectangle((4, 1), (8, 2.5)), True),  # a T-junction on both sides
        (rectangle((4.03, 0), (8, 4)), True),  # a gap as float32 and tile borders leave it
        (rectangle((4, 0), (8, 4), z=0.4), True),  # a step
        (rectangle((4.03, 1), (8, 2), z=0.2, rise=2.0), True),  # the foot of a ramp
        (rectangle((1, 1), (8, 2), z=0.02, rise=4.0), True),  # a ramp laid onto the floor
        (rectangle((4.68, 0), (8, 4)), False),  # two rooms with a thin wall between, after erosion
        (rectangle((4, 0), (8, 4), z=0.9), False),  # a ledge
        (rectangle((4, 4), (8, 8)), False),  # touches at a corner
        (rectangle((4, 3.98), (8, 8)), False),  # by two centimetres of a corner
        (rectangle((0, 0), (4, 4), z=3.0), False),  # the storey above
    ],
)
def test_what_lies_against_a_room_belongs_to_it(other, together: bool) -> None:
    assert count(ROOM, other) == (1 if together else 2)


def test_the_climb_of_the_agent_decides_what_is_a_step() -> None:
    pieces = ROOM, rectangle((4, 0), (8, 4), z=0.8)
    assert count(*pieces) == 2
    assert count(*pieces, agent=NavAgent(climb_m=0.9)) == 1
    assert count(*pieces, agent=NavAgent(climb_m=0.9), climb_m=0.5) == 2


def test_tiles_with_borders_cut_differently_are_one_island() -> None:
    rng = np.random.default_rng(1)
    tiles = []
    for i in range(4):
        cuts = np.concatenate([[0.0], np.sort(rng.uniform(0.5, 19.5, 6)), [20.0]])
        tiles += [rectangle((5 * i, a), (5 * i + 5, b)) for a, b in itertools.pairwise(cuts)]
    assert count(*tiles) == 1


def test_islands_are_numbered_by_their_first_faces() -> None:
    far = rectangle((20, 0), (24, 4))
    labels = islands(navmesh(ROOM, far, rectangle((4, 0), (8, 4))))
    assert labels.tolist() == [0, 0, 1, 1, 0, 0]


@given(st.integers(0, 2**32 - 1), st.floats(0, 6.3))
def test_neither_the_order_of_faces_nor_the_direction_matters(seed: int, angle: float) -> None:
    rng = np.random.default_rng(seed)
    spots = rng.integers(0, 5, (8, 2)) * 4.0
    triangles = np.concatenate([rectangle(spot, spot + 4, z=rng.choice([0.0, 0.4, 3.0])) for spot in spots])
    order = rng.permutation(len(triangles))
    turn = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0.0, 0.0, 1.0]])
    one = islands(navmesh(triangles))[order]
    other = islands(navmesh(triangles[order] @ turn.T))
    assert (one[:, None] == one).tolist() == (other[:, None] == other).tolist()


# --- links ------------------------------------------------------------------------------------------------

ROOF, CELLAR = rectangle((10, 0), (14, 4), z=5.0), rectangle((20, 0), (24, 4), z=-5.0)


@pytest.mark.parametrize(
    ("links", "reached"),
    [
        ((), [True, False, False]),
        ((link((3, 2, 0), (11, 2, 5)),), [True, True, False]),
        ((link((11, 2, 5), (3, 2, 0)),), [True, False, False]),  # the wrong way
        ((link((11, 2, 5), (3, 2, 0), both_ways=True),), [True, True, False]),
        (
            (link((3, 2, 0), (11, 2, 5)), link((13, 2, 5), (21, 2, -5))),
            [True, True, True],
        ),  # by way of the roof
        ((link((11, 2, 5), (3, 2, 0)), link((13, 2, 5), (21, 2, -5))), [True, False, False]),
        ((link((3, 2, 0), (11, 2, 30)),), [True, False, False]),  # ends at no surface
    ],
)
def test_links_connect_islands_in_their_direction(links, reached: list[bool]) -> None:
    mesh = navmesh(ROOM, ROOF, CELLAR, links=links)
    assert Islands(mesh).connected_to(np.array([[1.0, 1, 0]])).tolist() == reached


def test_the_end_of_a_link_may_lie_beside_the_surface() -> None:
    mesh = navmesh(ROOM, ROOF, links=[link((4.3, 2, 0.2), (9.8, 2, 5))])
    assert Islands(mesh).connected_to(np.array([[1.0, 1, 0]])).all()


def test_a_spawn_stands_on_what_is_straight_below_it() -> None:
    mesh = navmesh(rectangle((0, 0), (4, 4)), rectangle((0, 0), (4, 4), z=2.5))
    points = np.array([[1, 1, 0.02], [1, 1, 1.5], [1, 1, 4.5], [4.4, 1, 0.1], [9, 9, 0]])
    assert Islands(mesh).of(points).tolist() == [0, 0, 1, 0, -1]


def test_without_a_spawn_on_the_nav_mesh_nothing_is_called_unconnected() -> None:
    found = goal_islands(
        Islands(navmesh(ROOM, ROOF)), np.array([[50.0, 50, 0]]), np.array([[1.0, 1, 0], [11, 1, 5]])
    )
    assert found.connected.all()
    assert found.goals_count.all()


# --- real nav-meshes --------------------------------------------------------------------------------------


@pytest.mark.skipif(not SHARED.exists(), reason="the real levels are not here")
@pytest.mark.parametrize(
    ("name", "spawned", "area_m2"),
    [("oa_dm1", 2, 1521), ("aggressor", 3, 920), ("dungeon", 1, 1647), ("nav_test", 1, 1887)],
)
def test_roofs_and_shells_of_real_levels_are_islands_of_their_own(name, spawned, area_m2) -> None:
    level = load_level(REAL / name / "level.yaml")
    found = goal_islands(
        Islands(level.navmesh), np.array([s.position for s in level.spawns]), np.empty((0, 3))
    )
    assert found.connected.sum() == spawned
    assert found.area_m2[found.connected].sum() == pytest.approx(area_m2, abs=1)
