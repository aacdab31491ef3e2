"""Confirmed findings say how often they came about; fragile ones stand apart and fail nothing."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from dataclasses import replace

import pytest

from reachtest.records import Confirmation
from reachtest.report import REPORTS, console_summary
from tests.unit.report.make import FAIL, make_finding, make_path, make_report

CONFIRMED = make_finding(confirmation=Confirmation((2, 2), (33, 31), (32, 29)))
FRAGILE = make_finding(
    id="fell-00aa11",
    title="Falls through a wall",
    confirmation=Confirmation((2, 2), (132, 0), (32, 17)),
    fragile=True,
    gating=False,
)
UNREPRODUCED = make_finding(
    id="fell-22bb33", confirmation=Confirmation((2, 1), (33, 31), (32, 29)), fragile=True, gating=False
)
REPORT = make_report((CONFIRMED, FRAGILE, UNREPRODUCED), FAIL)


@pytest.mark.parametrize("text", [REPORTS["summary.md"](REPORT), console_summary(REPORT, 500).plain])
def test_people_read_what_was_confirmed_and_what_is_fragile(text) -> None:
    heading = text.index("Fragile: not confirmed (2)")
    confirmed, fragile = text[:heading], text[heading:]
    assert "2 of 2 exactly, 31 of 33 at half the time step, 29 of 32 with other actions" in confirmed
    assert "Falls through a wall" in fragile
    assert "Falls through a wall" not in confirmed
    assert "0 of 132" in fragile
    assert "bit for bit" in fragile
    assert "Does not fail the build" not in text


def test_junit_skips_fragile_findings() -> None:
    root = ET.fromstring(REPORTS["junit.xml"](REPORT).split("\n", 1)[1])
    assert [failure.get("type") for failure in root.findall(".//failure")] == [
        "fell_out_of_world",
        "goals_reached",
    ]
    skipped = {
        case.get("name"): case.find("skipped").get("message")
        for case in root.iter("testcase")
        if case.find("skipped") is not None
    }
    assert set(skipped) == {"fell_out_of_world [fell-00aa11]", "fell_out_of_world [fell-22bb33]"}
    assert all(message.startswith("fragile: ") for message in skipped.values())


def test_programs_read_it_too() -> None:
    first, second, _ = REPORT.document["findings"]
    assert (first["fragile"], second["fragile"]) == (False, True)
    assert second["confirmation"]["half_step"] == {"attempts": 132, "succeeded": 0}
    assert first["path"]["found_duration_s"] == first["path"]["duration_s"] == 9.6
    (unknown,) = make_report((make_finding(path=None),), FAIL).document["findings"]
    assert unknown["confirmation"] is None


def test_a_cut_way_says_how_long_it_was() -> None:
    cut = replace(CONFIRMED, path=replace(make_path(), found_s=21.7))
    assert "9.6 s from the spawn (found in 21.7 s)" in console_summary(make_report((cut,), FAIL), 500).plain
