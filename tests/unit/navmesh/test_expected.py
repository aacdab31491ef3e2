"""Where a character is expected: walls, stairs and slopes do not make a walk unexpected, links' ends are expected."""

from __future__ import annotations

import numpy as np
import pytest

from reachtest.navmesh.expected import ExpectedSurface, floats_over
from reachtest.records import NavAgent
from reachtest.surface import SurfaceIndex
from tests.levels import EAST, FLOOR, NORTH, NORTH_EAST, UNREAL, Walk, box, slope
from tests.unit.navmesh.make import link, navmesh, rectangle

WALL = box([-20, 3, 0], [20, 4, 3])
STAIRS = np.concatenate([box([2 + 0.6 * i, -3, -1], [30, 3, 0.4 * (i + 1)]) for i in range(6)])
RAMP = slope(43, length=8, x=1.0)

# As builders leave them: the Recast demo's agent (0.6 m) and a cell off the walls, flat polygons over stairs,
# a slope quantised upwards.
ALONG_WALL = navmesh(rectangle((-20, -20), (20, 2.1)), agent=NavAgent(radius_m=0.6, climb_m=0.9))
UP_STAIRS = navmesh(
    rectangle((-20, -1.5), (1.4, 1.5)),
    rectangle((1.4, -1.5), (5.0, 1.5), z=0.0, rise=2.9),
    agent=NavAgent(climb_m=0.9),
)
UP_RAMP = navmesh(
    rectangle((-20, -4), (0.5, 4)), rectangle((0.5, -4), (7.5, 4), z=0.5, rise=7 * np.tan(np.radians(43)))
)


def walks():
    wall = Walk(FLOOR, WALL, start=(0, 2, 0.02)).go(0.5, NORTH).go(1.5, NORTH_EAST)
    stairs = Walk(FLOOR, STAIRS, start=(0, 0, 0.02)).go(0.9, EAST)
    ramp = Walk(FLOOR, RAMP, start=(0, 0, 0.02)).go(1.3, EAST)
    assert wall.here[1] == pytest.approx(3 - UNREAL.radius_m, abs=0.02)
    assert stairs.here[2] > 1.5
    assert ramp.here[2] > 2.0
    return [("wall", ALONG_WALL, wall), ("stairs", UP_STAIRS, stairs), ("ramp", UP_RAMP, ramp)]


@pytest.fixture(scope="module")
def walked():
    return walks()


def test_the_plain_distance_would_call_such_walks_unexpected(walked) -> None:
    """What the tolerance is for: closer limits fail on bare distances; the default of 3 m never does."""
    for name, mesh, walk in walked:
        limit = {"wall": 0.5, "stairs": 0.3, "ramp": 0.1}[name]
        assert np.isinf(SurfaceIndex(mesh.triangles, limit).distance(walk.path)).any(), name
        assert np.isfinite(SurfaceIndex(mesh.triangles, 3.0).distance(walk.path)).all()


@pytest.mark.parametrize("within_m", [3.0, 0.5, 0.1])
def test_walking_is_never_unexpected(walked, within_m: float) -> None:
    for name, mesh, walk in walked:
        away = ExpectedSurface(mesh, UNREAL, within_m).distance(walk.path)
        assert np.isfinite(away).all(), name
        assert away.max() <= within_m
        assert floats_over(mesh, UNREAL, walk.path).all(), name


def test_beyond_the_tolerance_the_distance_is_what_it_was() -> None:
    mesh = navmesh(rectangle((0, 0), (4, 4)))
    points = np.array([[2, 2, 0.3], [2, 2, 2.9], [2, 2, 3.1], [6.9, 2, 0], [7.1, 2, 0], [np.nan] * 3])
    plain = SurfaceIndex(mesh.triangles, 3.0).distance(points)
    assert ExpectedSurface(mesh, UNREAL, 3.0).distance(points).tolist() == plain.tolist()
    near = np.array([[5.5, 2, 0], [2, 2, 1.5]])
    assert np.isinf(ExpectedSurface(mesh, UNREAL, 0.5).distance(near)).all()
    assert not floats_over(mesh, UNREAL, near).any()


def test_both_ends_of_a_link_are_expected_and_what_lies_between_is_not() -> None:
    mesh = navmesh(rectangle((0, 0), (4, 4)), links=[link((3, 2, 0), (20, 2, 9), kind="teleport")])
    points = np.array([[20, 2, 9], [20, 3.2, 9], [20, 5.2, 9], [20, 5.4, 9], [12, 2, 4.5]])
    away = ExpectedSurface(mesh, UNREAL, 3.0).distance(points)
    assert away[:3] == pytest.approx([0.0, 0.9, 2.9])
    assert np.isinf(away[3:]).all()
    assert floats_over(mesh, UNREAL, points).tolist() == [True, False, False, False, False]
