"""The geometry kernels against brute force, and against trimesh."""

from __future__ import annotations

import tracemalloc

import numpy as np
import pytest
import trimesh
from hypothesis import example, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from reachtest.columns import ColumnIndex
from reachtest.geometry import inside_closed_surface, point_triangle_distance, triangle_normals
from reachtest.surface import SurfaceIndex

Floats = NDArray[np.float64]

seeds = st.integers(0, 2**32 - 1)


def soup(rng: np.random.Generator, count: int, slivers: bool = True) -> Floats:
    """Triangles [count, 3, 3] of every sort: small, huge, level ones, points, lines, and slivers by rounding."""
    size = rng.choice([0.2, 3.0, 25.0], (count, 1, 1))
    triangles = rng.uniform(-15, 15, (count, 1, 3)) + rng.normal(0, 1, (count, 3, 3)) * size
    kind = rng.integers(0, 6 if slivers else 3, count)
    triangles[kind == 1, 2] = triangles[kind == 1, 1]  # a line
    triangles[kind == 2, 1:] = triangles[kind == 2, :1]  # a point
    triangles[kind == 3, :, 2] = triangles[kind == 3, :1, 2]  # level
    triangles[kind == 4, 2] = 0.5 * (triangles[kind == 4, 0] + triangles[kind == 4, 1])  # nearly a line
    return triangles


def brute_distance(points: Floats, triangles: Floats) -> Floats:
    n, f = len(points), len(triangles)
    pairs = point_triangle_distance(np.repeat(points, f, axis=0), np.tile(triangles, (n, 1, 1)))
    return np.asarray(pairs.reshape(n, f).min(axis=1))


# --- distance of a point and a triangle -----------------------------------------------------------


@settings(max_examples=100, deadline=None)
@given(seeds)
def test_point_triangle_distance_is_that_of_trimesh(seed) -> None:
    rng = np.random.default_rng(seed)
    triangles = rng.uniform(-5, 5, (1, 3)) + rng.normal(0, 3, (60, 3, 3))  # trimesh wants real triangles
    points = rng.uniform(-12, 12, (60, 3))
    nearest = trimesh.triangles.closest_point(triangles, points)
    expected = np.linalg.norm(points - nearest, axis=1)
    np.testing.assert_allclose(point_triangle_distance(points, triangles), expected, rtol=1e-7, atol=1e-7)


@settings(max_examples=60, deadline=None)
@given(seeds)
def test_no_sample_of_a_triangle_is_nearer_and_some_sample_is_about_as_near(seed) -> None:
    """Degenerate triangles too, which trimesh does not take."""
    rng = np.random.default_rng(seed)
    triangles, points = soup(rng, 20), rng.uniform(-30, 30, (20, 3))
    grid = np.array([(i, j, 30 - i - j) for i in range(31) for j in range(31 - i)]) / 30
    samples = np.einsum("gk,fkd->fgd", grid, triangles)
    nearest = np.linalg.norm(samples - points[:, None], axis=2).min(axis=1)
    found = point_triangle_distance(points, triangles)
    longest = np.linalg.norm(triangles - np.roll(triangles, 1, axis=1), axis=2).max(axis=1)
    assert (found <= nearest + 1e-9).all()
    assert (found >= nearest - longest / 30 - 1e-9).all()


def test_a_point_on_a_triangle_is_no_distance_away() -> None:
    rng = np.random.default_rng(3)
    triangles = soup(rng, 200)
    weights = rng.dirichlet([1, 1, 1], 200)
    on_it = np.einsum("nk,nkd->nd", weights, triangles)
    assert point_triangle_distance(on_it, triangles).max() < 1e-6
    for corner in range(3):
        assert point_triangle_distance(triangles[:, corner], triangles).max() == 0.0


def test_normals_and_areas_are_those_of_trimesh_and_zero_where_there_are_none() -> None:
    triangles = soup(np.random.default_rng(4), 300)
    normals, areas = triangle_normals(triangles)
    np.testing.assert_allclose(areas, trimesh.triangles.area(triangles), atol=1e-9)
    crosses = trimesh.triangles.cross(triangles)
    crosses /= np.maximum(np.linalg.norm(crosses, axis=1), 1e-300)[:, None]
    flat = (triangles[:, 1] == triangles[:, 2]).all(axis=1)
    assert flat.any()
    assert (normals[flat] == 0).all()
    real = areas > 1e-6
    np.testing.assert_allclose(normals[real], crosses[real], atol=1e-9)


# --- distance to a surface ------------------------------------------------------------------------


