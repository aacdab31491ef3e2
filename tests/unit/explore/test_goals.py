"""Goals are what a plain greedy walk over the candidates keeps, however fast they are found."""

from __future__ import annotations

import numpy as np
import pytest

from reachtest.explore import goals
from reachtest.records import Floats


def greedy(candidates: Floats, spacing: float) -> Floats:
    kept: list[Floats] = []
    for candidate in candidates:
        if all(((candidate - other) ** 2).sum() >= spacing**2 for other in kept):
            kept.append(candidate)
    return np.array(kept).reshape(-1, 3)


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("least", [1, 40, 10_000])
def test_thinning_keeps_what_a_walk_in_order_keeps(
    monkeypatch: pytest.MonkeyPatch, seed: int, least: int
) -> None:
    monkeypatch.setattr(goals, "_LEAST_BLOCK", least)
    rng = np.random.default_rng(seed)
    candidates = np.concatenate(
        [
            rng.uniform(0, [20, 20, 4], (600, 3)),
            rng.integers(0, 8, (200, 3)) * 2.0,  # exactly the spacing apart, and twice the same
        ]
    )
    order = rng.permutation(candidates)
    np.testing.assert_array_equal(goals._thin(order, 2.0), greedy(order, 2.0))


def test_one_candidate_is_a_goal() -> None:
    assert goals._thin(np.zeros((1, 3)), 4.0).shape == (1, 3)
