"""What every reset heuristic has to do, whatever it prefers."""

from __future__ import annotations

import numpy as np
import pytest

from reachtest.explore import HEURISTICS
from reachtest.explore.heuristics import mixture
from reachtest.records import Candidates


def candidates(open_goals: bool = True) -> Candidates:
    return Candidates(
        visits=np.array([1, 1, 5, 100]),
        goal_distance=np.array([30.0, 1.0, 3.0, 0.0]) if open_goals else np.full(4, np.inf),
        off_mesh_m=np.array([0.0, 1.5, np.inf, 0.0]),
        expected_within_m=3.0,
        grounded=np.array([True, False, True, True]),
        above_m=np.array([0.0, 1.0, 0.0, 0.0]),
        velocities=np.zeros((4, 3)),
    )


@pytest.mark.parametrize("name", HEURISTICS)
@pytest.mark.parametrize("open_goals", [True, False])
def test_priorities_are_finite_and_not_negative(name, open_goals) -> None:
    value = HEURISTICS[name](candidates(open_goals))
    assert value.shape == (4,)
    assert np.isfinite(value).all()
    assert (value >= 0).all()


def test_what_each_prefers() -> None:
    c = candidates()
    assert HEURISTICS["visits"](c).argmin() == 3
    assert HEURISTICS["goals"](c).argmax() == 3
    assert HEURISTICS["off_mesh"](c)[[0, 3]].tolist() == [0, 0]


@pytest.mark.parametrize("power", [0.5, 1.0, 2.0])
def test_a_weight_is_a_share_of_the_restarts(power) -> None:
    eta = mixture({"visits": 0.25, "off_mesh": 0.75}, power)(candidates())
    assert eta.sum() == pytest.approx(1.0)
    assert eta[[0, 3]].sum() < 0.25  # nothing of off_mesh's share


def test_no_opinion_leaves_the_share_to_the_others() -> None:
    eta = mixture({"visits": 0.5, "goals": 0.5}, 1.0)(candidates(open_goals=False))
    assert (eta / eta.sum()).tolist() == pytest.approx(mixture({"visits": 1.0}, 1.0)(candidates()).tolist())
    assert (mixture({"goals": 1.0}, 1.0)(candidates(open_goals=False)) == 1).all()
