"""A built nav-mesh against what the geometry says: slopes, steps, head room, a radius off walls, islands."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from reachtest.geometry import triangle_normals
from reachtest.levels import PRESETS
from reachtest.navmesh import build as build_module
from reachtest.navmesh.build import build_navmesh, turned_over
from reachtest.navmesh.contour import END_TOLERANCE
from reachtest.navmesh.islands import Islands, islands
from reachtest.navmesh.settings import settings_for
from reachtest.records import Floats, NavMesh
from reachtest.surface import SurfaceIndex
from tests.levels import box, slope

WHO = PRESETS["unreal"]  # radius 0.34 m, height 1.76 m, step 0.45 m, slope 44.765 degrees
CELL = WHO.radius_m / 2
GROUND = box([-6, -6, -1], [6, 6, 0])


def built(*pieces: Floats, **options: Any) -> NavMesh:
    return build_navmesh(np.concatenate(pieces), settings_for(WHO, **options))


def area(navmesh: NavMesh) -> float:
    return float(triangle_normals(navmesh.triangles)[1].sum())


def covers(navmesh: NavMesh, *points: list[float], within_m: float = 0.1) -> bool:
    """Whether every point has the surface near."""
    return bool((SurfaceIndex(navmesh.triangles, 1.0).distance(np.array(points, float)) <= within_m).all())


def misses(navmesh: NavMesh, point: list[float], by_m: float) -> bool:
    return bool(SurfaceIndex(navmesh.triangles, by_m).distance(np.array([point], float))[0] >= by_m)


def test_a_floor_is_covered_to_a_radius_off_its_edge() -> None:
    navmesh = built(GROUND)
    assert np.allclose(navmesh.vertices[:, 2], 0, atol=1e-5)
    reach = np.abs(navmesh.vertices[:, :2]).max()
    assert 6 - WHO.radius_m - 2 * CELL <= reach <= 6 - WHO.radius_m
    assert area(navmesh) == pytest.approx((2 * reach) ** 2, rel=0.05)
    assert len(navmesh.faces) <= 8, "a flat square needs few triangles"
    assert (triangle_normals(navmesh.triangles)[0][:, 2] > 0.99).all()
    assert (navmesh.format, navmesh.agent.radius_m, navmesh.agent.climb_m) == ("built", 0.34, 0.45)


@pytest.mark.parametrize("degrees", [10, 30, 43])
def test_a_slope_is_followed(degrees: float) -> None:
    navmesh = built(slope(degrees))
    x, z = navmesh.vertices[:, 0], navmesh.vertices[:, 2]
    assert np.abs(z - x * np.tan(np.radians(degrees))).max() < 0.075, "within a cell height"
    assert len(navmesh.faces) <= 40
    assert covers(navmesh, [5 * np.cos(np.radians(degrees)), 0, 5 * np.sin(np.radians(degrees))])


@pytest.mark.parametrize(("degrees", "walkable"), [(44.7, True), (44.8, False), (60, False)])
def test_the_slope_limit_is_the_characters(degrees: float, walkable: bool) -> None:
    assert (area(built(slope(degrees))) > 0) == walkable


@pytest.mark.parametrize(("height", "joined"), [(0.2, True), (0.45, True), (0.53, False), (1.0, False)])
def test_a_step_joins_what_the_climb_allows(height: float, joined: bool) -> None:
    navmesh = built(GROUND, box([0, -6, -1], [6, 6, height]))
    assert covers(navmesh, [-3, 0, 0], [3, 0, height])
    assert (islands(navmesh).max() == 0) == joined
    assert misses(navmesh, [0, 0, 0], WHO.radius_m) != joined, "a radius off the wall, and right up to a step"


@pytest.mark.parametrize(("room", "walkable"), [(1.7, False), (1.9, True)])
def test_head_room(room: float, walkable: bool) -> None:
    navmesh = built(GROUND, box([-4, -4, room], [4, 4, room + 0.5]))
    assert covers(navmesh, [0, 0, 0]) == walkable
    assert covers(navmesh, [0, 0, room + 0.5]), "the top of the roof is a floor of its own"
    assert covers(navmesh, [5, 0, 0])


def test_erosion_by_the_radius_off_walls() -> None:
    navmesh = built(GROUND, box([-0.2, -6, 0], [0.2, 3, 3]))
    lowest = navmesh.vertices[navmesh.vertices[:, 2] < 1]
    beside = lowest[lowest[:, 1] < 2.5]
    off = np.abs(beside[:, 0]).min() - 0.2
    assert WHO.radius_m <= off + 1e-6
    assert off <= WHO.radius_m + 2 * CELL
    assert islands(navmesh).max() == 0, "one walks around the end of the wall"


@pytest.mark.parametrize(("gap", "passes"), [(0.6, False), (1.2, True)])
def test_a_door_is_as_wide_as_the_character(gap: float, passes: bool) -> None:
    walls = box([-0.2, -6, 0], [0.2, -gap / 2, 5]), box([-0.2, gap / 2, 0], [0.2, 6, 5])
    ground = built(GROUND, *walls, box([-6, -6, 4], [6, 6, 5]))  # under a roof, so that no wall's top counts
    assert covers(ground, [0, 0, 0]) == passes
    floors = ground.triangles[:, :, 2].max(axis=1) < 1
    labels = islands(NavMesh("", ground.vertices, ground.faces[floors]))
    assert (labels.max() == 0) == passes


def test_tiny_islands_are_left_out() -> None:
    pedestal = box([-0.8, -0.8, 0], [0.8, 0.8, 3])
    assert misses(built(GROUND, pedestal), [0, 0, 3], 1.0)
    assert covers(built(GROUND, pedestal, min_island_m2=0), [0, 0, 3])
    assert covers(built(GROUND, box([-3, -3, 0], [3, 3, 3])), [0, 0, 3])


def test_stairs_lead_up() -> None:
    steps = [box([0.3 * k, -2, 0], [0.3 * (k + 1), 2, 0.2 * (k + 1)]) for k in range(12)]
    navmesh = built(GROUND, *steps, box([3.6, -2, 1.5], [6, 2, 2.4]))
    assert covers(navmesh, [-3, 0, 0], [5, 0, 2.4])
    assert islands(navmesh).max() == 0
    assert covers(navmesh, *([0.3 * k + 0.15, 0, 0.2 * (k + 1)] for k in range(12)))


def test_floors_over_each_other_are_told_apart() -> None:
    navmesh = built(GROUND, box([-6, -2, 3], [6, 2, 3.2]))
    assert covers(navmesh, [0, 0, 0], [0, 0, 3.2])
    assert misses(navmesh, [0, 0, 1.6], 1.0)
    assert islands(navmesh).max() == 1


def test_the_walls_of_a_thin_triangle_soup_leave_no_hole_far_away() -> None:
    """A wall that lies in a border of cells belongs to the columns on both sides, and to no other."""
    walls = [[[k * CELL, 0, 0], [k * CELL, 0.3, 0], [k * CELL, 0.3, 2]] for k in range(-20, 21, 4)]
    navmesh = built(GROUND, np.array(walls, dtype=float))
    assert covers(navmesh, *([x, y, 0] for x in (-5, 0, 5) for y in (-4, -1, 2, 5)))


@pytest.mark.parametrize("offset", [(5000, -3000, 200), (0.03, 0.07, 0.01)])
def test_where_the_level_lies_does_not_matter(offset: tuple[float, float, float]) -> None:
    pieces = np.concatenate([GROUND, box([0, -6, -1], [6, 6, 0.3])])
    here, there = built(pieces), built(pieces + np.array(offset))
    assert area(there) == pytest.approx(area(here), rel=0.03)
    assert covers(there, *(np.array([[-3, 0, 0], [3, 0, 0.3]]) + offset))


def test_blocks_fit_together(monkeypatch: pytest.MonkeyPatch) -> None:
    pieces = [GROUND, box([-0.2, -6, 0], [0.2, 3, 3]), slope(20, 5, 3, 1), box([-5, -5, 0], [-3.4, -3.4, 2])]
    whole = built(*pieces, cell_m=0.1)
    monkeypatch.setattr(build_module, "BLOCK", 32)
    parts = built(*pieces, cell_m=0.1)
    assert area(parts) == pytest.approx(area(whole), rel=0.01)
    assert islands(parts).max() == islands(whole).max()
    middle = parts.triangles.mean(axis=1)
    assert covers(whole, *middle.tolist(), within_m=0.15)


def test_faces_turned_inside_out() -> None:
    sheet = np.array([[[-5, -5, 0], [5, 5, 0], [5, -5, 0]], [[-5, -5, 0], [-5, 5, 0], [5, 5, 0]]], float)
    assert turned_over(sheet, 45)
    assert not turned_over(GROUND, 45)
    assert len(built(sheet).faces) == 0
    assert area(built(sheet, both_sides=True)) > 70


def test_nothing_to_walk_on() -> None:
    assert len(build_navmesh(np.zeros((0, 3, 3)), settings_for(WHO)).faces) == 0
    assert len(built(box([0, 0, 0], [0.3, 0.3, 5])).faces) == 0


def test_cells_too_small_for_the_level() -> None:
    with pytest.raises(ValueError, match="too many"):
        built(box([0, 0, 0], [100_000, 100_000, 1]), cell_m=0.01)


def test_defaults_follow_the_character() -> None:
    numbers = settings_for(WHO)
    assert (numbers.cell_m, numbers.radius_m, numbers.height_m) == (0.17, 0.34, 1.76)
    assert (numbers.agent.radius, numbers.agent.climb) == (2, 6)
    assert numbers.agent.climb * numbers.cell_height_m == pytest.approx(WHO.step_height_m)
    assert settings_for(WHO, radius_m=0.5).cell_m == 0.25
    assert settings_for(WHO, climb_m=0).agent.climb == 0


LENGTHS = st.floats(0.2, 3)
BOXES = st.lists(
    st.tuples(st.floats(-5, 5), st.floats(-5, 5), LENGTHS, LENGTHS, LENGTHS, st.floats(0, 40)), max_size=6
)


# A column that a floor only touches counts whole, corner to corner, and a patch's side along x may lie beyond it.
FARTHEST = float(np.hypot(1 + END_TOLERANCE, 1) * CELL + settings_for(WHO).cell_height_m)


@settings(max_examples=25, deadline=None)
@given(BOXES)
def test_every_vertex_lies_near_a_floor_the_same_every_time(boxes: list[tuple[float, ...]]) -> None:
    pieces = [GROUND]
    for x, y, width, depth, height, degrees in boxes:
        turn = np.radians(degrees)
        matrix = np.array([[np.cos(turn), np.sin(turn), 0], [-np.sin(turn), np.cos(turn), 0], [0, 0, 1]])
        pieces.append(box([-width, -depth, 0], [width, depth, height]) @ matrix + [x, y, 0])
    navmesh = built(*pieces)
    everything = np.concatenate(pieces)
    floors = everything[triangle_normals(everything)[0][:, 2] > 0.9]
    if len(navmesh.faces):
        near = SurfaceIndex(floors, 2.0).distance(navmesh.vertices)
        assert near.max() <= FARTHEST
    again = built(*pieces)
    assert np.array_equal(again.vertices, navmesh.vertices)
    assert np.array_equal(again.faces, navmesh.faces)


@pytest.mark.parametrize("who", ["unreal", "unity", "godot", "quake3"])
@pytest.mark.parametrize("degrees", [10.0, 30.0, 43.0])
@pytest.mark.parametrize("turned", [0.0, 30.0])
def test_a_ramp_joins_two_storeys_for_every_character(who: str, degrees: float, turned: float) -> None:
    """Also where a slope rises more from cell to cell than the character steps: Godot's does not step at all."""
    run, rise = 3.0 * np.cos(np.radians(degrees)), 3.0 * np.sin(np.radians(degrees))
    ramp = np.array([[0, -4, 0], [run, -4, rise], [run, 4, rise], [0, 4, 0]])[[[0, 1, 2], [0, 2, 3]]]
    pieces = np.concatenate([box([-6, -4, -1], [0, 4, 0]), ramp, box([run, -4, -1], [run + 6, 4, rise])])
    c, s = np.cos(np.radians(turned)), np.sin(np.radians(turned))
    turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    navmesh = build_navmesh(pieces @ turn.T, settings_for(PRESETS[who]))
    assert covers(navmesh, [-3, 0, 0] @ turn.T, [run / 2, 0, rise / 2] @ turn.T, [run + 3, 0, rise] @ turn.T)
    assert islands(navmesh).max() == 0


