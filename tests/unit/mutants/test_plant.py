"""The planters: what they take away is gone, what they put in the way is there, and a seed gives the same again."""

from __future__ import annotations

import dataclasses
from itertools import islice

import numpy as np
import pytest

from reachtest.mutants.boxes import ray_hits
from reachtest.mutants.decide import Change
from reachtest.mutants.ground import Ground, survey_ground
from reachtest.mutants.openings import closed_bodies
from reachtest.mutants.plant import KINDS, plant
from reachtest.mutants.records import Planted
from reachtest.records import NavMesh, Spawn
from tests.levels import box, slope
from tests.unit.mutants.test_decide import SIDE, yard

DOWN = np.array([0.0, 0.0, -1.0])


@pytest.fixture(scope="module")
def ground() -> Ground:
    """A yard of two rooms with a pillar in one and, in the other, a stage with a ramp between walls."""
    rooms = (box([-0.2, -SIDE, 0], [0.2, -0.8, 3]), box([-0.2, 0.8, 0], [0.2, SIDE, 3]))
    pillar = box([-4.4, -4.4, 0.0], [-3, -3, 2.5])
    stage = (
        box([2.6, 2, 0], [SIDE, SIDE, 1.6]),
        box([4.5, -2, 0], [4.7, 2, 3]),
        box([2.4, -2, 0], [2.6, SIDE, 3]),
    )
    ramp = slope(24.0, length=4.0 / np.cos(np.radians(24.0)), width=1.9)
    ramp = np.stack([3.55 - ramp[..., 1], ramp[..., 0] - 2.0, ramp[..., 2]], axis=-1)
    made = yard(*rooms, pillar, *stage, ramp)
    start = Spawn("start", np.array([-2.0, 0.0, 0.02]))
    top = np.array(
        [
            [[2.6, 2, 1.6], [SIDE, 2, 1.6], [SIDE, SIDE, 1.6]],
            [[2.6, 2, 1.6], [SIDE, SIDE, 1.6], [2.6, SIDE, 1.6]],
        ]
    )
    surface = np.concatenate([made.navmesh.triangles, ramp, top]).reshape(-1, 3)
    mesh = NavMesh("", surface, np.arange(len(surface)).reshape(-1, 3))
    made = dataclasses.replace(made, spawns=(start,), navmesh=mesh)
    return survey_ground(made, np.array([[4.3, 4.0, 1.6], [3.0, -4.0, 0.0]]))


def first(ground: Ground, kind: str, seed: int = 1) -> tuple[Planted, Change]:
    for planted, change in plant(ground, kind, seed):
        if change.reasons:
            return planted, change
    raise AssertionError(f"no {kind} that counts")


def test_a_hole_goes_all_the_way_through_the_floor(ground: Ground) -> None:
    planted, change = first(ground, "hole")
    above = planted.mutant.position + [0.0, 0.0, 1.0]
    assert len(ray_hits(ground.level.collision, above, DOWN, 9.0)[0])
    assert not len(ray_hits(planted.level.collision, above, DOWN, 9.0)[0])
    assert change.reasons == ("fell",)


@pytest.mark.parametrize("kind", ["missing wall", "lowered wall"])
def test_an_opening_goes_all_the_way_through_the_wall(ground: Ground, kind: str) -> None:
    planted, _ = first(ground, kind)
    hole = planted.mutant.box
    inside = hole.centre - hole.axes[0] * (hole.half[0] + 0.1)
    inside[2] = hole.bounds[0][2] + 0.5
    through = 2 * hole.half[0] + 0.2
    assert len(ray_hits(ground.level.collision, inside, hole.axes[0], through)[0])
    assert not len(ray_hits(planted.level.collision, inside, hole.axes[0], through)[0])
    assert (np.abs(hole.centre[:2]).max() > SIDE - 1) == ("fell" in first(ground, kind)[1].reasons)


def test_a_pit_has_a_floor_and_walls(ground: Ground) -> None:
    planted, change = first(ground, "pit")
    at = planted.mutant.position
    middle = np.array([at[0], at[1], -1.0])
    assert ray_hits(planted.level.collision, middle + [0, 0, 2.0], DOWN, 9.0)[0][0] > 3.0
    for side in ([1.0, 0, 0], [-1.0, 0, 0], [0, 1.0, 0], [0, -1.0, 0]):
        assert len(ray_hits(planted.level.collision, middle, np.array(side), 2.0)[0])
    assert "trap" in change.reasons


def test_a_bare_solid_is_known_as_solid_and_stops_nobody(ground: Ground) -> None:
    planted, change = first(ground, "bare solid")
    solid = planted.level.solids[-1]
    at = solid.triangles.reshape(-1, 3).mean(axis=0)
    assert len(planted.level.collision) == len(ground.level.collision) - len(solid.triangles)
    assert not len(ray_hits(planted.level.collision, at, np.array([1.0, 0, 0]), 1.0)[0])
    assert "inside_solid" in change.reasons


@pytest.mark.parametrize("kind", ["blocked door", "raised step"])
def test_a_barrier_cuts_goals_off(ground: Ground, kind: str) -> None:
    planted, change = first(ground, kind)
    assert change.reasons == ("lost",)
    assert len(planted.level.collision) == len(ground.level.collision) + 12
    assert planted.level.collision[..., 2].max() >= planted.mutant.position[2]


@pytest.mark.parametrize("kind", list(KINDS))
def test_the_same_seed_plants_the_same(ground: Ground, kind: str) -> None:
    one, two = (
        [(p.mutant.position.tolist(), c.reasons) for p, c in islice(plant(ground, kind, 7), 3)]
        for _ in range(2)
    )
    assert one == two


def test_only_closed_bodies_are_taken_for_solids() -> None:
    closed, tilted = box([0, 0, 0], [1, 1, 2]), box([5, 0, 0], [6, 1, 2])
    open_ = box([10, 0, 0], [11, 1, 2])[:-1]
    bodies = closed_bodies(np.concatenate([closed, open_, tilted, box([20, 0, 0], [21, 1, 0.1])]))
    assert sorted(int(members[0]) for members in bodies) == [0, 23]
    assert all(len(members) == 12 for members in bodies)
