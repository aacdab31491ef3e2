"""The nav-mesh's short way replaces the found one up to where that left the nav-mesh."""

from __future__ import annotations

import numpy as np

from reachtest.confirm.shortcut import over_navmesh
from reachtest.confirm.trials import Trial
from reachtest.records import Floats, NavMesh


def quad(x: tuple[float, float], y: tuple[float, float]) -> Floats:
    """A flat rectangle of two triangles."""
    a, b, c, d = ([x[i], y[j], 0.0] for i, j in ((0, 0), (1, 0), (1, 1), (0, 1)))
    return np.array([[a, b, c], [a, c, d]])


def mesh(*triangles: Floats) -> NavMesh:
    every = np.concatenate(triangles)
    return NavMesh("nav.obj", every.reshape(-1, 3), np.arange(3 * len(every)).reshape(-1, 3))


def walked(*corners: tuple[float, float]) -> Trial:
    """A walk along corners, a metre a step, jumping all the time."""
    places = [np.array([*corners[0], 0.0])]
    for x, y in corners[1:]:
        way = np.array([x, y, 0.0]) - places[-1]
        count = int(np.linalg.norm(way))
        places += [places[-1] + way * k / count for k in range(1, count + 1)]
    points = np.array(places)
    actions = np.ones((len(points) - 1, 2), dtype=np.int8)
    return Trial(points[0], actions, points[1:], points[1:], False)


# A ring of corridors 2 m wide around a block of 16 m x 16 m, in pieces that share no vertices.
RING = mesh(
    quad((0, 20), (0, 2)), quad((0, 20), (18, 20)), quad((0, 2), (2.05, 17.95)), quad((18, 20), (2.05, 17.95))
)


def test_the_short_way_round_a_block_is_taken_and_the_end_is_kept() -> None:
    long = walked((1, 1), (19, 1), (19, 19), (1, 19), (1, 14), (-6, 14))
    left = int(np.flatnonzero(long.positions[:, 0] >= 0)[-1])
    route = over_navmesh(RING, long, left)
    assert route is not None
    length = np.linalg.norm(np.diff(route.points, axis=0), axis=1).sum()
    assert length < 0.5 * len(long)
    assert route.points[0].tolist() == [1, 1, 0]
    assert route.points[-1].tolist() == [-6, 14, 0]
    inside = (route.points[:, :2] > 2.2).all(axis=1) & (route.points[:, :2] < 17.8).all(axis=1)
    assert not inside.any()
    assert route.jumps[-3]  # off the nav-mesh: as found
    assert not route.jumps[:3].any()


def test_islands_have_no_way_between_them() -> None:
    apart = mesh(quad((0, 4), (0, 4)), quad((10, 14), (0, 4)))
    assert over_navmesh(apart, walked((1, 1), (13, 1), (13, 9)), 12) is None


def test_a_city_is_left_alone() -> None:
    assert over_navmesh(mesh(quad((-900, 900), (-900, 900))), walked((-800, 0), (800, 0)), 1000) is None
