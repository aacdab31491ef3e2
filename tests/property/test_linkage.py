"""Single linkage finds the groups that looking at every pair of points finds."""

from __future__ import annotations

import time

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from reachtest.findings.cluster import single_linkage
from reachtest.records import Floats, Ints

LINK_M = 4.0


def test_groups_are_kept_apart() -> None:
    points = np.array([[0, 0, 0], [10, 0, 0], [3, 0, 0], [6, 0, 0], [13.5, 0, 0]], float)
    assert [g.tolist() for g in single_linkage(points, 3.0)] == [[0, 2, 3], [1], [4]]
    assert single_linkage(np.empty((0, 3)), 1.0) == []


@given(
    count=st.integers(1, 60),
    size_m=st.sampled_from([1.0, 5.0, 12.0, 30.0, 1000.0]),
    flat=st.booleans(),
    whole=st.booleans(),  # then many gaps are exactly as wide as what links
    ties=st.lists(st.tuples(st.integers(0, 59), st.integers(0, 59)), max_size=4),
    seed=st.integers(0, 2**32 - 1),
)
def test_the_groups_are_those_of_all_pairs(
    count: int, size_m: float, flat: bool, whole: bool, ties: list[tuple[int, int]], seed: int
) -> None:
    points = np.random.default_rng(seed).uniform(-size_m, size_m, (count, 3)) * [1.0, 1.0, float(not flat)]
    points = np.round(points) if whole else points
    tied = np.array(ties, dtype=np.int64).reshape(-1, 2) % count
    found = single_linkage(points, LINK_M, tied)
    assert [group.tolist() for group in found] == _by_all_pairs(points, tied)


def test_rims_that_many_fell_off_take_no_pair_each() -> None:
    """Forty thousand falls along rims of 60 m: 200 million pairs, which took gigabytes and minutes."""
    rng = np.random.default_rng(0)
    along, aside = rng.uniform(0.0, 60.0, (2, 20_000)), rng.uniform(0.0, 0.01, (2, 20_000))
    across = np.array([[0.0], [LINK_M + 0.05]]) + aside  # rims at 45 degrees: the cells of both nearly touch
    rims = np.stack([along + across, along - across, 0.0 * along], axis=2) / np.sqrt(2.0)
    began = time.process_time()
    found = single_linkage(rims.reshape(-1, 3), LINK_M)
    assert [len(group) for group in found] == [20_000, 20_000]
    assert time.process_time() - began < 20.0  # 0.2 s


def _by_all_pairs(points: Floats, ties: Ints) -> list[list[int]]:
    """Every point takes the lowest number that is near it until nothing changes."""
    near = np.linalg.norm(points[:, None] - points[None], axis=2) <= LINK_M
    near[ties[:, 0], ties[:, 1]] = near[ties[:, 1], ties[:, 0]] = True
    label = np.arange(len(points))
    while not np.array_equal(label, lower := np.where(near, label[None], len(points)).min(axis=1)):
        label = lower
    return [np.flatnonzero(label == first).tolist() for first in np.unique(label)]