@pytest.mark.parametrize(("who", "joined"), [("unity", True), ("godot", False)])
@pytest.mark.parametrize("x", [0.0, 0.07, 0.13, 0.19])
def test_a_kerb_is_no_slope(who: str, joined: bool, x: float) -> None:
    """0.2 m: Unity's character steps up 0.3 m, Godot's round bottom 0.15 m. Wherever cells begin."""
    pieces = np.concatenate([GROUND, box([x, -6, -1], [6, 6, 0.2])])
    navmesh = build_navmesh(pieces, settings_for(PRESETS[who]))
    assert covers(navmesh, [-3, 0, 0], [3, 0, 0.2])
    assert misses(navmesh, [x, 0, 0.1], PRESETS[who].radius_m) != joined


@pytest.mark.parametrize(
    ("who", "slope_deg", "drop"), [("unity", 80, 0.6), ("unity", 89, 7), ("unreal", 89, 4)]
)
@pytest.mark.parametrize("x", [0.0, 0.07, 0.13])
def test_a_cliff_is_no_slope_however_steep_slopes_may_be(
    who: str, slope_deg: float, drop: float, x: float
) -> None:
    pieces = np.concatenate([box([-6, -6, -9], [6, 6, -drop]), box([x, -6, -9], [6, 6, 0])])
    navmesh = build_navmesh(pieces, settings_for(PRESETS[who], slope_deg=slope_deg))
    assert covers(navmesh, [-3, 0, -drop], [3, 0, 0])
    assert misses(navmesh, [x, 0, 0], PRESETS[who].radius_m)
    assert misses(navmesh, [x, 0, -drop], PRESETS[who].radius_m)


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("degrees", [30.0, 40.0, 44.0])
def test_ridges_and_valleys_hold_together_wherever_cells_begin(degrees: float, sign: float) -> None:
    """Godot's character steps up nothing: only the slopes themselves say that they meet."""
    rise = 4.0 * np.tan(np.radians(degrees)) * sign
    left = np.array([[-4, -4, 0], [0, -4, rise], [0, 4, rise], [-4, 4, 0]])[[[0, 1, 2], [0, 2, 3]]]
    right = (left * [-1, 1, 1])[:, ::-1]
    for offset in np.linspace(0.0, 0.25, 10, endpoint=False):
        flat = box([-9 - offset, -4, -1], [-4, 4, 0])  # the grid begins at its edge
        navmesh = build_navmesh(np.concatenate([flat, left, right]), settings_for(PRESETS["godot"]))
        on = Islands(navmesh).of(np.array([[-2, 0, rise / 2], [2, 0, rise / 2]]))
        assert on[0] == on[1] >= 0, f"apart with cells that begin {offset} m farther"


@pytest.mark.parametrize("who", ["unreal", "unity", "quake3"])
@pytest.mark.parametrize("turned", [0.0, 33.0])
def test_stairs_of_the_highest_step_lead_up(who: str, turned: float) -> None:
    """As steep as a slope may be, and as coarse as cells are."""
    step = PRESETS[who].step_height_m
    treads = [box([step * 1.1 * k, -4, -1], [step * 1.1 * (k + 1), 4, step * (k + 1)]) for k in range(5)]
    upper = box([step * 5.5, -4, -1], [step * 5.5 + 5, 4, step * 5])
    c, s = np.cos(np.radians(turned)), np.sin(np.radians(turned))
    turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    pieces = np.concatenate([box([-6, -4, -1], [0, 4, 0]), *treads, upper]) @ turn.T + [103.7, -51.3, 0.0137]
    navmesh = build_navmesh(pieces, settings_for(PRESETS[who]))
    ends = np.array([[-3, 0, 0], [step * 5.5 + 2, 0, step * 5]]) @ turn.T + [103.7, -51.3, 0.0137]
    assert covers(navmesh, *ends.tolist())
    on = Islands(navmesh).of(ends)
    assert on[0] == on[1] >= 0