@settings(max_examples=40, deadline=None)
@given(seeds, st.integers(1, 20), st.sampled_from([0.5, 1.0, 3.0, 10.0]))
def test_surface_distance_is_the_nearest_triangle_s(seed, count, limit) -> None:
    rng = np.random.default_rng(seed)
    triangles = soup(rng, count)
    points = np.concatenate(
        [
            rng.uniform(-40, 40, (100, 3)),
            triangles.reshape(-1, 3)[rng.integers(0, 3 * count, 100)] + rng.normal(0, limit / 2, (100, 3)),
        ]
    )
    near = brute_distance(points, triangles)
    index = SurfaceIndex(triangles, limit)
    distance = index.distance(points)
    sure = np.abs(near - limit) > 1e-9
    np.testing.assert_array_equal(np.isfinite(distance[sure]), near[sure] <= limit)
    close = np.isfinite(distance)
    np.testing.assert_allclose(distance[close], near[close], rtol=1e-12, atol=1e-12)
    np.testing.assert_array_equal(index.within(points)[sure], near[sure] <= limit)
    half = np.abs(near - limit / 2) > 1e-9
    np.testing.assert_array_equal(index.within(points, limit / 2)[half], near[half] <= limit / 2)


@settings(max_examples=20, deadline=None)
@given(seeds, st.sampled_from([0.5, 3.0]))
def test_points_just_within_the_limit_are_found_and_just_beyond_are_not(seed, limit) -> None:
    """Tiny triangles far apart, asked from all sides: the cells around each of them are complete."""
    rng = np.random.default_rng(seed)
    middle = rng.permutation(np.stack(np.meshgrid(*[np.arange(3) * 9.0] * 3), axis=3).reshape(-1, 3))
    triangles = (middle + rng.uniform(0, 2, (27, 3)))[:, None] + rng.normal(0, 1e-3, (27, 3, 3))
    index = SurfaceIndex(triangles, limit)
    away = rng.normal(0, 1, (27, 60, 3))
    away *= limit / np.linalg.norm(away, axis=2, keepdims=True)
    for share, found in ((0.98, True), (1.02, False)):
        points = (triangles.mean(axis=1)[:, None] + share * away).reshape(-1, 3)
        assert (np.isfinite(index.distance(points)) == found).all()
        assert (index.within(points) == found).all()


def test_slivers_of_a_thousand_kilometres_take_few_pieces_and_distances_stay_exact() -> None:
    rng = np.random.default_rng(5)
    slivers = np.array(
        [[[0.0, 0, 0], [1e7, 1e7, 1.0], [1e7, 1e7, 1.1]], [[0, 5, 0], [-1e7, 5, 0], [0, 5.01, 0]]]
    )
    triangles = np.concatenate([soup(rng, 50), slivers])
    points = rng.uniform(-20, 20, (300, 3))
    tracemalloc.start()
    distance = SurfaceIndex(triangles, 3.0).distance(points)
    assert tracemalloc.get_traced_memory()[1] < 1_500_000_000
    tracemalloc.stop()
    near = brute_distance(points, triangles)
    close = np.isfinite(distance)
    np.testing.assert_array_equal(close, near <= 3.0)
    np.testing.assert_allclose(distance[close], near[close], rtol=1e-9)


def test_surface_distance_does_not_depend_on_who_else_is_asked_for() -> None:
    rng = np.random.default_rng(8)
    index = SurfaceIndex(soup(rng, 60), 3.0)
    points = rng.uniform(-40, 40, (300, 3))
    together = index.distance(points)
    assert [float(index.distance(point[None])[0]) for point in points] == together.tolist()
    assert np.isfinite(together).any()
    assert index.distance(points[:0]).shape == (0,)


def test_surface_distance_of_many_points_is_that_of_few_at_a_time() -> None:
    """Many are asked in another order and by several threads."""
    rng = np.random.default_rng(9)
    index = SurfaceIndex(soup(rng, 200), 3.0)
    points = rng.uniform(-30, 30, (60_000, 3))
    few = np.concatenate([index.distance(some) for some in np.array_split(points, 25)])
    assert np.isfinite(few).sum() > 10_000
    np.testing.assert_array_equal(index.distance(points), few)


def test_distance_to_a_sliver_is_that_to_its_edges() -> None:
    """Three corners in one line but for rounding: their normal may point anywhere."""
    a, b = np.array([1.1, 2.3, 3.7]), np.array([17.3, -4.9, 8.1])
    sliver = np.stack([a, b, a + 0.3 * (b - a)])
    rng = np.random.default_rng(10)
    points = a + rng.uniform(0, 1, (300, 1)) * (b - a) + rng.normal(0, 1, (300, 3))
    share = np.clip((points - a) @ (b - a) / ((b - a) @ (b - a)), 0, 1)
    expected = np.linalg.norm(points - a - share[:, None] * (b - a), axis=1)
    found = point_triangle_distance(points, np.broadcast_to(sliver, (300, 3, 3)))
    np.testing.assert_allclose(found, expected, rtol=1e-9)


