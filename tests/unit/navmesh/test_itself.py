"""On the nav-mesh itself: over its floor and at its edge, but not behind the wall it reaches up to."""

from __future__ import annotations

import numpy as np
import pytest

from reachtest.navmesh.itself import NavMeshItself
from tests.levels import FLOOR, UNREAL, level

R = UNREAL.radius_m
SHEET = np.array([[[-5, -5, 0], [5, -5, 0], [5, 5, 0]], [[-5, -5, 0], [5, 5, 0], [-5, 5, 0]]], dtype=float)
WHERE = NavMeshItself(level(FLOOR, navmesh=SHEET))


@pytest.mark.parametrize(
    ("place", "on"),
    [
        ([0, 0, 0], True),
        ([0, 0, 0.9], True),  # a nav-mesh floats
        ([0, 0, 1.1], False),  # on a crate
        ([5 + 0.9 * R, 0, 0], True),  # at a wall, off a nav-mesh that ends a radius before it
        ([5 + 1.05 * R, 0, 0], False),  # behind a wall of 2 cm, off one that reaches up to it
        ([np.nan] * 3, False),
    ],
)
def test_who_stands_on_it(place: list[float], on: bool) -> None:
    assert WHERE.holds(np.array([place], dtype=float)).tolist() == [on]


def test_the_last_place_of_a_way_on_it() -> None:
    way = np.array([[0.0, 0, 0], [4, 0, 0], [7, 0, 0], [9, 0, 0]])
    assert WHERE.last_of(way) == 1
    assert WHERE.last_of(way[2:]) is None
