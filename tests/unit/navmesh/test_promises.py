"""What a nav-mesh promises in vain: each kind of impossible place, and what is none."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from reachtest.levels import load_level
from reachtest.navmesh.explained import explained_goals, without_visited
from reachtest.navmesh.islands import islands
from reachtest.navmesh.promises import LOW, NARROW, STEEP, agent_differences, check_promises
from reachtest.records import NavAgent
from tests.levels import FLOOR, UNREAL, box, slope
from tests.unit.navmesh.make import REAL, SHARED, navmesh, rectangle

HALL = rectangle((0, -2), (20, 2))


def promises(mesh, *pieces, character=UNREAL):
    return check_promises(mesh, islands(mesh), np.concatenate(pieces), character)


def stairs(rise: float, count: int = 4, tread: float = 1.0):
    """Boxes that rise along +x from x = 5."""
    return np.concatenate(
        [box([5 + tread * i, -2, -0.5], [5 + tread * (i + 1), 2, rise * (i + 1)]) for i in range(count)]
    )


RIM = [  # a floor around a hole of 1 m by 2 m
    box([-10, -10, -2.0], [9, 10, 0]),
    box([10, -10, -2.0], [30, 10, 0]),
    box([9, -10, -2.0], [10, -1, 0]),
    box([9, 1, -2.0], [10, 10, 0]),
]


def test_an_open_floor_keeps_its_promises() -> None:
    found = promises(navmesh(HALL), FLOOR)
    assert len(found.samples.positions) > 1000
    assert not found.reason.any()
    assert not len(found.steps)


def test_too_low() -> None:
    beam = box([9, -2, 1.5], [12, 2, 1.8])
    found = promises(navmesh(HALL), FLOOR, beam)
    bad = found.samples.positions[found.reason == LOW]
    assert bad[:, 0].min() == pytest.approx(9.0, abs=0.35)
    assert bad[:, 0].max() == pytest.approx(12.0, abs=0.35)
    assert np.nanmin(found.value) == pytest.approx(1.5)
    assert set(found.reason.tolist()) == {0, LOW}
    low_enough = replace(UNREAL, height_m=1.4)
    assert not promises(navmesh(HALL), FLOOR, beam, character=low_enough).reason.any()


@pytest.mark.parametrize(("width", "possible"), [(0.5, False), (0.62, False), (0.72, True), (1.0, True)])
def test_too_narrow(width: float, possible: bool) -> None:
    walls = [box([5, side * width / 2 - 0.1, 0], [10, side * width / 2 + 0.1, 3]) for side in (-1.0, 1.0)]
    walls = [wall + [0, side * 0.1, 0] for wall, side in zip(walls, (-1.0, 1.0), strict=True)]
    # The nav-mesh of a thinner agent: it comes near to the walls and stays between them.
    lane = rectangle((0, -width / 2 + 0.1), (20, width / 2 - 0.1))
    found = promises(navmesh(lane), FLOOR, *walls)
    assert (set(found.reason.tolist()) == {0}) is possible
    if not possible:
        assert set(found.reason.tolist()) == {0, NARROW}
        assert np.nanmin(found.value) == pytest.approx(width, abs=0.1)


@pytest.mark.parametrize(("degrees", "possible"), [(40, True), (44.7, True), (50, False)])
def test_too_steep(degrees: float, possible: bool) -> None:
    ramp = slope(degrees)
    found = promises(navmesh(ramp * [1, 0.9, 1]), ramp)
    assert (not found.reason.any()) is possible
    if not possible:
        assert set(found.reason.tolist()) == {STEEP}
        assert np.nanmax(found.value) == pytest.approx(degrees)


@pytest.mark.parametrize(("rise", "possible"), [(0.3, True), (0.45, True), (0.5, False)])
def test_steps_that_the_surface_leads_over(rise: float, possible: bool) -> None:
    over = rectangle((4, -1.5), (9, 1.5), rise=4 * rise)
    found = promises(navmesh(over), FLOOR, stairs(rise))
    assert (not len(found.steps)) is possible
    if not possible:
        assert found.rise_m == pytest.approx(rise, abs=1e-6)
        floor = found.samples.positions[found.steps]
        assert (floor[:, 0, 0] <= floor[:, 1, 0]).all()  # from the lower to the upper side
    assert not found.reason.any()


@pytest.mark.parametrize("rise", [0.8, 1.4])
def test_blocks_that_the_surface_runs_over_as_a_ramp(rise: float) -> None:
    """A nav-mesh with a coarse agent whose climb its file does not tell: how far it hangs does."""
    over = rectangle((3, -1.5), (11, 1.5), rise=4 * rise)
    top = rectangle((11, -1.5), (13, 1.5)) + [0, 0, 4 * rise]
    found = promises(navmesh(rectangle((0, -1.5), (3, 1.5)), over, top), FLOOR, stairs(rise, tread=2.0))
    assert found.rise_m == pytest.approx(rise, abs=1e-6)
    assert len(set(np.round(found.samples.positions[found.steps[:, 1], 0]))) >= 4  # every block
    goals = np.array([[2.0, 1, 0], [9.5, 0, 3.2 * rise], [12.0, 0, 4 * rise]])
    beyond = rise > 0.9
    assert explained_goals(found, np.array([[1.0, 0, 0]]), goals, 1.0, 0.9).tolist() == [
        False,
        beyond,
        beyond,
    ]


def test_a_pit_under_a_level_surface_is_no_step() -> None:
    deep = [*RIM, box([9, -1, -2.0], [10, 1, -1.5])]
    assert not len(promises(navmesh(rectangle((0, -8), (20, 8))), *deep).steps)


def test_steps_that_cut_the_surface_into_islands() -> None:
    treads = [rectangle((5.34 + i, -1.5), (5.66 + i, 1.5), z=0.5 * (i + 1)) for i in range(4)]
    found = promises(navmesh(rectangle((0, -1.5), (4.66, 1.5)), *treads), FLOOR, stairs(0.5))
    assert not len(found.steps)
    assert found.cut_rise_m == pytest.approx(0.5)
    assert len(np.unique(found.samples.face[found.cuts] // 2, axis=0)) == 4
    high = [tread + [0, 0, 0.5 * (i + 1)] for i, tread in enumerate(treads)]
    ledges = promises(navmesh(rectangle((0, -1.5), (4.66, 1.5)), *high), FLOOR, stairs(1.0))
    assert not len(ledges.cuts)  # a metre is a ledge, not a step


@pytest.mark.skipif(not SHARED.exists(), reason="the real levels are not here")
@pytest.mark.parametrize(
    ("name", "cut_m"), [("oa_dm1", 0.5), ("aggressor", 0.5), ("dungeon", None), ("nav_test", None)]
)
def test_nav_meshes_built_for_the_character_promise_nothing_impossible(name, cut_m) -> None:
    level = load_level(REAL / name / "level.yaml")
    found = promises(level.navmesh, level.collision)
    assert not found.reason.any()
    assert not len(found.steps)
    if cut_m is not None:  # the stairs of both are steps of half a metre, their character's step is 0.45 m
        assert np.median(found.cut_rise_m) == pytest.approx(cut_m, abs=0.01)


# --- agents -----------------------------------------------------------------------------------------------


def test_only_an_agent_that_gets_to_more_places_is_a_difference() -> None:
    assert agent_differences(NavAgent(), UNREAL) == ()
    stock = NavAgent(radius_m=0.34, height_m=1.44, climb_m=0.35, slope_deg=44.0)
    (line,) = agent_differences(stock, UNREAL)
    assert "1.44 m" in line
    assert "1.76 m" in line
    everything = NavAgent(radius_m=0.2, height_m=1.0, climb_m=0.9, slope_deg=60.0)
    assert [line.split(":")[0] for line in agent_differences(everything, UNREAL)] == [
        "height",
        "radius",
        "climb",
        "slope",
    ]


# --- what they explain ------------------------------------------------------------------------------------

BEAM = box([9, -4, 1.5], [12, 4, 1.8])
HERE = np.array([[1.0, 0, 0], [7, 0, 0]])
GOALS = np.array([[3.0, 1, 0], [10.5, 0, 0], [18.0, 1, 0], [40.0, 0, 0]])


def explained(found, stood) -> list[bool]:
    return explained_goals(found, stood, GOALS, 1.0, 0.9).tolist()


def test_goals_on_and_behind_an_impossible_place_are_explained_and_no_others() -> None:
    mesh = navmesh(HALL, rectangle((38, -2), (42, 2)))
    assert explained(promises(mesh, FLOOR, BEAM), HERE) == [False, True, True, False]
    assert explained(promises(mesh, FLOOR), HERE) == [False] * 4


@pytest.mark.parametrize("thick", [0.2, 0.5, 1.0, 3.0])
@pytest.mark.parametrize("high", [0.8, 1.5, 4.0])
def test_what_stands_in_the_way_is_no_mismatch(thick: float, high: float) -> None:
    """A wall or a crate across the only way: what lies behind is unreached, and has to be told as such."""
    found = promises(navmesh(HALL), FLOOR, box([9, -4, 0], [9 + thick, 4, high]))
    assert not found.reason.any()
    assert explained(found, HERE) == [False] * 4


def test_a_way_around_leaves_nothing_behind_unexplained() -> None:
    half = box([9, -4, 1.5], [12, 1.6, 1.8])
    assert explained(promises(navmesh(HALL), FLOOR, half), HERE) == [False, True, False, False]


def test_who_got_behind_otherwise_starts_from_there() -> None:
    behind = np.concatenate([HERE, [[19.0, 0, 0]]])
    assert explained(promises(navmesh(HALL), FLOOR, BEAM), behind) == [False, True, False, False]


def test_where_somebody_stood_is_possible() -> None:
    found = promises(navmesh(HALL), FLOOR, BEAM)
    through = np.stack([np.arange(8.0, 13.0, 0.3), np.zeros(17), np.zeros(17)], axis=1)
    calmed = without_visited(found, through, UNREAL.radius_m)
    assert (calmed.reason > 0).sum() < (found.reason > 0).sum()
    assert explained(calmed, HERE) == [False, False, False, False]


def test_a_step_bars_the_way_up_only_where_nobody_jumps_it() -> None:
    over = rectangle((4, -1.5), (9, 1.5), rise=2.0)
    found = promises(navmesh(rectangle((0, -1.5), (4, 1.5)), over), FLOOR, stairs(0.5))
    top = np.array([[8.6, 0, 2.0]])
    assert explained_goals(found, HERE[:1], top, 1.0, 0.45).tolist() == [True]
    assert explained_goals(found, HERE[:1], top, 1.0, 0.9).tolist() == [False]
    bottom = np.array([[1.0, 0, 0.0]])
    assert explained_goals(found, top, bottom, 1.0, 0.45).tolist() == [False]  # down it goes