@pytest.mark.parametrize("far", [1e4, 1e7, -1e7, 1e15, np.nan, np.inf])
def test_surface_distance_from_far_outside_is_infinite(far: float) -> None:
    index = SurfaceIndex(np.array([[[0.0, 0, 0], [2, 0, 0], [0, 2, 0]]]), 3.0)
    points = np.array([[far, 0, 0], [0, far, 0], [0, 0, far], [far, far, far], [1.0, 0.5, 2.0]])
    assert index.distance(points).tolist() == [np.inf] * 4 + [2.0]
    assert index.within(points).tolist() == [False] * 4 + [True]


def test_surface_index_far_from_the_origin_and_wide() -> None:
    """5 km away with an extent of a kilometre, one triangle across all of it."""
    big = np.array([[[5e3, 5e3, 0], [6e3, 5e3, 40], [5e3, 6e3, 0]]])
    small = np.array([[[5.9e3, 5.9e3, 3], [5.9e3 + 1, 5.9e3, 3], [5.9e3, 5.9e3 + 1, 3]]])
    triangles = np.concatenate([big, small])
    points = np.random.default_rng(5).uniform([5e3, 5e3, -5], [6e3, 6e3, 45], (400, 3))
    points = np.concatenate([points, points[:50] * [1, 1, 0], [[5.9e3, 5.9e3, 5]]])
    near = brute_distance(points, triangles)
    expected = np.where(near <= 3.0, near, np.inf)
    np.testing.assert_allclose(SurfaceIndex(triangles, 3.0).distance(points), expected, rtol=1e-9)


def test_a_limit_beyond_the_index_is_refused() -> None:
    index = SurfaceIndex(np.array([[[0.0, 0, 0], [2, 0, 0], [0, 2, 0]]]), 3.0)
    with pytest.raises(ValueError, match="beyond the index's 3"):
        index.within(np.zeros((1, 3)), 4.0)


# --- the surface below a point --------------------------------------------------------------------


def brute_highest(triangles: Floats, points: Floats, down: Floats, up: float, steep: float) -> Floats:
    """By barycentric coordinates of every triangle that is no wall."""
    normals, areas = triangle_normals(triangles)
    usable = triangles[(np.abs(normals[:, 2]) >= steep) & (areas > 0)]
    result = np.full(len(points), np.nan)
    for n, point in enumerate(points):
        for a, b, c in usable:
            weights = np.linalg.solve(
                np.array([[a[0], b[0], c[0]], [a[1], b[1], c[1]], [1.0, 1.0, 1.0]]), [*point[:2], 1.0]
            )
            z = weights @ [a[2], b[2], c[2]]
            if (weights >= -1e-9).all() and point[2] - down[n] <= z <= point[2] + up:
                result[n] = np.fmax(result[n], z)
    return result


@settings(max_examples=40, deadline=None)
@given(seeds, st.integers(1, 20), st.sampled_from([0.3, 1.0, 25.0]))
@example(seed=0, count=2, cell=1e3)
def test_highest_surface_is_the_highest_of_all_triangles(seed, count, cell) -> None:
    rng = np.random.default_rng(seed)
    triangles = soup(rng, count, slivers=False)
    points = np.concatenate(
        [rng.uniform(-30, 30, (30, 3)), triangles.mean(axis=1) + np.array([0.0, 0.0, 0.5])]
    )
    down, up = rng.uniform(0, 30, len(points)), 2.0
    expected = brute_highest(triangles, points, down, up, 0.05)
    found, slope = ColumnIndex(triangles, cell_m=cell).highest(points, down, up)
    np.testing.assert_allclose(found, expected, atol=1e-6)
    assert (slope[np.isfinite(found)] >= 0.05).all()
    assert (slope[np.isnan(found)] == 0).all()


def test_slope_is_that_of_the_surface_found() -> None:
    level = np.array([[-5.0, -5, 0], [5, -5, 0], [0, 9, 0]])
    ramp = level + level[:, :1] * [[0.0, 0.0, 1.0]] + [0, 0, 3]  # 45 degrees, 3 m above in the middle
    index = ColumnIndex(np.stack([level, ramp]))
    middle = np.array([[0.0, 0.0, 1.0]])
    assert [float(a[0]) for a in index.highest(middle, 2.0, 1.0)] == pytest.approx([0, 1])
    assert [float(a[0]) for a in index.highest(middle, 2.0, 5.0)] == pytest.approx([3, np.sqrt(0.5)])
    assert np.isnan(index.highest(middle, -0.5, 1.5)[0][0])  # only from half a metre above the point on


