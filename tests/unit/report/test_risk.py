"""The risk in report.json, and what a designer reads of it."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest

from reachtest.records import Report, RiskSample
from reachtest.report.risk import sparkline
from reachtest.report.summary import render
from tests.unit.report.make import PASS, make_exploration, make_report

CURVE = tuple(
    RiskSample(1_000 * n, 10 * n, 5 * n, 400 // n, 40, 100 + 20 * n, 100, found, n, 50 * n)
    for n, found in enumerate((100, 60, 30, 10, 0), start=1)
)


ALL_REACHED = np.array([0, 640, 902])


def report(**changes: Any) -> Report:
    exploration = make_exploration(**{"risk_curve": CURVE, "goal_step": ALL_REACHED} | changes)
    return make_report(verdict=PASS, exploration=exploration)


def test_the_curve_says_what_was_known_when() -> None:
    curve = report().document["risk"]["curve"]
    assert [sample["agent_steps"] for sample in curve] == [1_000, 2_000, 3_000, 4_000, 5_000]
    assert [sample["recent_share"] for sample in curve] == [1.0, 0.6, 0.3, 0.1, 0.0]
    assert curve[1] == {
        "agent_steps": 2_000,
        "episodes": 20,
        "discovering": 10,
        "cells": 140,
        "discovery_probability": 1.0,  # 200 cells seen once in 20 episodes
        "recent_share": 0.6,
        "estimated_positions_total": 615.0,  # 140 + 19/20 * 200^2 / (2 * 40)
        "goals_reached": 2,
        "points": 100,
    }
    json.dumps(curve, allow_nan=False)


def test_nothing_new_lately_is_no_proof_that_there_is_nothing() -> None:
    recent = report().document["risk"]["recent"]
    assert (recent["episodes"], recent["discovering"], recent["share"], recent["low"]) == (100, 0, 0.0, 0.0)
    assert recent["high"] == pytest.approx(0.037, abs=1e-4)  # Wilson: z^2 / (n + z^2) with z = 1.96


def test_a_longer_run_is_bracketed() -> None:
    longer = report().document["risk"]["ten_times_longer"]
    assert longer["positions_low"] == pytest.approx(200 + 49 / 50 * 80**2 / 80)
    assert longer["positions_high"] == pytest.approx(200 + (80 + 2 * 80**0.5) * 2.302585, abs=0.1)


@pytest.mark.parametrize("changes", [{"risk_curve": CURVE[:1]}, {"goal_step": np.array([0, 640, -1])}])
def test_nothing_is_foretold_while_new_ground_opens_up(changes: dict[str, Any]) -> None:
    early = report(**changes)
    assert early.document["risk"]["ten_times_longer"] is None
    assert "too early to tell" in render(early)


def test_a_designer_sees_how_it_went() -> None:
    assert sparkline(report()) == "█▅▃▁▁"
    text = render(report())
    assert "`█▅▃▁▁`" in text
    assert "0 % of the latest 100 episodes found a new place (0 to 3.7 %)" in text


def test_a_report_without_a_curve_says_nothing_of_it() -> None:
    old = make_report(verdict=PASS)
    assert old.document["risk"]["curve"] == []
    assert "new place, over the run" not in render(old)
    assert "latest" not in render(old)
