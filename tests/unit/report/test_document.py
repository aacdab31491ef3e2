"""report.json's content: the contract other programs read."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from reachtest.records import StopReason
from reachtest.report.run_wording import run_facts
from tests.unit.report.make import (
    FAIL,
    make_exploration,
    make_finding,
    make_findings,
    make_level,
    make_report,
)

CONTRACT = {
    "": (
        "schema_version tool verdict exit_code stop_reason level config seed run coverage positions risk "
        "findings timing"
    ),
    "tool": "name version",
    "level": "name file sha256",
    "run": "agent_steps episodes agents diverged_episodes",
    "coverage": "goals_total goals_reached goals_unreached goals_reached_fraction",
    "positions": "discovered expected unexpected",
    "risk": "discovery_probability estimated_positions_total unit",
    "timing": "started_at wall_s agent_steps_per_s physics_s cache_s",
}
FINDING = (
    "id kind severity gating title position source_position bounds points exit_point nearest_named "
    "first_seen_step reproduced confirmation fragile path suppressed_by exits details"
)


def document(**changes: Any) -> dict[str, Any]:
    return make_report(make_findings(), FAIL, exploration=make_exploration(**changes)).document


@pytest.mark.parametrize("section", CONTRACT)
def test_every_key_of_the_contract_in_its_order(section: str) -> None:
    found = document()[section] if section else document()
    promised = CONTRACT[section].split()
    assert [key for key in found if key in promised] == promised


def test_every_key_of_a_finding_in_its_order() -> None:
    for finding in document()["findings"]:
        assert list(finding) == FINDING.split()
        assert list(finding["reproduced"]) == ["attempts", "succeeded"]


def test_only_timing_depends_on_clock_and_machine() -> None:
    slow = {"wall_s": 999.0, "physics_s": 1.0, "cache_s": 2.0, "rest_s": 3.0, "threads": 64.0}
    one, other = document(), document(timing=slow)
    assert one.pop("timing") != other.pop("timing")
    assert one == other
    assert "threads" not in json.dumps(one)


def test_the_folder_of_the_level_does_not_matter() -> None:
    there = make_report(level=make_level(file=Path("/elsewhere/hall.yaml"))).document
    assert there["level"] == make_report().document["level"]
    assert "/" not in there["level"]["file"]


def test_positions_are_given_in_both_axes() -> None:
    [finding] = make_report((make_finding(position=np.array([1.0, 2.0, 3.0])),)).document["findings"]
    assert finding["position"] == [1.0, 2.0, 3.0]
    assert finding["source_position"] == [100.0, 300.0, -200.0]  # cm, y up: (x, z, -y)


def test_positions_are_rounded_to_a_millimetre() -> None:
    [finding] = make_report((make_finding(position=np.array([1 / 3, -1e-9, 2.0])),)).document["findings"]
    assert finding["position"] == [0.333, 0.0, 2.0]
    assert str(finding["position"][1]) == "0.0"


def test_what_is_not_known_is_null() -> None:
    unknown = make_finding(exit_point=np.full(3, np.nan), path=None, first_seen_step=None, nearest_named=None)
    [finding] = make_report((unknown,)).document["findings"]
    assert [finding[key] for key in ("exit_point", "path", "first_seen_step", "nearest_named")] == [None] * 4
    assert finding["reproduced"] == {"attempts": 0, "succeeded": 0}


def test_a_path_can_be_replayed_from_the_report() -> None:
    path = document()["findings"][0]["path"]
    assert path["start"] == [1.0, 1.0, 0.0]
    assert path["episodes"][1] == {"parent": 17, "round": 2, "agent": 5, "start": 0, "step": 31}
    assert path["duration_s"] == 9.6


def test_coverage_counts_goals() -> None:
    coverage = document()["coverage"]
    assert (coverage["goals_total"], coverage["goals_reached"], coverage["goals_unreached"]) == (3, 2, 1)
    assert coverage["goals_reached_fraction"] == pytest.approx(2 / 3, abs=1e-6)
    assert coverage["all_goals_step"] is None
    assert document(goal_step=np.array([0, 640, 902]))["coverage"]["all_goals_step"] == 902


def test_positions_are_split_by_the_nav_mesh() -> None:
    assert document()["positions"] == {"discovered": 4, "expected": 3, "unexpected": 1}


def test_risk_is_good_turing_and_chao2() -> None:
    # by hand: 12 / 1563; 410 + 1562/1563 * 12^2 / (2 * 6)
    risk = document()["risk"]
    promised = {"discovery_probability": 0.007678, "estimated_positions_total": 422.0, "unit": "episode"}
    assert {key: risk[key] for key in promised} == promised


def test_risk_when_no_cell_was_visited_twice() -> None:
    # 100 + 3/4 * 12 * 11 / 2, and 12 new cells in 4 episodes are no probability of 3
    risk = document(episodes=4, cells_once=12, cells_twice=0, cells_total=100)["risk"]
    assert (risk["discovery_probability"], risk["estimated_positions_total"]) == (1.0, 149.5)


def test_nothing_run_is_no_evidence() -> None:
    empty = make_exploration(
        episodes=0, agent_steps=0, cells_once=0, cells_twice=0, cells_total=0, timing={},
        goals=np.zeros((0, 3)), goal_step=np.zeros(0, dtype=np.int64),
    )  # fmt: skip
    found = make_report(exploration=empty).document
    assert found["risk"]["discovery_probability"] is None
    assert found["coverage"]["goals_reached_fraction"] is None
    assert found["timing"]["agent_steps_per_s"] is None


def test_config_holds_everything_in_force() -> None:
    config = document(settings=dataclasses.replace(make_exploration().settings, steps=77, agents=3))["config"]
    assert config["explore"]["steps"] == 77
    assert config["character"]["step_height_m"] == 0.45
    assert config["gate"]["fail_on"] == ["unexpected_area", "fell_out_of_world"]
    assert config["kill_z_m"] == -10.0
    assert config["bounds"] == [[-20.0, -20.0, -10.0], [28.0, 28.0, 30.0]]
    assert config["spawns"] == [{"name": "start", "position": [1.0, 1.0, 0.0]}]
    assert config["zones"][0]["kind"] == "forbidden"
    assert config["required"][0]["name"] == "door"


@pytest.mark.parametrize("reason", StopReason)
def test_stop_reason_is_a_word_for_programs(reason: StopReason) -> None:
    assert document(stop_reason=reason)["stop_reason"] == reason.name.lower()


def test_the_border_is_told_in_the_document_and_in_words() -> None:
    pushes = np.array([0, 3, 5, 1_200])
    report = make_report(exploration=make_exploration(border=np.zeros((4, 3)), border_pushes=pushes))
    border = report.document["coverage"]["border"]
    assert border == {"places": 4, "pushed": 3, "pushes_least": 0, "pushes_median": 4.0}
    sentence = "3 of 4 places along the nav-mesh's border were pushed at, half of them at least 4 times"
    assert ("Border", sentence) in run_facts(report)


def test_where_no_border_is_known_nothing_is_said_of_it() -> None:
    report = make_report(exploration=make_exploration())
    assert report.document["coverage"]["border"]["pushes_least"] is None
    assert "Border" not in dict(run_facts(report))
