"""A forest finds what looking at every point finds, however the points came in."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from reachtest.explore.forest import Forest


@given(
    sizes=st.lists(st.integers(0, 40), max_size=12), count=st.integers(1, 8), seed=st.integers(0, 2**32 - 1)
)
def test_the_nearest_are_those_of_all_points(sizes: list[int], count: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    forest, places = Forest(), rng.normal(size=(5, 3))
    for size in sizes:
        forest.append(rng.normal(size=(size, 3)))
    assert len(forest) == sum(sizes)
    away, who = forest.nearest(places, count)
    known = min(count, len(forest))
    all_ = np.linalg.norm(places[:, None] - forest.positions[None], axis=2)
    np.testing.assert_allclose(away[:, :known], np.sort(all_, axis=1)[:, :known])
    np.testing.assert_array_equal(np.take_along_axis(all_, who[:, :known], axis=1), away[:, :known])
    assert (who[:, known:] == -1).all()
    assert np.isinf(away[:, known:]).all()
