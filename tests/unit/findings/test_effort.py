"""Unreached is said after directed effort only; before that the run is inconclusive, with what is missing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from reachtest.findings import find, judge
from reachtest.findings.effort import steps_to_go
from reachtest.records import ExploreSettings, GateSettings, Required
from tests.levels import FLOOR, level
from tests.unit.findings.test_detect import Paths, exploration

LEVEL = replace(
    level(FLOOR),
    gate=GateSettings(("unreached_area", "required_unreached")),
    required=(Required("flag", np.array([1.0, 1, 0]), 1.0),),
)
GOALS = [[0, 0, 0], [4, 0, 0], [5, 4, 0], [-6, -5, 0]]


def after(attempts, required_attempts=99, required=5, **changes):
    changes.setdefault("settings", ExploreSettings(effort=64))
    return exploration(
        goals=GOALS,
        reached=[5, -1, -1, 700],
        required=[required],
        goal_attempts=np.array(attempts),
        goal_border_m=np.array([0.0, 3.5, 7.0, 0.0]),
        required_attempts=np.array([required_attempts]),
        **changes,
    )


def outcome(result, where=LEVEL):
    found = find(where, result, Paths())
    return judge(where.gate, result, found), [f for f in found if f.kind in where.gate.fail_on]


def test_an_area_that_was_tried_enough_is_unreached_and_gates() -> None:
    verdict, (area,) = outcome(after([0, 40, 24, 0]))
    assert (verdict.name, verdict.exit_code) == ("fail", 1)
    assert area.gating
    assert area.details == ("64 directed attempts from 3.5 m away did not get there",)


def test_an_area_that_was_not_tried_enough_is_inconclusive_and_says_what_is_missing() -> None:
    verdict, (area,) = outcome(after([0, 40, 23, 0]))
    assert (verdict.name, verdict.exit_code) == ("inconclusive", 4)
    assert not area.gating
    assert "63 directed attempts" in area.details[0]
    assert "explore.effort asks for 64" in area.details[0]
    assert "at 1 of 1 unreached areas fewer than 64 directed attempts" in verdict.reason
    assert "more steps (an estimate)" in verdict.reason


def test_an_area_that_was_tried_enough_and_is_known_does_not_prevent_a_pass_and_is_said() -> None:
    result = after([0, 40, 24, 0])
    known = [replace(f, gating=False, suppressed_by="baseline: x") for f in find(LEVEL, result, Paths())]
    verdict = judge(LEVEL.gate, result, known)
    assert (verdict.name, verdict.goals_given_up) == ("pass", 2)
    assert "2 of 4 goals are known to be unreached" in verdict.reason
    unsure = judge(replace(LEVEL.gate, max_discovery_probability=0.0), replace(result, cells_once=9), known)
    assert unsure.name == "inconclusive"
    assert "known to be unreached" in unsure.reason


def test_a_known_area_excuses_no_other_one() -> None:
    result = replace(after([0, 64, 64, 0]), goal_step=np.array([5, -1, -1, -1]))
    known = [replace(f, gating=False, suppressed_by="baseline: x") for f in find(LEVEL, result, Paths())]
    verdict = judge(LEVEL.gate, result, known)
    assert (verdict.name, verdict.goals_given_up) == ("inconclusive", 2)
    assert "1 of 2 nav-mesh goals were reached" in verdict.reason
    assert verdict.steps_to_go is not None
    assert f"{verdict.steps_to_go:,} more steps" in verdict.reason


def test_a_run_that_reached_no_goal_gives_none_up() -> None:
    result = replace(after([64, 64, 64, 64]), goal_step=np.full(4, -1))
    verdict = judge(replace(LEVEL.gate, fail_on=("inside_solid",)), result, ())
    assert (verdict.name, verdict.goals_given_up) == ("inconclusive", 0)


@pytest.mark.parametrize(("attempts", "name"), [(64, "fail"), (63, "inconclusive"), (0, "inconclusive")])
def test_a_required_point_gates_after_as_much_effort(attempts: int, name: str) -> None:
    where = replace(LEVEL, gate=replace(LEVEL.gate, min_goals_reached=0.5))
    result = after([0, 0, 0, 0], required_attempts=attempts, required=-1)
    verdict, found = outcome(result, where)
    assert verdict.name == name
    assert [f.gating for f in found if f.kind == "required_unreached"] == [name == "fail"]


def test_a_required_point_that_the_navmesh_connects_to_nothing_is_inconclusive_however_much_was_tried() -> (
    None
):
    where = replace(LEVEL, gate=replace(LEVEL.gate, min_goals_reached=0.5))
    astray = np.array([False])
    result = after([0, 0, 0, 0], required_attempts=30_000, required=-1, required_connected=astray)
    verdict, found = outcome(result, where)
    assert (verdict.name, verdict.exit_code) == ("inconclusive", 4)
    assert "1 required point that the nav-mesh connects to no spawn was not reached" in verdict.reason
    (point,) = (f for f in found if f.kind == "required_unreached")
    assert not point.gating
    assert "30000 directed attempts" in point.details[0]


def test_a_share_of_goals_that_need_not_be_reached_does_not_gate() -> None:
    where = replace(LEVEL, gate=replace(LEVEL.gate, min_goals_reached=0.5))
    verdict, (area,) = outcome(after([0, 99, 99, 0]), where)
    assert verdict.name == "pass"
    assert not area.gating


def test_no_effort_asked_for_is_enough_effort() -> None:
    verdict, _ = outcome(after([0, 0, 0, 0], settings=ExploreSettings(effort=0)))
    assert verdict.name == "fail"


def test_the_estimate_goes_by_the_goals_reached_lately_and_by_the_attempts_to_make() -> None:
    everything = np.ones(4, dtype=bool)
    tried = after([0, 64, 64, 0])  # one goal in the last third of 1,000 steps, two to go
    assert steps_to_go(tried, everything) == 1000  # one of the two takes 667, both 1 + 1/2 times as long
    untried = replace(after([0, 0, 0, 0]), goal_step=np.array([5, -1, -1, 6]))  # 64 attempts of 32 steps
    assert steps_to_go(untried, everything) == round(64 * 32 / ExploreSettings().directed_at_goals, -3)
    assert steps_to_go(replace(tried, goal_step=np.array([5, -1, -1, 6])), everything) is None


def test_the_estimate_is_right_where_every_goal_is_as_likely_at_every_step() -> None:
    rng = np.random.default_rng(0)
    ratios = []
    for _ in range(200):
        times = np.sort(rng.exponential(10_000, 100).astype(int))
        steps = int(times[60])  # 39 are left
        seen = np.where(times <= steps, times, -1)
        run = replace(after([0] * 4), goals=np.zeros((100, 3)), goal_step=seen, agent_steps=steps)
        estimate = steps_to_go(run, np.ones(100, dtype=bool))
        assert estimate is not None
        ratios.append(estimate / (times[-1] - steps))
    assert 0.8 < np.median(ratios) < 1.25


def test_an_area_that_nobody_tried_to_get_to_says_so() -> None:
    _, (area,) = outcome(after([0, 0, 0, 0]))
    assert area.details == (
        "no directed attempt was made to get there: inconclusive, explore.effort asks for 64",
    )
