"""Voxels of a triangle against the plain way: the triangle clipped by one column after the other."""

from __future__ import annotations

import numpy as np
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from reachtest.navmesh.voxels import Grid, Spans, rasterise
from reachtest.records import Floats

GRID = Grid(np.zeros(3), 1.0, 0.25, (6, 5))
LEAST = 1e-3  # [cells] shares of a triangle smaller than this may count or not


def clipped(polygon: list[Floats], axis: int, at: float, below: bool) -> list[Floats]:
    """What of a convex polygon lies on one side of a plane across an axis."""
    sign = 1.0 if below else -1.0
    result = []
    for k, a in enumerate(polygon):
        b = polygon[(k + 1) % len(polygon)]
        da, db = sign * (at - a[axis]), sign * (at - b[axis])
        if da >= 0:
            result.append(a)
        if (da > 0) != (db > 0) and da != db:
            result.append(a + da / (da - db) * (b - a))
    return result


def heights(triangle: Floats, i: int, j: int, grow: float) -> tuple[float, float] | None:
    """Lowest and highest point of the triangle in a column that is wider by `grow` on every side."""
    polygon = list(triangle)
    for axis, low in ((0, i), (1, j)):
        polygon = clipped(polygon, axis, low - grow, below=False)
        polygon = clipped(polygon, axis, low + 1 + grow, below=True)
    if not polygon:
        return None
    z = [float(point[2]) for point in polygon]
    return min(z), max(z)


def spans_of(triangles: Floats) -> dict[tuple[int, int], tuple[int, int]]:
    spans = rasterise(triangles, 45, 1, GRID)
    columns = [divmod(int(column), GRID.shape[1]) for column in spans.column]
    return {c: (int(b), int(t)) for c, b, t in zip(columns, spans.bottom, spans.top, strict=True)}


COORDINATES = st.one_of(st.floats(-1, 7), st.integers(0, 6).map(float))
POINTS = st.tuples(COORDINATES, COORDINATES, st.floats(0, 4))


@settings(max_examples=300, deadline=None)
@given(st.tuples(POINTS, POINTS, POINTS))
def test_a_column_holds_all_of_the_triangle_and_no_more(corners: tuple[tuple[float, ...], ...]) -> None:
    triangle = np.array(corners)
    assume(np.linalg.norm(np.cross(triangle[1] - triangle[0], triangle[2] - triangle[0])) > 0.01)
    found = spans_of(triangle[None])
    for i in range(GRID.shape[0]):
        for j in range(GRID.shape[1]):
            least, most = heights(triangle, i, j, -LEAST), heights(triangle, i, j, LEAST)
            span = found.get((i, j))
            if least is not None:
                assert span is not None, "a column that the triangle comes into"
                assert span[0] * 0.25 <= least[0] + 1e-5
                assert span[1] * 0.25 >= least[1] - 1e-5
            if most is None:
                assert span is None, "a column that the triangle does not come near"
            elif span is not None:
                assert span[0] * 0.25 >= most[0] - 0.25 - 1e-5
                assert span[1] * 0.25 <= most[1] + 0.25 + 1e-5


def floor(z: float, up: bool = True) -> Floats:
    sheet = np.array([[[0, 0, z], [6, 0, z], [6, 5, z]], [[0, 0, z], [6, 5, z], [0, 5, z]]])
    return sheet if up else sheet[:, ::-1]


def one_column(spans: Spans) -> list[tuple[int, int, bool]]:
    here = spans.column == 2 * GRID.shape[1] + 2
    return list(
        zip(spans.bottom[here].tolist(), spans.top[here].tolist(), spans.walkable[here].tolist(), strict=True)
    )


def test_what_touches_becomes_one_span() -> None:
    assert one_column(rasterise(np.concatenate([floor(0), floor(0.25)]), 45, 1, GRID)) == [(0, 2, True)]
    apart = rasterise(np.concatenate([floor(0), floor(0.6)]), 45, 1, GRID)
    assert one_column(apart) == [(0, 1, True), (2, 3, True)]


def test_a_walkable_floor_counts_up_to_the_climb_below_the_top() -> None:
    wall = np.array([[[2.5, 0, 0], [2.5, 5, 0], [2.5, 5, 3]], [[2.5, 0, 0], [2.5, 5, 3], [2.5, 0, 3]]])
    both = np.concatenate([floor(0), wall])
    assert one_column(rasterise(both, 45, 1, GRID)) == [(0, 12, False)]
    assert one_column(rasterise(both, 45, 11, GRID)) == [(0, 12, True)]


def test_only_what_faces_up_is_walkable() -> None:
    assert one_column(rasterise(floor(1, up=False), 45, 1, GRID)) == [(4, 5, False)]
    assert one_column(rasterise(floor(1, up=False), 45, 1, GRID, both_sides=True)) == [(4, 5, True)]


def test_heights_at_the_centre_are_exact() -> None:
    ramp = np.array([[[0, 0, 0], [6, 0, 3], [6, 5, 3]], [[0, 0, 0], [6, 5, 3], [0, 5, 0]]], dtype=float)
    spans = rasterise(ramp, 45, 1, GRID)
    assert len(spans) == 30
    assert np.allclose(spans.floor, (spans.column // GRID.shape[1] + 0.5) / 2)
