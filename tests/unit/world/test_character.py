"""The gym: what a character can and cannot do, for every preset and for numbers of one's own."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from reachtest.levels import PRESETS
from reachtest.records import Character
from tests.levels import EAST, FLOOR, NORTH, NORTH_EAST, STILL, WEST, Walk, box, slope

CUSTOM = replace(
    PRESETS["unreal"],
    radius_m=0.25,
    height_m=1.2,
    walk_speed_mps=4.0,
    jump_speed_mps=5.5,
    slope_limit_deg=35.0,
)
CHARACTERS = {**PRESETS, "custom": CUSTOM}


@pytest.fixture(params=CHARACTERS, scope="module")
def character(request: pytest.FixtureRequest) -> Character:
    return CHARACTERS[request.param]


def apex(c: Character) -> float:
    return c.jump_speed_mps**2 / (2 * c.gravity_mps2)


def air_time(c: Character) -> float:
    return 2 * c.jump_speed_mps / c.gravity_mps2


def run_up(c: Character) -> float:
    """Distance that is enough to be at full speed [m]."""
    return 2.0 + 2 * c.walk_speed_mps**2 / max(c.acceleration_mps2, 1e-9)


def test_walking_speed(character) -> None:
    walk = Walk(FLOOR, start=[0, 0, 0.02], character=character).go(0.3).go(2.0, EAST)
    assert np.linalg.norm(walk.velocity[-1]) == pytest.approx(character.walk_speed_mps, rel=0.02)
    assert walk.grounded[-1]


def test_jump_apex(character) -> None:
    walk = Walk(FLOOR, start=[0, 0, 0.02], character=character).go(0.3)
    ground = walk.here[2]
    walk.go(0.01, STILL, jump=True).go(air_time(character))
    assert walk.path[:, 2].max() - ground == pytest.approx(apex(character), rel=0.03)


def test_flat_jump_distance(character) -> None:
    """The gap that is just crossed is as wide as theory says, to 3 % and the width of one control tick."""
    c = character
    walk = Walk(FLOOR, start=[-40, 0, 0.02], character=c).go(0.3).go(2.0, EAST)
    took_off = walk.here[0]
    before = len(walk.path)
    walk.go(0.01, EAST, jump=True).go(air_time(c) + 0.3, EAST)
    landed = before + 2 + int(np.argmax(walk.grounded[before + 2 :]))
    tick = c.walk_speed_mps * walk.dt
    assert walk.path[landed, 0] - took_off == pytest.approx(
        c.walk_speed_mps * air_time(c), rel=0.03, abs=1.01 * tick
    )


@pytest.mark.parametrize("start", [-0.6, -6.0], ids=["standing", "run-up"])
def test_slopes_just_under_the_limit_are_climbed(character, start) -> None:
    degrees = character.slope_limit_deg - 1
    walk = (
        Walk(FLOOR, slope(degrees, 30.0), start=[start, 0, 0.02], character=character).go(0.3).go(3.5, EAST)
    )
    assert walk.path[:, 2].max() > 3.0


@pytest.mark.parametrize("jump", [False, True], ids=["walking", "jumping"])
@pytest.mark.parametrize("start", [-0.6, -6.0], ids=["standing", "run-up"])
def test_slopes_just_over_the_limit_are_not(character, start, jump) -> None:
    degrees = character.slope_limit_deg + 1
    walk = Walk(FLOOR, slope(degrees, 30.0), start=[start, 0, 0.02], character=character)
    walk.go(0.3).go(5.0, EAST, jump)
    assert walk.path[:, 2].max() < (apex(character) + 0.05 if jump else 0.1)


def test_steps_up_to_the_step_height_are_climbed_at_walking_speed(character) -> None:
    c = character
    if not c.step_height_m:
        pytest.skip("this character has no step-up")
    walk = Walk(FLOOR, box([0, -3, 0], [20, 3, c.step_height_m - 0.01]), start=[-4, 0, 0.02], character=c)
    walk.go(0.3).go(1.5, EAST)
    assert walk.here[2] == pytest.approx(c.step_height_m - 0.01, abs=0.02)
    speed = walk.velocity[round(1.0 / walk.dt) :, 0]
    assert speed.min() > 0.98 * c.walk_speed_mps


@pytest.mark.parametrize("stick", [EAST, NORTH_EAST])
def test_higher_steps_are_not(character, stick) -> None:
    """A capsule's round end rolls over what its slope limit allows, whatever the step height."""
    c = character
    round_end = c.radius_m * (1 - np.cos(np.radians(c.slope_limit_deg)))
    height = max(c.step_height_m, round_end) + 0.05
    walk = (
        Walk(FLOOR, box([0, -30, 0], [6, 30, height]), start=[-4, 0, 0.02], character=c)
        .go(0.3)
        .go(3.0, stick)
    )
    assert walk.path[:, 2].max() < 0.1


