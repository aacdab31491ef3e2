"""Cutting boxes out of triangles: exact, whatever way they are turned."""

from __future__ import annotations

import numpy as np
import pytest

from reachtest.geometry import triangle_normals
from reachtest.mutants.boxes import Box, cut_out, ray_hits
from tests.levels import box, slope

DOWN = np.array([0.0, 0.0, -1.0])


def area(triangles: np.ndarray) -> float:
    return float(triangle_normals(triangles)[1].sum())


@pytest.mark.parametrize("yaw", [0.0, 0.3, np.pi / 4, 2.0])
def test_a_square_is_cut_out_of_a_floor_and_nothing_else(yaw: float) -> None:
    floor = np.array(
        [[[-5, -5, 0], [5, -5, 0], [5, 5, 0]], [[-5, -5, 0], [5, 5, 0], [-5, 5, 0]]], dtype=float
    )
    hole = Box(np.array([1.0, -0.5, 0.0]), np.array([0.8, 0.6, 0.2]), yaw)
    left = cut_out(floor, hole)
    assert area(left) == pytest.approx(100.0 - 4 * 0.8 * 0.6)
    assert (triangle_normals(left)[0][:, 2] > 0.999).all()
    rng = np.random.default_rng(0)
    for x, y in rng.uniform(-3, 3, (200, 2)):
        through = not len(ray_hits(left, np.array([x, y, 1.0]), DOWN, 2.0)[0])
        assert through == bool(hole.contains(np.array([[x, y, 0.0]]))[0])


def test_what_only_passes_the_box_by_stays_whole() -> None:
    tilted = slope(40.0)
    beside = Box(np.array([2.0, 0.0, 5.0]), np.array([1.0, 1.0, 1.0]))  # over the ramp, within its bounds
    assert area(cut_out(tilted, beside)) == pytest.approx(area(tilted))
    assert len(cut_out(tilted, beside)) == len(tilted)


def test_a_tunnel_through_a_closed_wall() -> None:
    wall = box([0, -5, 0], [0.5, 5, 3])
    left = cut_out(wall, Box(np.array([0.25, 0, 1]), np.array([0.4, 0.7, 1.2])))
    forward = np.array([1.0, 0.0, 0.0])
    assert not len(ray_hits(left, np.array([-1.0, 0.0, 1.0]), forward, 5.0)[0])
    assert len(ray_hits(left, np.array([-1.0, 0.8, 1.0]), forward, 5.0)[0]) == 2
    assert len(ray_hits(left, np.array([-1.0, 0.0, 2.5]), forward, 5.0)[0]) == 2


def test_a_ray_tells_front_from_back() -> None:
    distance, against = ray_hits(
        box([0, -1, 0], [2, 1, 2]), np.array([-1.0, 0.1, 1.2]), np.array([1.0, 0, 0]), 9
    )
    assert distance.tolist() == pytest.approx([1.0, 3.0])
    assert against[0] < 0 < against[1]


@pytest.mark.parametrize("inwards", [False, True])
def test_the_faces_of_a_box_look_where_they_should(inwards: bool) -> None:
    some = Box(np.array([3.0, 2.0, 1.0]), np.array([1.0, 2.0, 0.5]), 0.4)
    faces = some.faces(inwards=inwards)
    outwards = ((faces.mean(axis=1) - some.centre) * triangle_normals(faces)[0]).sum(axis=1)
    assert (outwards < 0).all() if inwards else (outwards > 0).all()
    assert area(faces) == pytest.approx(8 * (1 * 2 + 2 * 0.5 + 1 * 0.5))
