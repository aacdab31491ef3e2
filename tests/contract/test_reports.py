"""What every report output owes its readers, over the whole table."""

from __future__ import annotations

import json
import xml.etree.ElementTree as ET

import numpy as np
import pytest

from reachtest.records import Report
from reachtest.report import REPORTS
from tests.unit.report.make import (
    FAIL,
    INCONCLUSIVE,
    PASS,
    make_exploration,
    make_finding,
    make_findings,
    make_level,
    make_report,
)

WEIRD = "<&\"|'>`*_]\n\r\t\x00\x1b[31m 😀 ünïcode \ud83d ]]> -->"
WEIRD_FINDINGS = (
    make_finding(title=WEIRD, nearest_named=WEIRD, id=WEIRD),
    make_finding(
        title="", id="", gating=False, suppressed_by=WEIRD, path=None, exit_point=None, nearest_named=None
    ),
)
NOTHING = make_exploration(
    goals=np.zeros((0, 3)), goal_step=np.zeros(0, dtype=np.int64), episodes=0, agent_steps=0, timing={}
)

CASES = {
    "no findings": make_report((), PASS),
    "several findings": make_report(make_findings(), FAIL),
    "weird names": make_report(WEIRD_FINDINGS, FAIL, level=make_level(name=WEIRD)),
    "inconclusive": make_report((), INCONCLUSIVE),
    "nothing was run": make_report((), INCONCLUSIVE, exploration=NOTHING),
}


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("name", REPORTS)
def test_renders_well_formed_text(name: str, case: str) -> None:
    text = REPORTS[name](CASES[case])
    assert text.endswith("\n")
    assert "\x00" not in text
    assert "\x1b" not in text
    _parse(name, text)


@pytest.mark.parametrize("name", REPORTS)
def test_the_same_report_renders_the_same(name: str) -> None:
    assert REPORTS[name](CASES["several findings"]) == REPORTS[name](make_report(make_findings(), FAIL))


@pytest.mark.parametrize("name", REPORTS)
def test_the_verdict_can_be_told_apart(name: str) -> None:
    cases: list[Report] = [CASES["no findings"], CASES["several findings"], CASES["inconclusive"]]
    assert len({REPORTS[name](case) for case in cases}) == 3


@pytest.mark.parametrize("name", REPORTS)
def test_every_gating_finding_is_named(name: str) -> None:
    text = REPORTS[name](CASES["several findings"])
    for finding in make_findings():
        assert not finding.gating or finding.id in text


def _parse(name: str, text: str) -> None:
    """Read `text` back as its file name says; strict where the format has a parser."""
    if name.endswith((".json", ".sarif")):
        json.loads(text, parse_constant=_no_constants)
    elif name.endswith(".xml"):
        ET.fromstring(text.encode("utf-8", errors="replace"))


def _no_constants(constant: str) -> None:
    raise AssertionError(f"{constant} is not JSON")