@pytest.mark.parametrize(("share", "crossed"), [(0.93, True), (1.05, False)])
def test_gaps_are_crossed_as_far_as_the_jump_carries(character, share, crossed) -> None:
    """Jumping at the last tick before the edge; half a capsule may overhang at both ends."""
    c = character
    gap = c.walk_speed_mps * air_time(c)
    wide = share * gap + (0.0 if crossed else 2 * c.radius_m)
    near, far = box([-20, -3, -1], [0, 3, 0]), box([wide, -3, -1], [wide + 20, 3, 0])
    walk = Walk(near, far, start=[-run_up(c) - 2, 0, 0.02], character=c).go(0.3)
    while walk.here[0] + c.walk_speed_mps * walk.dt < 0:
        walk.go(0.01, EAST)
    walk.go(0.01, EAST, jump=True).go(air_time(c) + 0.5, EAST)
    assert (walk.here[2] > -0.1) == crossed


@pytest.mark.parametrize(("spare", "passes"), [(0.05, True), (-0.05, False)])
def test_openings(character, spare, passes) -> None:
    half = character.radius_m + spare / 2
    walls = [box([2, half, 0], [3, 10, 4]), box([2, -10, 0], [3, -half, 4])]
    walk = Walk(FLOOR, *walls, start=[0, 0, 0.02], character=character).go(0.3).go(2.5, EAST)
    assert (walk.here[0] > 3.5) == passes


@pytest.mark.parametrize(("spare", "passes"), [(0.05, True), (-0.05, False)])
def test_ceilings(character, spare, passes) -> None:
    top = character.height_m + spare
    walk = Walk(FLOOR, box([2, -9, top], [4, 9, top + 1]), start=[0, 0, 0.02], character=character)
    walk.go(0.3).go(2.5, EAST)
    assert (walk.here[0] > 4.5) == passes


def test_stands_at_a_ledge(character) -> None:
    ledge = box([-5, -5, 0], [0, 5, 2])
    walk = Walk(FLOOR, ledge, start=[0.3 * character.radius_m, 0, 2.02], character=character).go(3.0)
    assert walk.here[2] == pytest.approx(2.0, abs=0.1)
    assert walk.grounded[-1]


def test_slides_along_walls_without_sticking(character) -> None:
    wall = box([2, -50, 0], [3, 50, 4])
    walk = Walk(FLOOR, wall, start=[0, -20, 0.02], character=character).go(0.3).go(3.0, NORTH_EAST)
    along = walk.velocity[-round(1.0 / walk.dt) :, 1]
    assert along.min() > 0.6 * character.walk_speed_mps
    into = walk.path[:, 0] + character.radius_m - 2.0
    assert into[-round(1.0 / walk.dt) :].max() < 0.01
    # The tick of the impact may end inside the wall, far from the middle of the capsule.
    assert into.max() < character.radius_m / 3