@pytest.mark.parametrize("far", [[1e12, 0.5, 0], [1e7, 1e7, 0], [0.5, 1e12, 0]])
def test_columns_over_a_very_long_or_wide_level_take_little_memory(far: list[float]) -> None:
    floor = np.array([[-1.0, -1, 0], [1, -1, 0], [0, 1, 0]])
    triangles = np.stack([floor, [[0, 0, 9], [0.5, 0, 9], far]] + [[[0, 0, 8], [0, 0.5, 8], far]] * 20)
    tracemalloc.start()
    found, _ = ColumnIndex(triangles, min_normal_z=0.0).highest(np.zeros((1, 3)), 0.1, 0.1)
    assert tracemalloc.get_traced_memory()[1] < 3_000_000_000
    tracemalloc.stop()
    assert found == 0.0


def test_no_hole_along_shared_edges() -> None:
    """A floor of 800 triangles: every point on an edge or a corner has the floor under it."""
    x, y = np.meshgrid(np.linspace(-3, 3, 21), np.linspace(-3, 3, 21), indexing="ij")
    corners = np.stack([x, y, np.sin(x) + y / 3], axis=2)
    a, b, c, d = corners[:-1, :-1], corners[1:, :-1], corners[1:, 1:], corners[:-1, 1:]
    halves = [np.stack(half, axis=2).reshape(-1, 3, 3) for half in ((a, b, c), (a, c, d))]
    triangles = np.concatenate(halves)
    shares = np.linspace(0, 1, 7)[None, :, None]
    edges = triangles[:, 0, None] * (1 - shares) + triangles[:, 2, None] * shares
    points = np.concatenate([edges.reshape(-1, 3), triangles.reshape(-1, 3)])
    found, _ = ColumnIndex(triangles).highest(points, 0.1, 0.1)
    np.testing.assert_allclose(found, points[:, 2], atol=1e-6)


@pytest.mark.parametrize("triangles", [np.empty((0, 3, 3)), np.array([[[0.0, 0, 0], [0, 0, 4], [0, 4, 0]]])])
def test_nothing_to_stand_on_at_all(triangles: Floats) -> None:
    points = np.array([[0.0, 0.0, 0.0], [3.0, 4.0, 5.0]])
    found, slope = ColumnIndex(triangles).highest(points, 10.0, 10.0)
    assert np.isnan(found).all()
    assert (slope == 0).all()


# --- inside or outside ----------------------------------------------------------------------------


def concave() -> trimesh.Trimesh:
    """An L of 4 x 4 x 2 m, 1 m wide: its bounding box is mostly outside."""
    outline = np.array([[0, 0], [4, 0], [4, 1], [1, 1], [1, 4], [0, 4]], dtype=np.float64)
    cover = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]]
    return trimesh.creation.extrude_triangulation(outline, cover, 2.0)


def rotated_box() -> trimesh.Trimesh:
    turn = trimesh.transformations.rotation_matrix(0.7, [1.0, 2.0, 3.0])
    return trimesh.creation.box([3, 1, 2], transform=turn)


SHAPES = {
    "icosphere": lambda: trimesh.creation.icosphere(subdivisions=2, radius=2.0),
    "box": lambda: trimesh.creation.box([2, 3, 4]),
    "rotated box": rotated_box,
    "L": concave,
    "hollow": lambda: trimesh.creation.annulus(1.0, 2.0, 1.5),
}


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("turned", [False, True], ids=["outward", "inward"])
def test_inside_is_what_trimesh_says_whatever_the_orientation(shape: str, turned: bool) -> None:
    mesh = SHAPES[shape]()
    assert mesh.is_watertight
    low, high = mesh.bounds
    points = np.random.default_rng(11).uniform(low - 0.5, high + 0.5, (600, 3))
    triangles = np.asarray(mesh.triangles)[:, ::-1] if turned else np.asarray(mesh.triangles)
    inside = inside_closed_surface(points, triangles)
    np.testing.assert_array_equal(inside, mesh.contains(points))
    assert 0 < inside.sum() < len(inside)


def test_inside_far_from_the_origin_and_in_many_pieces() -> None:
    """More pairs than one vectorised pass takes."""
    mesh = trimesh.creation.icosphere(subdivisions=5, radius=2.0)
    centre = np.array([5_000.0, -5_000.0, 300.0])
    points = np.random.default_rng(12).uniform(-2, 2, (200, 3))
    radius = np.linalg.norm(points, axis=1)
    clear = np.abs(radius - 2.0) > 0.01
    inside = inside_closed_surface(points + centre, np.asarray(mesh.triangles) + centre)
    np.testing.assert_array_equal(inside[clear], radius[clear] < 2.0)


def test_a_small_gap_does_not_let_the_inside_out() -> None:
    triangles = np.delete(np.asarray(trimesh.creation.icosphere(subdivisions=3).triangles), 17, axis=0)
    assert inside_closed_surface(np.array([[0.0, 0, 0], [0.5, 0.2, -0.3]]), triangles).all()
