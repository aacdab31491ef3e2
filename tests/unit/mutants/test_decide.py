"""What counts as a mutant is decided by geometry: hand-made levels whose answer is plain."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from reachtest.mutants.boxes import Box, cut_out
from reachtest.mutants.decide import Change, cut_off, opened
from reachtest.mutants.ground import Ground, survey_ground
from reachtest.records import Floats, Level, Solid
from tests.levels import box, level

SIDE = 6.0
SLAB = box([-SIDE, -SIDE, -0.5], [SIDE, SIDE, 0])
NAV = np.array(
    [
        [[-SIDE, -SIDE, 0], [SIDE, -SIDE, 0], [SIDE, SIDE, 0]],
        [[-SIDE, -SIDE, 0], [SIDE, SIDE, 0], [-SIDE, SIDE, 0]],
    ]
)
GOALS = np.array([[-4.0, 0, 0], [4.0, 0, 0]])
APEX_M = 0.9  # of the preset: 4.2 m/s at 9.8 m/s2


def walls(height: float, thick: float = 0.4) -> tuple[Floats, ...]:
    near, far = SIDE - thick, SIDE
    return (
        box([-SIDE, near, -0.5], [SIDE, far, height]),
        box([-SIDE, -far, -0.5], [SIDE, -near, height]),
        box([near, -SIDE, -0.5], [far, SIDE, height]),
        box([-far, -SIDE, -0.5], [-near, SIDE, height]),
    )


def yard(*more: Floats, height: float = 3.0) -> Level:
    return level(SLAB, *walls(height), *more, kill_z_m=-20.0, navmesh=NAV)


def survey(one: Level) -> Ground:
    return survey_ground(one, GOALS)


def without(one: Level, hole: Box, *more: Floats) -> Level:
    return dataclasses.replace(one, collision=np.concatenate([cut_out(one.collision, hole), *more]))


def upright(x: float, y: float, z: tuple[float, float], half: float | tuple[float, float]) -> Box:
    sides = half if isinstance(half, tuple) else (half, half)
    return Box(np.array([x, y, sum(z) / 2]), np.array([*sides, (z[1] - z[0]) / 2]))


def opens(one: Level, hole: Box, *more: Floats) -> Change:
    return opened(survey(one), without(one, hole, *more), hole)


def test_a_closed_yard_has_no_way_out_and_an_open_one_has() -> None:
    closed, open_ = survey(yard()), survey(level(SLAB, kill_z_m=-20.0, navmesh=NAV))
    assert not (closed.possible & closed.moves.falls).any()
    assert (open_.sure & open_.moves.falls).any()


def test_a_hole_over_nothing_counts() -> None:
    assert opens(yard(), upright(2, 2, (-0.6, 0.2), 0.8)).reasons == ("fell",)


def test_a_hole_over_solid_ground_does_not() -> None:
    ground = box([-SIDE, -SIDE, -2], [SIDE, SIDE, -0.5])
    assert opens(yard(ground), upright(2, 2, (-0.4, 0.2), 0.8)).reasons == ()


def test_a_hole_that_the_character_does_not_fit_through_does_not() -> None:
    assert opens(yard(), upright(2, 2, (-0.6, 0.2), 0.25)).reasons == ()


def test_a_gap_in_a_wall_counts_and_a_dent_does_not() -> None:
    assert "fell" in opens(yard(), upright(5.8, 1, (0.02, 2.5), (0.5, 0.9))).reasons
    assert opens(yard(), upright(5.6, 1, (0.02, 2.5), (0.2, 0.9)), box([5.75, 0, 0], [6, 2, 3])).reasons == ()


@pytest.mark.parametrize(("height", "counts"), [(0.5 * APEX_M, True), (2.0, False)])
def test_a_wall_counts_once_it_is_low_enough_to_jump(height: float, counts: bool) -> None:
    cut = upright(5.8, 1, (height, 3.5), (0.5, 1.3))
    lid = box([5.6, -0.3, height - 0.05], [6.0, 2.3, height])
    assert bool(opens(yard(), cut, lid).reasons) == counts


@pytest.mark.parametrize(("depth", "reasons"), [(2.6, ("trap",)), (0.8, ())])
def test_a_pit_counts_if_it_is_too_deep_to_jump_out_of(depth: float, reasons: tuple[str, ...]) -> None:
    cut, sides = upright(2, 2, (-depth, 0.2), 1.2), upright(2, 2, (-depth, 0), 1.2)
    names = ("back", "front", "right", "left", "bottom")
    assert opens(yard(), cut, sides.faces(names, inwards=True)).reasons == reasons


def test_a_place_that_nobody_gets_to_never_counts() -> None:
    attic = box([-4, -4, 8], [4, 4, 8.5])
    assert opens(yard(attic), upright(0, 0, (7.9, 8.7), 0.8)).reasons == ()


def divided(door: float) -> Level:
    return yard(box([-0.2, -SIDE, 0], [0.2, -door, 3]), box([-0.2, door, 0], [0.2, SIDE, 3]))


def blocks(one: Level, barrier: Box) -> Change:
    one = dataclasses.replace(
        one, spawns=(dataclasses.replace(one.spawns[0], position=np.array([-3.0, 0, 0.02])),)
    )
    mutated = dataclasses.replace(one, collision=np.concatenate([one.collision, barrier.faces()]))
    return cut_off(survey(one), mutated, barrier)


def test_a_box_in_the_only_door_cuts_a_room_off() -> None:
    change = blocks(divided(0.8), upright(0, 0, (-0.2, 2.8), (0.4, 1.1)))
    assert change.reasons == ("lost",)
    assert (change.places[:, 0] > 0).all()


@pytest.mark.parametrize(
    "barrier", [upright(0, 0, (-0.2, 0.8), (0.4, 1.1)), upright(0, 0, (-0.2, 2.8), (0.4, 0.2))]
)
def test_a_box_that_one_gets_over_or_past_does_not(barrier: Box) -> None:
    assert blocks(divided(1.6 if barrier.half[1] < 1 else 0.8), barrier).reasons == ()


@pytest.mark.parametrize("gap", [0.70, 0.76, 0.82])
def test_a_box_beside_which_the_character_just_fits_does_not(gap: float) -> None:
    """It is 0.68 m wide, and cells are 0.17 m."""
    right = 0.8 - gap
    barrier = upright(0, (right - 1.1) / 2, (-0.2, 2.8), (0.4, (right + 1.1) / 2))
    assert blocks(divided(0.8), barrier).reasons == ()


def test_a_box_in_one_of_two_doors_does_not() -> None:
    two = yard(
        box([-0.2, -SIDE, 0], [0.2, -0.8, 3]),
        box([-0.2, 0.8, 0], [0.2, 2.5, 3]),
        box([-0.2, 4.5, 0], [0.2, SIDE, 3]),
    )
    assert blocks(two, upright(0, 0, (-0.2, 2.8), (0.4, 1.1))).reasons == ()


@pytest.mark.parametrize(("width", "counts"), [(2.0, True), (0.5, False)])
def test_a_solid_counts_if_the_whole_character_gets_into_it(width: float, counts: bool) -> None:
    body = box([2, 2, 0], [2 + width, 4, 2.2])
    one, empty = yard(body), dataclasses.replace(yard(), solids=(Solid("body", body),))
    low, high = body.min(axis=(0, 1)), body.max(axis=(0, 1))
    change = opened(survey(one), empty, Box((low + high) / 2, (high - low) / 2))
    assert ("inside_solid" in change.reasons) == counts
