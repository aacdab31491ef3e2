"""What changed between two runs, from hand-made output folders."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from reachtest.diffing import RENDERERS, compare
from reachtest.errors import BadInput
from reachtest.records import RiskSample
from reachtest.report.write import write_coverage, write_reports
from reachtest.results import Result, read_result
from tests.unit.report.make import FAIL, PASS, make_exploration, make_finding, make_level, make_report

CHANGED = make_level(sha256="cd" * 32)
KNOWN = make_finding()
MOVED = replace(KNOWN, id="another id", exit_point=np.array([5.0, 2.5, 0]))
OTHER = make_finding(id="other", title="Another hole | <b>", exit_point=np.array([60.0, 0, 0]))
GOALS = np.array([[x, 0, 0] for x in np.arange(0, 60, 4.0)])


def run(folder: Path, *findings, reached=None, stood=(), enough=True, level=None, **exploration) -> Result:
    """An output folder; `reached` says which of GOALS were, `stood` adds places where somebody stood."""
    explored = make_exploration(**exploration)
    if reached is not None:
        steps = np.where(reached, 5, -1)
        explored = replace(explored, goals=GOALS, goal_step=steps)
        places = np.concatenate([GOALS[steps >= 0], np.array(stood, dtype=float).reshape(-1, 3)])
        n = len(places)
        off = np.where(np.arange(n) < (steps >= 0).sum(), 0.0, np.inf)
        made = replace(explored.points, positions=places, off_mesh_m=off, grounded=np.ones(n, dtype=bool))
        explored = replace(explored, points=made)
    report = make_report(findings, FAIL if findings else PASS, level=level, exploration=explored)
    report.document["coverage"]["sufficient"] = enough
    folder.mkdir()
    write_reports(report, folder)
    write_coverage(report, folder)
    return read_result(folder)


def told(old: Result, new: Result) -> Any:
    return json.loads(RENDERERS["json"](compare(old, new)))


def ids(document: Any) -> dict[str, list[str]]:
    return {name: [f["id"] for f in found] for name, found in document["findings"].items()}


def test_new_fixed_and_still_there_go_by_place_not_by_id(tmp_path) -> None:
    document = told(run(tmp_path / "a", KNOWN, OTHER), run(tmp_path / "b", MOVED, level=CHANGED))
    told_of = {"new": [], "worse": [], "fixed": ["other"], "not_seen": [], "still_there": ["another id"]}
    assert ids(document) == told_of
    assert document["findings"]["still_there"][0]["old_id"] == KNOWN.id
    assert document["exit_code"] == 0
    back = told(read_result(tmp_path / "b"), read_result(tmp_path / "a"))
    assert ids(back)["new"] == ["other"]
    assert back["exit_code"] == 1


def test_a_new_finding_that_does_not_gate_fails_nothing(tmp_path) -> None:
    document = told(run(tmp_path / "a"), run(tmp_path / "b", replace(OTHER, gating=False)))
    assert ids(document)["new"] == ["other"]
    assert document["exit_code"] == 0


def test_a_part_that_is_cut_off_is_new_beside_islands_that_nothing_connects(tmp_path) -> None:
    remark = make_finding(id="islands", kind="unreached_area", gating=False, exit_point=None, exits=None)
    cut_off = replace(remark, id="cut off", gating=True)
    document = told(run(tmp_path / "a", remark), run(tmp_path / "b", remark, cut_off, level=CHANGED))
    assert ids(document)["new"] == ["cut off"]
    assert ids(document)["still_there"] == ["islands"]
    assert document["exit_code"] == 1
    again = told(read_result(tmp_path / "b"), read_result(tmp_path / "b"))
    assert ids(again)["new"] == []
    known = replace(cut_off, gating=False, suppressed_by="baseline: x")
    assert ids(told(run(tmp_path / "c", known), read_result(tmp_path / "b")))["new"] == []


@pytest.mark.parametrize(
    ("changes", "doubt"),
    [
        ({"level": CHANGED, "enough": False}, "too short"),
        ({"level": CHANGED, "cells_once": 900}, "new places"),
        ({}, "still the same"),
    ],
)
def test_fixed_is_said_only_where_the_new_run_can_tell(tmp_path, changes, doubt) -> None:
    old, new = run(tmp_path / "a", KNOWN), run(tmp_path / "b", **changes)
    document = told(old, new)
    assert ids(document)["not_seen"] == [KNOWN.id]
    assert ids(document)["fixed"] == []
    assert doubt in document["findings"]["not_seen"][0]["doubt"]
    assert "Fixed (0)" in RENDERERS["text"](compare(old, new))


def test_what_the_latest_episodes_found_counts_as_risk(tmp_path) -> None:
    late = RiskSample(1_000, 500, 300, 1, 1, 410, 100, 77, 3, 4)
    new = run(tmp_path / "b", level=CHANGED, cells_once=1, risk_curve=(late,))
    assert ids(told(run(tmp_path / "a", KNOWN), new))["fixed"] == []


def test_a_fall_where_somebody_only_stood_is_worse_and_new(tmp_path) -> None:
    stood = replace(KNOWN, id="stood", kind="unexpected_area")
    old, new = run(tmp_path / "a", stood), run(tmp_path / "b", KNOWN, level=CHANGED)
    document = told(old, new)
    assert [(f["id"], f["old_id"]) for f in document["findings"]["worse"]] == [(KNOWN.id, "stood")]
    assert ids(document)["new"] == [KNOWN.id]
    assert ids(document)["fixed"] == ids(document)["not_seen"] == []
    assert "Got worse (1)" in RENDERERS["text"](compare(old, new))


def test_areas_that_became_unreachable_and_reachable(tmp_path) -> None:
    west = GOALS[:, 0] < 30
    old = run(tmp_path / "a", reached=np.ones(len(GOALS), dtype=bool))
    new = run(tmp_path / "b", reached=west, stood=[[0, 40, 6], [3, 43, 6]], cells_once=900)
    areas = told(old, new)["areas"]
    (lost,), (won,) = areas["became_unreachable"], areas["became_reachable"]
    assert (lost["goals"], lost["on_navmesh"]) == (7, True)
    assert lost["bounds"] == [[32, 0, 0], [56, 0, 0]]
    x, y, z = lost["position"]
    assert lost["source_position"] == pytest.approx([100 * x, 100 * z, -100 * y])  # cm, y up
    assert (won["goals"], won["on_navmesh"]) == (0, False)
    assert won["position"][2] == 6
    text = RENDERERS["text"](compare(old, new))
    assert "Became unreachable, may be chance (1)" in text
    assert "(on the nav-mesh, 7 goals and 6 places over 24 x 0 x 0 m)" in text


def test_one_lost_goal_is_told_in_the_singular_and_without_a_size(tmp_path) -> None:
    everywhere = np.ones(len(GOALS), dtype=bool)
    old = run(tmp_path / "a", reached=everywhere)
    new = run(tmp_path / "b", reached=GOALS[:, 0] != 20, stood=[[20, 0, 0]])
    assert "(on the nav-mesh, 1 goal)" in RENDERERS["text"](compare(old, new))


def test_the_same_run_has_no_areas_and_chance_is_ruled_out_by_saturation(tmp_path) -> None:
    everywhere = np.ones(len(GOALS), dtype=bool)
    one = run(tmp_path / "a", reached=everywhere, cells_once=1)
    other = run(tmp_path / "b", reached=everywhere, cells_once=1, seed=8, agent_steps=100)
    unsure = run(tmp_path / "c", reached=everywhere, cells_once=900)
    document = told(one, other)
    assert document["areas"] == {"may_be_chance": False, "became_unreachable": [], "became_reachable": []}
    assert told(one, unsure)["areas"]["may_be_chance"]
    assert "seeds 7 and 8" in " ".join(document["notes"])
    assert "agent steps" in " ".join(document["notes"])


def test_goals_of_a_changed_navmesh_are_compared_by_place(tmp_path) -> None:
    old = run(tmp_path / "a", reached=np.ones(len(GOALS), dtype=bool))
    shifted = make_exploration(goals=GOALS + [1.0, 1.0, 0], goal_step=np.where(GOALS[:, 0] < 30, 5, -1))
    stood = replace(shifted.points, positions=np.array([[0.0, 0, 0], [8, 0, 0], [16, 0, 0], [24, 0, 0]]))
    new = run(tmp_path / "b", goals=shifted.goals, goal_step=shifted.goal_step, points=stood)
    (lost,) = told(old, new)["areas"]["became_unreachable"]
    assert lost["bounds"][0][0] >= 28
    assert lost["bounds"][1][0] == 56


def test_a_changed_level_is_said_and_another_level_refused(tmp_path) -> None:
    old = run(tmp_path / "a")
    assert any(
        "changed" in note for note in told(old, run(tmp_path / "b", level=make_level(sha256="00")))["notes"]
    )
    with pytest.raises(BadInput, match=r"'cellar'.*'hall'"):
        compare(old, run(tmp_path / "c", level=make_level(name="cellar")))


def test_a_report_alone_is_compared_but_for_areas(tmp_path) -> None:
    old, new = run(tmp_path / "a", KNOWN), run(tmp_path / "b", KNOWN)
    (tmp_path / "a" / "coverage.json").unlink()
    document = told(read_result(tmp_path / "a" / "report.json"), new)
    assert document["areas"] is None
    assert ids(document)["still_there"] == [KNOWN.id]
    assert any("coverage.json" in note for note in document["notes"])
    assert compare(old, new).unreachable == ()


def test_markdown_shows_titles_as_they_are(tmp_path) -> None:
    text = RENDERERS["markdown"](compare(run(tmp_path / "a"), run(tmp_path / "b", OTHER)))
    assert r"Another hole \| \<b\>" in text
    assert "## New (1)" in text
