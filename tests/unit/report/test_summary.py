"""summary.md, as a markdown renderer shows it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from markdown_it import MarkdownIt

from reachtest.records import Frame, Verdict
from reachtest.report.summary import escape, render
from tests.unit.report.make import (
    FAIL,
    INCONCLUSIVE,
    LONG,
    PASS,
    make_exploration,
    make_finding,
    make_findings,
    make_level,
    make_report,
)


def html(markdown: str) -> str:
    return str(MarkdownIt("gfm-like", {"linkify": False}).render(markdown))


def test_the_first_line_is_the_verdict_and_why() -> None:
    for verdict, word in ((PASS, "PASS"), (FAIL, "FAIL"), (INCONCLUSIVE, "INCONCLUSIVE")):
        first = render(make_report(verdict=verdict)).splitlines()[0]
        assert f"{word}: " in first
        assert verdict.reason.split(" (")[0] in first


def test_what_fails_the_build_comes_first_with_all_that_is_needed() -> None:
    text = render(make_report(make_findings(), FAIL))
    failing, others = text.split("## Does not fail the build (1)")
    for needed in (
        "Gets onto roof\\_west",
        "`1200, 520, -100`",  # (12, 1, 5.2) in cm, y up
        "near roof\\_west",
        "left the nav-mesh at `400, 0, -200`",
        "41 points over 8.0 x 1.1 x 3.2 m",
        "9.6 s from the spawn, reproduced 5 of 5",
        "run.mcap",
    ):
        assert needed in failing
    assert "Cannot move any more" in others
    assert "suppressed by baseline.json" in others.split("## Known bugs (1)")[1]


@pytest.mark.parametrize(
    ("scale", "units", "pasted"), [(1.0, "m", "1.25, 2.00, 3.00"), (0.0254, "in", "49.2, 78.7, 118.1")]
)
def test_positions_are_to_a_centimetre_in_the_files_units(scale: float, units: str, pasted: str) -> None:
    level = make_level(frame=Frame(scale * np.eye(3), "z", units))
    finding = make_finding(position=np.array([1.25, 2.0, 3.0]))
    text = render(make_report((finding,), FAIL, level=level))
    assert f"`{pasted}`" in text
    assert f"(z up, {units})" in text


def test_almost_all_goals_is_not_100_percent() -> None:
    steps = np.zeros(10_000, dtype=np.int64)
    steps[17] = -1
    exploration = make_exploration(goals=np.zeros((10_000, 3)), goal_step=steps)
    assert "9,999 of 10,000 reached (99.9 %)" in render(make_report(exploration=exploration))


def test_the_way_on_depends_on_the_outcome() -> None:
    assert "run longer, for example with --steps 400000" in render(make_report(verdict=INCONCLUSIVE))
    nowhere = make_exploration(goal_step=np.full(3, -1))
    assert "check the spawn" in render(make_report(verdict=INCONCLUSIVE, exploration=nowhere))
    assert "paste a position" in render(make_report(make_findings(), FAIL))


def test_the_whole_reason_is_in_the_first_line() -> None:
    assert render(make_report(verdict=LONG)).splitlines()[0].endswith(LONG.reason)


def test_where_everything_was_reached_no_place_is_cut_off() -> None:
    everywhere = make_exploration(goal_step=np.array([0, 640, 902]))
    text = render(make_report(verdict=INCONCLUSIVE, exploration=everywhere))
    assert "everything was reached, but new places are still being found" in text
    assert "cut off" not in text


def test_a_pass_says_what_risk_remains() -> None:
    steps = np.array([0, 640, 902])
    assert "**Next:** nothing to do." in render(make_report(verdict=PASS))
    open_ = make_exploration(goal_step=steps, cells_once=1_250)
    assert "may still find a new place (up to 80 %)" in render(make_report(exploration=open_))
    accepted = make_level(gate=replace(make_level().gate, max_discovery_probability=0.9))
    assert "nothing to do" in render(make_report(exploration=open_, level=accepted))


def test_thousands_of_findings_stay_readable() -> None:
    findings = tuple(make_finding(id=f"f-{number}", title="x" * 5_000) for number in range(3_000))
    text = render(make_report(findings, FAIL))
    assert "...and 2,950 more" in text
    assert len(text.encode()) < 2**20 / 10
    assert html(text).count("<tr>") == 51


@pytest.mark.parametrize(
    "name",
    [
        "a|b",
        "<b>bold</b>",
        "`code`",
        "*star* _under_",
        "[link](http://x)",
        "a\nb",
        "~~no~~",
        "&amp;",
        "😀",
        "\\",
    ],
)
def test_names_are_shown_as_they_are(name: str) -> None:
    findings = (make_finding(title=name, nearest_named=name), make_finding(gating=False, suppressed_by=name))
    level = make_level(name=name)
    page = html(render(make_report(findings, Verdict("fail", 1, name), level=level)))
    literal = name.replace("\n", " ").replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
    for where in (f"FAIL: {literal}</h1>", f"<strong>{literal}</strong><br>", f"<br>near {literal}<br>"):
        assert where in page
    assert f"suppressed by {literal}</td>" in page
    assert page.count("<tr>") == 4  # two tables of a header and one row each


def test_escape_makes_one_line() -> None:
    assert escape("a\r\nb\x1b[31m\tc") == "a b \\[31m c"
