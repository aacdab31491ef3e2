"""Tiles: nothing a character feels depends on how the level was cut, nor on which tiles were in memory."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from reachtest.explore.actions import action_stream
from reachtest.records import ExploreSettings, Floats
from reachtest.world import MujocoSimulator
from reachtest.world.convex import pieces_of
from reachtest.world.tiles import Margin, Partition, margin_for
from tests.levels import UNREAL, box, level, slope

AGENTS, STEPS = 24, 120


def rubble(seed: int, far: float = 0.0) -> Floats:
    """A floor with steps, walls, ramps and a hole, 48 m wide, `far` metres from the origin."""
    rng = np.random.default_rng(seed)
    pieces = [box([x, y, -0.3], [x + 6, y + 6, 0]) for x in range(-24, 24, 6) for y in range(-24, 24, 6)][1:]
    for x, y, w, h in rng.uniform([-22, -22, 0.3, 0.1], [22, 22, 4, 1.5], (280, 4)):
        pieces.append(box([x, y, 0], [x + w, y + 1, h]))
    pieces += [slope(degrees, 8.0, 3.0, x) for degrees, x in ((30.0, -20.0), (43.0, -6.0), (60.0, 8.0))]
    return np.concatenate(pieces) + np.array([far, -far, 0.0])


def walk(
    triangles: Floats, tile_pieces: int, tiles_mb: float = 512.0, far: float = 0.0
) -> tuple[Floats, int]:
    """States [T, B, 7] of random walkers in every direction, and how many tiles were compiled."""
    where = level(triangles, explore=ExploreSettings(agents=AGENTS), spawn=[far, -far, 3.0])
    where = type(where)(**{**where.__dict__, "bounds": (np.full(3, -1e4), np.full(3, 1e4))})
    simulator = MujocoSimulator(where, AGENTS, 2, tile_pieces, tiles_mb)
    starts = np.array([[x, y, 3.0] for x in range(-18, 18, 6) for y in range(-16, 16, 8)])[:AGENTS]
    simulator.restore(np.arange(AGENTS), simulator.place(starts + [far, -far, 0.0]))
    actions = np.stack([action_stream(1, 0, agent, STEPS) for agent in range(AGENTS)], axis=1)
    states, home = [], simulator.save()
    for number, action in enumerate(actions):
        simulator.step(action)
        states.append(simulator.save())
        some = np.array([number % AGENTS])  # a restart of one must not be felt by those who just left a tile
        simulator.restore(some, home[some])
    return np.array(states), simulator.tiles_compiled


@pytest.mark.parametrize("far", [0.0, 5_000.0])
def test_a_walk_over_tile_borders_is_the_walk_in_one_model_bit_for_bit(far: float) -> None:
    """24 walkers, 8 directions, steps, walls, ramps, jumps and falls: every state of every step."""
    triangles = rubble(0, far)
    whole, one = walk(triangles, 10**9, far=far)
    for target in (25, 60):
        cut, several = walk(triangles, target, far=far)
        assert (one, several > 8) == (1, True)
        assert (cut == whole).all()
    moved = np.linalg.norm(whole[:, :, :2] - whole[0, :, :2], axis=2).max(axis=0)
    assert (moved > 6).mean() > 0.5  # borders were crossed


def test_tiles_that_were_dropped_come_back_the_same() -> None:
    triangles = rubble(1)
    kept, needed = walk(triangles, 40)
    dropped, compiled = walk(triangles, 40, tiles_mb=0.5)
    assert compiled > needed
    assert (dropped == kept).all()


@given(seed=st.integers(0, 10_000), target=st.integers(1, 60))
@settings(max_examples=40, deadline=None)
def test_a_tile_holds_all_that_is_in_reach_of_it(seed: int, target: int) -> None:
    rng = np.random.default_rng(seed)
    pieces = pieces_of(rng.uniform(-20, 20, (80, 1, 3)) + rng.uniform(-2, 2, (80, 3, 3)))
    margin = Margin(rng.uniform(0.1, 2, 3), rng.uniform(0.1, 2, 3))
    tiles = Partition(pieces, margin, target)
    points = rng.uniform(-30, 30, (200, 3))
    low, high = pieces.low, pieces.high
    for point, tile in zip(points, tiles.find(points), strict=True):
        inside = (tiles.low <= point).all(axis=1) & (point < tiles.high).all(axis=1)
        assert np.flatnonzero(inside).tolist() == [tile]
        reach = (low <= point + margin.high).all(axis=1) & (high >= point - margin.low).all(axis=1)
        assert np.isin(np.flatnonzero(reach), tiles.members[tile]).all()
        assert (np.diff(tiles.members[tile]) > 0).all()


def test_a_tile_is_cut_as_far_as_it_helps() -> None:
    """A large level has small tiles; a heap in one place is one tile, not thousands."""
    margin = margin_for(UNREAL, 1 / 30)
    field = np.concatenate(
        [box([x, y, 0], [x + 3, y + 3, 1]) for x in range(0, 150, 5) for y in range(0, 150, 5)]
    )
    tiles = Partition(pieces_of(field), margin, 60)
    assert tiles.capacity <= 60
    assert len(tiles) > 15
    heap = np.tile(box([0, 0, 0], [1, 1, 1]), (100, 1, 1))
    assert len(Partition(pieces_of(heap), margin, 60)) < 10
