"""What is called a bug, and what is not: hand-made evidence, one question a test."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from reachtest.findings import DETECTORS, find, judge
from reachtest.records import (
    Exploration,
    ExploreSettings,
    Fall,
    GateSettings,
    Origin,
    Points,
    ReplayPath,
    Required,
    RiskSample,
    Solid,
    StopReason,
    Zone,
)
from tests.levels import FLOOR, box, level

LEVEL = level(FLOOR)


class Paths:
    """A replayer that always succeeds, and shows nothing of the ways."""

    def path_to_point(self, index):
        return ReplayPath(np.zeros(3), (), np.full((1, 3), np.nan), 1.0, 1, 1)

    def path_to_fall(self, fall):
        return self.path_to_point(0)

    def flights(self, falls):
        return [fall.footing[None] for fall in falls]


def exploration(points=(), falls=(), goals=(), reached=(), required=(), **changes) -> Exploration:
    """`points` are (position, exit or None, grounded); an exit makes a point unexpected."""
    n = len(points)
    numbers = np.arange(n)
    off = np.array([exit_ is not None for _, exit_, _ in points], dtype=bool)
    made = Points(
        positions=np.array([p for p, _, _ in points], dtype=float).reshape(-1, 3),
        states=np.zeros((n, 7)),
        grounded=np.array([g for _, _, g in points], dtype=bool),
        parent=np.full(n, -1, dtype=np.int32),
        round=numbers.astype(np.int32),
        agent=np.zeros(n, dtype=np.int16),
        start=np.zeros(n, dtype=np.int16),
        step=np.ones(n, dtype=np.int16),
        off_mesh_m=np.where(off, np.inf, 0.0),
        exit_point=np.array([e or [np.nan] * 3 for _, e, _ in points], dtype=float).reshape(-1, 3),
    )
    result = Exploration(
        points=made,
        visits=np.ones(n, dtype=np.int64),
        goals=np.array(goals, dtype=float).reshape(-1, 3),
        goal_step=np.array(reached, dtype=np.int64),
        required_step=np.array(required, dtype=np.int64),
        falls=tuple(falls),
        agent_steps=1000,
        episodes=100,
        diverged_episodes=0,
        cells_once=5,
        cells_twice=5,
        cells_total=50,
        stop_reason=StopReason.STEPS,
        seed=0,
        settings=ExploreSettings(),
        timing={},
    )
    return replace(result, **changes)


def fall(footing, exit_) -> Fall:
    origin = Origin(-1, 0, 0, 0, 9)
    return Fall(origin, np.array([*footing[:2], -60.0]), np.array(footing, float), np.array(exit_, float))


def test_who_waits_hears_of_every_kind_that_is_looked_for() -> None:
    told: list[tuple[int, int]] = []
    find(LEVEL, exploration(), Paths(), None, lambda what, number, total: told.append((number, total)))
    assert told == [(n, len(DETECTORS)) for n in range(1, len(DETECTORS) + 1)]


def kinds(result: Exploration, where=LEVEL) -> list[str]:
    return [f.kind for f in find(where, result, Paths())]


def test_nothing_found_is_nothing_reported() -> None:
    assert kinds(exploration([([0, 0, 0], None, True)])) == []


def test_two_holes_are_two_findings_whatever_lies_behind_them() -> None:
    meadow = [([x, 30.0, 0], [0, 9, 0], True) for x in range(-20, 20, 2)]
    other = [([30.0, 0, 0], [9, 0, 0], True)]
    found = find(LEVEL, exploration(meadow + other), Paths())
    assert [f.kind for f in found] == ["unexpected_area"] * 2
    assert [f.points for f in found] == [20, 1]
    assert found[0].exit_point.tolist() == [0, 9, 0]
    assert found[0].low.tolist() == [-20, 30, 0]
    assert found[0].high.tolist() == [18, 30, 0]


def test_an_open_rim_is_one_finding_and_the_fall_takes_the_area_with_it() -> None:
    rim = [fall([x, 12, 0], [x, 11, 0]) for x in np.arange(0, 30, 2.0)]
    beyond = [([4, 13, 0], [4, 11, 0], True)]
    found = find(LEVEL, exploration(beyond, rim), Paths())
    assert [f.kind for f in found] == ["fell_out_of_world"]
    assert found[0].gating


def test_what_is_only_flown_through_is_no_finding() -> None:
    assert kinds(exploration([([0, 0, 8], [0, 0, 3], False)])) == []
    assert kinds(exploration([([0, 0, 8], [0, 0, 3], True)])) == ["unexpected_area"]


def test_zones() -> None:
    low, high = np.array([19.0, 19, -1]), np.array([21.0, 21, 1])
    stands = exploration([([20, 20, 0], [9, 9, 0], True)])
    allowed = replace(LEVEL, zones=(Zone("roof", "allowed_off_mesh", low, high),))
    forbidden = replace(LEVEL, zones=(Zone("vault", "forbidden", low, high),))
    assert kinds(stands, allowed) == []
    found = find(forbidden, stands, Paths())
    assert [f.kind for f in found] == ["forbidden_zone"]
    assert "vault" in found[0].title


def test_inside_a_solid_and_not_merely_beside_it() -> None:
    where = replace(LEVEL, solids=(Solid("monolith", box([5, 5, 0], [9, 9, 4])),))
    assert kinds(exploration([([7, 7, 0], None, True)]), where) == ["inside_solid"]
    assert kinds(exploration([([4.67, 7, 0], None, True), ([7, 7, 4.0], None, True)]), where) == []


def test_unreached_goals_are_areas_and_required_points_are_named() -> None:
    goals = [[0, 0, 0], [30, 0, 0], [34, 0, 0], [0, 40, 0]]
    where = replace(LEVEL, required=(Required("flag", np.array([1.0, 1, 0]), 1.0),))
    found = find(where, exploration(goals=goals, reached=[5, -1, -1, -1], required=[-1]), Paths())
    assert [(f.kind, f.points) for f in found] == [
        ("required_unreached", 1),
        ("unreached_area", 2),
        ("unreached_area", 1),
    ]
    assert "flag" in found[0].title


def test_ids_survive_a_small_shift_and_are_distinct() -> None:
    one = find(LEVEL, exploration([([20, 20, 0], [9, 9, 0], True)]), Paths())
    two = find(LEVEL, exploration([([20.4, 20.3, 0], [9.3, 9.2, 0], True)]), Paths())
    assert one[0].id == two[0].id
    goals = [[0, 0, 0], [1.0, 0, 0], [0, 40, 0]]
    many = find(LEVEL, exploration(goals=goals, reached=[-1, -1, -1]), Paths())
    assert len({f.id for f in many}) == len(many) == 2


# 5 % by the bound, but 12 of the latest 100 episodes found something new
LATELY = (RiskSample(9_000, 1_000, 400, 50, 10, 500, 100, 12, 2, 9),)


@pytest.mark.parametrize(
    ("changes", "gate", "name", "code"),
    [
        ({}, {}, "pass", 0),
        ({"goal_step": np.array([3, -1])}, {}, "inconclusive", 4),
        ({"goal_step": np.array([3, -1])}, {"min_goals_reached": 0.5}, "pass", 0),
        ({}, {"max_discovery_probability": 0.01}, "inconclusive", 4),
        ({}, {"max_discovery_probability": 0.10}, "pass", 0),
        ({"risk_curve": LATELY}, {"max_discovery_probability": 0.10}, "inconclusive", 4),
        (
            {"risk_curve": LATELY, "stop_reason": StopReason.DONE},
            {"max_discovery_probability": 0.12},
            "pass",
            0,
        ),
        ({"stop_reason": StopReason.INTERRUPTED}, {}, "inconclusive", 130),
        ({"stop_reason": StopReason.TERMINATED}, {}, "inconclusive", 143),
    ],
)
def test_verdicts_without_a_gating_finding(changes, gate, name, code) -> None:
    result = exploration(goals=[[0, 0, 0], [1, 1, 0]], reached=[1, 2], **changes)
    verdict = judge(replace(GateSettings(()), **gate), result, ())
    assert (verdict.name, verdict.exit_code) == (name, code)


def test_a_gating_finding_fails_even_when_interrupted() -> None:
    result = exploration([([20, 20, 0], [9, 9, 0], True)], stop_reason=StopReason.INTERRUPTED)
    verdict = judge(LEVEL.gate, result, find(LEVEL, result, Paths()))
    assert (verdict.name, verdict.exit_code) == ("fail", 130)
