"""What the outputs say of the nav-mesh: islands, details of a finding, goals that do not count, `--audit`."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

from reachtest.records import GateSettings, NavMesh, Report
from reachtest.report import REPORTS, console_summary
from tests.unit.report.make import (
    FLOOR,
    INCONCLUSIVE,
    PASS,
    make_exploration,
    make_finding,
    make_level,
    make_report,
)

ROOF = FLOOR + [0.0, 20.0, 5.0]
ROOFED = NavMesh("nav.glb", np.concatenate([FLOOR, ROOF]).reshape(-1, 3), np.arange(12).reshape(4, 3))
ISLAND = make_finding(kind="unreached_area", gating=False, title="1 island", details=("64 m2 | on the roof",))


def texts(report: Report) -> list[str]:
    return [REPORTS["summary.md"](report), console_summary(report, 200).plain]


def roofed(reached: list[int], verdict: Any = PASS, **changes: Any) -> Report:
    goals = np.array([[1.0, 1, 0], [3, 1, 0], [3, 22, 5]])
    exploration = make_exploration(goals=goals, goal_step=np.array(reached))
    return make_report(
        (ISLAND,), verdict, level=make_level(navmesh=ROOFED, **changes), exploration=exploration
    )


def test_coverage_tells_the_goals_of_connected_islands_apart() -> None:
    coverage = roofed([5, -1, -1]).document["coverage"]
    assert (coverage["goals_total"], coverage["goals_connected"], coverage["goals_connected_reached"]) == (
        3,
        2,
        1,
    )
    assert (coverage["islands"], coverage["islands_connected"]) == (2, 1)
    assert coverage["goals_unreached_by_mismatch"] == 0


def test_goals_that_do_not_count_are_told_beside_the_others() -> None:
    for text in texts(roofed([5, 9, -1])):
        assert "2 of 3 reached (66.6 %); 2 of the 2 that a spawn is connected to" in text


def test_junit_does_not_ask_for_goals_that_do_not_count() -> None:
    assert "goals reached" not in REPORTS["junit.xml"](roofed([5, 9, -1], INCONCLUSIVE))
    assert "1 of 2 goals reached" in REPORTS["junit.xml"](roofed([5, -1, -1], INCONCLUSIVE))


@pytest.mark.parametrize("gating", [True, False])
def test_the_details_of_a_finding_are_shown(gating: bool) -> None:
    report = make_report((dataclasses.replace(ISLAND, gating=gating),))
    assert report.document["findings"][0]["details"] == ["64 m2 | on the roof"]
    summary, console = texts(report)
    assert "<br>- 64 m2 \\| on the roof" in summary
    assert "- 64 m2 | on the roof" in console


def test_what_never_gates_is_not_said_to_be_missing_from_fail_on() -> None:
    gate = GateSettings(("unreached_area",))
    for text in texts(make_report((ISLAND,), level=make_level(gate=gate))):
        assert "no failure by itself" in text
        assert "not in fail" not in text
    for text in texts(make_report((ISLAND,))):
        assert "not in fail" in text


def test_audit_is_a_section_only_where_it_was_asked_for() -> None:
    report = make_report()
    assert not any("nav-mesh misses" in text for text in texts(report))
    entry = {
        "position": [1.0, 2.0, 3.0],
        "source_position": [100.0, 300.0, -200.0],
        "bounds": [[0.0, 0.0, 3.0], [2.0, 4.0, 3.0]],
        "points": 7,
        "nearest_named": "crate",
    }
    for listed, words in (
        ([entry], "100, 300, -200: 7 points over 2.0 x 0.0 x 4.0 m, near crate"),
        ([], "(0)"),
    ):
        asked = dataclasses.replace(report, document=report.document | {"audit": listed})
        for text in texts(asked):
            assert f"Ground that the nav-mesh misses ({len(listed)})" in text
            assert words in text
