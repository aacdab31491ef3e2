"""junit.xml, as a CI system reads it."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from dataclasses import replace

import numpy as np

from reachtest.records import Report
from reachtest.report.junit import render
from tests.unit.report.make import (
    FAIL,
    INCONCLUSIVE,
    LONG,
    make_exploration,
    make_finding,
    make_findings,
    make_level,
    make_report,
)


def outcomes(report: Report) -> dict[str, str]:
    """Name -> "passed" or the tag of what went wrong, for every test case."""
    cases = list(ET.fromstring(render(report)).iter("testcase"))
    assert len({case.get("name") for case in cases}) == len(cases)
    return {str(case.get("name")): case[0].tag if len(case) else "passed" for case in cases}


def test_a_pass_passes_every_gating_kind() -> None:
    assert outcomes(make_report()) == {
        "unexpected_area": "passed",
        "fell_out_of_world": "passed",
        "goals_reached": "passed",
        "explored_enough": "passed",
    }


def test_each_gating_finding_is_one_failure_with_its_id() -> None:
    all_goals = make_exploration(goal_step=np.array([0, 640, 902]))
    assert outcomes(make_report(make_findings(), FAIL, exploration=all_goals)) == {
        "unexpected_area [area-0c11d4]": "failure",
        "fell_out_of_world [fell-5f2a91]": "failure",
        "fell_out_of_world [area-99aa01]": "skipped",
        "goals_reached": "passed",
        "explored_enough": "passed",
    }


def test_a_failure_says_what_and_where() -> None:
    root = ET.fromstring(render(make_report((make_finding(),), FAIL)))
    failure = next(root.iter("failure"))
    assert failure.get("message") == "Falls out of the world beside floor_12 at 400, -1000, -300"
    assert failure.get("type") == "fell_out_of_world"
    for needed in ("near floor_12", "y up, cm", "left the nav-mesh at 400, 0, -200", "reproduced 5 of 5"):
        assert needed in str(failure.text)


def test_an_inconclusive_run_has_not_explored_enough_and_says_all_of_why() -> None:
    report = make_report(verdict=LONG)
    assert [name for name, outcome in outcomes(report).items() if outcome == "error"] == [
        "goals_reached",
        "explored_enough",
    ]
    assert LONG.reason in [error.get("message") for error in ET.fromstring(render(report)).iter("error")]
    enough = make_exploration(goal_step=np.array([0, 640, 902]))
    unsure = outcomes(make_report(verdict=INCONCLUSIVE, exploration=enough))
    assert [name for name, outcome in unsure.items() if outcome == "error"] == ["explored_enough"]


def test_goals_that_were_given_up_are_not_missing() -> None:
    verdict = replace(FAIL, goals_given_up=1)  # of three, two were reached
    assert outcomes(make_report(make_findings(), verdict))["goals_reached"] == "passed"
    assert outcomes(make_report(make_findings(), FAIL))["goals_reached"] == "failure"


def test_the_counts_match_the_cases() -> None:
    suite = ET.fromstring(render(make_report(make_findings(), FAIL)))[0]
    for attribute, tag in (
        ("tests", "testcase"),
        ("failures", "failure"),
        ("errors", "error"),
        ("skipped", "skipped"),
    ):
        assert int(str(suite.get(attribute))) == len(list(suite.iter(tag)))
    assert (suite.get("failures"), suite.get("time")) == ("3", "63.200")


def test_what_does_not_gate_is_mentioned_but_fails_nothing() -> None:
    stuck = make_finding(kind="stuck", gating=False, title="Cannot move at crate_3")
    report = make_report((stuck,))
    assert set(outcomes(report).values()) == {"passed"}
    assert "Cannot move at crate_3" in str(ET.fromstring(render(report)).findtext(".//system-out"))


def test_characters_that_xml_cannot_hold_are_dropped() -> None:
    names = 'a\x00b\x0bc\ufffed\ud800e <&"|> \n f 😀'
    report = make_report((make_finding(title=names, id=names),), FAIL, level=make_level(name=names))
    message = str(next(ET.fromstring(render(report).encode()).iter("failure")).get("message"))
    assert '<&"|> f 😀' in message