@pytest.mark.parametrize("thickness", [0.02, 1.0])
def test_no_fall_through_a_floor_at_terminal_velocity(character, thickness) -> None:
    height = 1.3 * character.terminal_speed_mps**2 / (2 * character.gravity_mps2)
    floor = box([-20, -20, -thickness], [20, 20, 0])
    walk = Walk(floor, start=[0.1, 0.2, height], character=character).go(height / 20.0 + 6.0)
    assert walk.path[:, 2].min() > -0.05
    assert walk.here[2] == pytest.approx(0.0, abs=0.03)


def test_no_fall_through_a_finely_tessellated_floor(character) -> None:
    a = np.arange(-4, 4, 0.5)
    x, y = (g.ravel()[:, None] for g in np.meshgrid(a, a))
    lower = np.stack([np.hstack([x, y]), np.hstack([x + 0.5, y]), np.hstack([x + 0.5, y + 0.5])], axis=1)
    upper = np.stack([np.hstack([x, y]), np.hstack([x + 0.5, y + 0.5]), np.hstack([x, y + 0.5])], axis=1)
    flat = np.concatenate([lower, upper])
    floor = np.concatenate([flat, np.zeros((*flat.shape[:2], 1))], axis=2)
    walk = Walk(floor, start=[0.25, 0.13, 100.0], character=character).go(12.0)
    assert walk.path[:, 2].min() > -0.05


def test_no_squeezing_between_walls_that_meet_at_10_degrees(character) -> None:
    a = np.radians(5)
    wall = np.array(
        [
            [[0, 0, 0], [10, 10 * np.tan(a), 0], [10, 10 * np.tan(a), 4]],
            [[0, 0, 0], [0, 0, 4], [10, 10 * np.tan(a), 4]],
        ]
    )
    walls = [wall, (wall * [1, -1, 1])[:, ::-1]]
    deepest = character.radius_m / np.sin(a)
    walk = Walk(FLOOR, *walls, start=[deepest + 4, 0, 0.02], character=character).go(0.3).go(4.0, WEST)
    assert walk.path[:, 0].min() > deepest - 0.15
    assert walk.path[:, 2].max() < 0.1


def test_no_climbing_by_jumping_at_a_wall(character) -> None:
    wall = box([2, -50, 0], [3, 50, 30])
    walk = Walk(FLOOR, wall, start=[0, 0, 0.02], character=character).go(0.3)
    for stick in (EAST, NORTH_EAST, NORTH, EAST):
        walk.go(2.0, stick, jump=True)
    assert walk.path[:, 2].max() < apex(character) * 1.03 + 0.02


def test_stairs_are_walked_up_and_down(character) -> None:
    c = character
    rise = min(0.3, c.step_height_m) or 0.08
    stairs = [box([0.4 * i, -3, 0], [8, 3, rise * (i + 1)]) for i in range(8)]
    top = 8 * rise
    walk = (
        Walk(FLOOR, *stairs, start=[-4, 0, 0.02], character=c).go(0.3).go(9.0 / c.walk_speed_mps + 0.2, EAST)
    )
    assert walk.here[2] == pytest.approx(top, abs=0.05)
    walk.go(16.0 / c.walk_speed_mps, WEST).go(0.5)
    assert walk.here[2] == pytest.approx(0.0, abs=0.05)
    assert walk.path[:, 2].max() < top + 0.05


def test_edges_do_not_throw(character) -> None:
    """Running over a curb or off the crest of a ramp gains no height."""
    curb = box([0, -3, 0], [1, 3, 0.06])
    walk = Walk(FLOOR, curb, slope(25, 4.0, x=3.0), start=[-5, 0, 0.02], character=character)
    walk.go(0.3).go(12.0 / character.walk_speed_mps, EAST)
    crest = 4.0 * np.sin(np.radians(25))
    assert walk.path[:, 2].max() < crest + 0.1
