"""Height fields: they carry characters as the same terrain in triangles does, and stand in only where they may."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from reachtest.explore.actions import action_stream
from reachtest.records import Character, Floats, HeightField, Ints, Level
from reachtest.world import MujocoSimulator
from reachtest.world.terrain import MOST_RANGE_M, split_terrain
from tests.gym import CHARACTERS
from tests.levels import EAST, STILL, UNREAL, Walk, box, level, with_terrain

FAR = np.full((1, 3, 3), 500.0) + [[[0, 0, 0], [1, 0, 0], [0, 1, 0]]]  # what is of no account


def hills(seed: int = 0, cells: int = 48, high: float = 2.5) -> HeightField:
    """A terrain of 1 m cells about the origin, 0 to `high` metres, too steep to walk here and there."""
    x, y = np.meshgrid(np.arange(cells + 1.0), np.arange(cells + 1.0))
    waves = np.sin(x / 2.1) * np.cos(y / 2.7) + 0.4 * np.random.default_rng(seed).random(x.shape)
    heights = (waves - waves.min()) / np.ptp(waves) * high
    return HeightField(np.full(2, -cells / 2), np.full(2, cells / 2), heights)


def plane(degrees: float = 0.0, at: float = 0.0) -> HeightField:
    """40 m x 40 m of 2 m cells: level up to x = 0, then rising along +x."""
    x = np.tile(np.arange(-20.0, 21.0, 2.0), (21, 1))
    return HeightField(
        np.full(2, -20.0), np.full(2, 20.0), at + np.maximum(x, 0) * np.tan(np.radians(degrees))
    )


def walk(where: Level, agents: int, steps: int, tile_pieces: int = 384) -> tuple[Floats, int]:
    """States [T, B, 7] of random walkers from a grid of places above, and how many tiles were compiled."""
    simulator = MujocoSimulator(where, agents, 2, tile_pieces)
    places = np.array([[x, y, 4.0] for x in range(-16, 17, 4) for y in range(-16, 17, 4)])[:agents]
    simulator.restore(np.arange(agents), simulator.place(places))
    actions = np.stack([action_stream(2, 0, agent, steps) for agent in range(agents)], axis=1)
    states = []
    for action in actions:
        simulator.step(action)
        states.append(simulator.save())
    return np.array(states), simulator.tiles_compiled


def test_a_walk_over_tile_borders_is_the_walk_in_one_model_bit_for_bit() -> None:
    """Tiles are cut by the boxes on the terrain; the terrain itself is the same in all of them."""
    rng = np.random.default_rng(3)
    rubble = [
        box([x, y, 0], [x + 2 * w, y + w, 2.2])
        for x, y, w in rng.uniform([-22, -22, 0.3], [20, 20, 1.5], (150, 3))
    ]
    where = with_terrain(level(*rubble, spawn=[0, 0, 4]), hills(high=1.8))
    assert split_terrain(where)[1]
    whole, one = walk(where, 24, 120, 10**9)
    cut, several = walk(where, 24, 120, 25)
    assert (one, several > 8) == (1, True)
    assert (cut == whole).all()


def test_any_state_goes_on_bit_for_bit() -> None:
    where = with_terrain(level(box([3, 3, 1], [5, 5, 3]), spawn=[0, 0, 4]), hills())
    assert split_terrain(where)[1]
    states, _ = walk(where, 8, 40)
    again = MujocoSimulator(where, 8, 1)
    again.restore(np.arange(8), states[19])
    for step, action in enumerate(
        np.stack([action_stream(2, 0, agent, 40) for agent in range(8)], axis=1)[20:]
    ):
        again.step(action)
        np.testing.assert_array_equal(again.save(), states[20 + step])


def test_paths_are_those_over_the_same_triangles() -> None:
    """All directions over hills, for two seconds; who meets a crest at the last bit may go another way."""
    where = with_terrain(level(FAR, spawn=[0, 0, 4]), hills(1))
    assert split_terrain(where)[1]
    field, _ = walk(where, 64, 15)
    pieces, _ = walk(replace(where, height_fields=()), 64, 15)
    apart = np.linalg.norm(field[:, :, :3] - pieces[:, :, :3], axis=2).max(axis=0)
    assert np.median(apart) < 1e-4
    assert np.quantile(apart, 0.9) < 0.05
    assert not np.array_equal(field, pieces)  # or both were the same


def test_heights_lie_where_the_triangles_are() -> None:
    """Also rows and columns of different number, and cells that are not square."""
    rng = np.random.default_rng(5)
    heights = np.repeat(np.repeat(rng.uniform(0, 30, (4, 6)), 2, axis=0), 2, axis=1)  # 8 x 12: level patches
    field = HeightField(np.array([100.0, -50.0]), np.array([133.0, -29.0]), heights)
    for row, column in ((0, 0), (0, 10), (6, 0), (4, 6)):
        x, y = 100 + 3 * (column + 0.5), -50 + 3 * (row + 0.5)
        here = Walk(FAR, start=[x, y, heights[row, column] + 1.0], terrain=field).go(2.0).here
        np.testing.assert_allclose(here, [x, y, heights[row, column]], atol=0.003)


@pytest.mark.parametrize("who", CHARACTERS)
def test_walks_and_jumps_on_a_plane(who: str) -> None:
    c = CHARACTERS[who]
    walker = Walk(FAR, start=[-15, 0, 0.02], character=c, terrain=plane()).go(0.5)
    walker.go(2.0, EAST)
    np.testing.assert_allclose(np.median(walker.velocity[-10:, 0]), c.walk_speed_mps, rtol=0.01)
    assert np.abs(walker.path[15:, 2]).max() < 0.006  # a giant is lifted 5 mm once, on triangles too
    jumper = Walk(FAR, start=[0, 0, 0.02], character=c, terrain=plane()).go(0.5)
    jumper.go(0.1, STILL, jump=True).go(2.0)
    assert jumper.path[:, 2].max() == pytest.approx(c.jump_speed_mps**2 / (2 * c.gravity_mps2), rel=0.02)


@pytest.mark.parametrize("who", CHARACTERS)
@pytest.mark.parametrize("run_up", [0.5, 9.0])
@pytest.mark.parametrize("beyond", [-1.0, 1.0])
def test_slope_limit(who: str, run_up: float, beyond: float) -> None:
    c = CHARACTERS[who]
    hill = plane(c.slope_limit_deg + beyond)
    climber = Walk(FAR, start=[-run_up, 0.3, 0.02], character=c, terrain=hill).go(0.5).go(6.0, EAST)
    climbed = climber.path[:, 2].max()
    assert climbed > 3.0 if beyond < 0 else climbed < max(0.5, c.step_height_m + 0.1)


@pytest.mark.parametrize("who", CHARACTERS)
def test_no_fall_through_at_terminal_speed(who: str) -> None:
    c: Character = CHARACTERS[who]
    where = with_terrain(level(FAR, character=c, spawn=[0, 0, 4]), hills(2, high=4.0))
    assert split_terrain(where)[1]
    simulator = MujocoSimulator(where, 49, 1)
    places = np.array([[x + 0.37, y + 0.21, 60.0] for x in range(-18, 18, 5) for y in range(-18, 18, 5)])[:49]
    states = simulator.place(places[:49])
    states[:, 5] = -c.terminal_speed_mps
    simulator.restore(np.arange(len(states)), states)
    for _ in range(60):
        simulator.step(np.zeros((49, 2), dtype=np.int8))
    assert (simulator.save()[:, 2] > -0.05).all()


@pytest.mark.parametrize("high", [0.0, 0.01])
def test_a_plane_far_from_the_origin_lies_where_it_should(high: float) -> None:
    field = HeightField(np.full(2, 4990.0), np.full(2, 5010.0), np.full((11, 11), -700.0))
    field.heights[:5] += high  # less than a prism's thickness
    walker = Walk(FAR, start=[5000, 5005, -699.5], terrain=field)
    assert walker.go(1.0).here[2] == pytest.approx(-700.0, abs=0.003)


@pytest.mark.parametrize("above", [-0.02, 0.05])
def test_its_border_is_a_step_like_any_other(above: float) -> None:
    """Its side is a wall down to the base; who may step that high gets onto it."""
    edge = UNREAL.step_height_m + above
    walker = Walk(box([-40, -5, -1], [-20, 5, 0]), start=[-25, 0, 0.02], terrain=plane(at=edge))
    walker.go(4.0, EAST)
    assert (walker.here[0] > -10) == (above < 0)
    assert walker.here[2] == pytest.approx(edge if above < 0 else 0.0, abs=0.01)


# --- where it may stand in ------------------------------------------------------------------------------


def stands_in(where: Level) -> bool:
    triangles, fields = split_terrain(where)
    if fields:
        (field,) = fields
        assert np.array_equal(triangles, np.delete(where.collision, _rows(field), axis=0))
    else:
        assert triangles is where.collision
    return bool(fields)


def _rows(field: HeightField) -> Ints:
    rows, columns = field.heights.shape
    return np.arange(field.first, field.first + 2 * (rows - 1) * (columns - 1))


def test_things_on_a_terrain_and_beside_it_leave_it_a_height_field() -> None:
    hill = plane(30.0)
    assert stands_in(with_terrain(level(FAR), hill))
    assert stands_in(with_terrain(level(box([-9, 0, -0.5], [-4, 5, 4])), hill))  # sunk in
    assert stands_in(with_terrain(level(box([-30, -20, -0.4], [-20, 20, 0])), hill))  # a floor that goes on
    assert stands_in(
        with_terrain(level(box([26, -20, -1], [40, 20, 0])), hill)
    )  # below its edge, but across a gap


@pytest.mark.parametrize(
    "other",
    [
        box([2, -3, -6], [19, 3, -5]),  # a cellar
        box([12, -3, 0], [30, 3, 1]),  # a floor that leads under it
        box([20.1, -3, 0], [30, 3, 1]),  # up to its border
        np.array([[[5.0, 0, 1], [5, 1, 1], [30, 0, 20]]]),  # from below to above
    ],
)
def test_what_leads_under_a_terrain_leaves_it_triangles(other: Floats) -> None:
    assert not stands_in(with_terrain(level(other), plane(30.0)))


def test_who_starts_under_a_terrain_leaves_it_triangles() -> None:
    assert not stands_in(with_terrain(level(FAR, spawn=[15, 0, 0]), plane(30.0)))
    assert stands_in(with_terrain(level(FAR, spawn=[25, 0, 0]), plane(30.0)))


def test_a_floor_under_a_hill_is_walked_on_as_before() -> None:
    """In from the open side, up to where the hill comes down; and where the floor ends, out of the world."""
    hill = replace(plane(), heights=plane(30.0).heights[:, ::-1])  # high at -x
    tunnel = box([-40, -3, 0], [0, 3, 0.5])
    walker = Walk(tunnel, start=[-30, 0, 0.52], terrain=hill).go(10.0, EAST)
    assert -8 < walker.here[0] < -3
    assert walker.here[2] == pytest.approx(0.5, abs=0.01)
    short = Walk(box([-40, -3, 0], [-19.9, 3, 0.5]), start=[-30, 0, 0.52], terrain=hill).go(8.0, EAST)
    assert short.here[2] < -5


def test_what_float32_and_few_contacts_cannot_hold_stays_triangles() -> None:
    rough = plane()
    rough.heights[3, 3] = MOST_RANGE_M + 1
    assert not stands_in(with_terrain(level(FAR), rough))
    fine = HeightField(np.zeros(2), np.full(2, 2.0), np.zeros((41, 41)))
    assert not stands_in(with_terrain(level(FAR), fine))
    assert stands_in(with_terrain(level(FAR), replace(fine, high=np.full(2, 8.0))))


def test_a_collision_that_was_changed_since_counts_as_it_is() -> None:
    """A hole dug into the terrain's triangles is a hole."""
    where = with_terrain(level(FAR), plane())
    hole = np.abs(where.collision.mean(axis=1)[:, :2]).max(axis=1) < 2.5
    dug = replace(where, collision=where.collision[~hole])
    assert not stands_in(dug)
    simulator = MujocoSimulator(dug, 1, 1)
    simulator.restore(np.array([0]), simulator.place(np.array([[0.0, 0.0, 0.5]])))
    for _ in range(12):
        simulator.step(np.zeros((1, 2), dtype=np.int8))
    assert simulator.save()[0, 2] < -3
    raised = replace(where, collision=where.collision + [0, 0, 1e-9])
    assert not stands_in(raised)


def test_two_terrains_side_by_side_are_both_height_fields() -> None:
    rolling = hills(4, cells=16, high=1.0)
    beside = HeightField(rolling.low + [16, 0], rolling.high + [16, 0], rolling.heights[:, ::-1])
    _, fields = split_terrain(with_terrain(with_terrain(level(FAR), rolling), beside))
    assert [field.first for field in fields] == [1, 1 + 2 * 16 * 16]
    over = replace(rolling, heights=rolling.heights + 8.0)
    roof, fields = split_terrain(with_terrain(with_terrain(level(FAR), rolling), over))
    assert (len(fields), len(roof)) == (1, 1 + 2 * 16 * 16)  # a roof is open from below
