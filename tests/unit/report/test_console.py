"""What the terminal shows at the end of a run."""

from __future__ import annotations

import io

import numpy as np
import pytest
from rich.console import Console

from reachtest.report import console_summary, summary
from tests.unit.report.make import FAIL, INCONCLUSIVE, LONG, PASS, make_finding, make_findings, make_report


@pytest.mark.parametrize("width", [40, 80, 132])
def test_no_line_is_wider_than_the_terminal(width: int) -> None:
    text = console_summary(make_report(make_findings(), FAIL), width).plain
    assert max(map(len, text.splitlines())) <= width


def test_the_verdict_and_every_finding_are_there() -> None:
    text = console_summary(make_report(make_findings(), FAIL), 100).plain
    assert text.splitlines()[0] == f"FAIL  hall: {FAIL.reason}"
    for needed in (
        "1200, 520, -100",
        "near roof_west",
        "reproduced 5 of 5",
        "fell-5f2a91",
        "stuck is not in fail_on",
    ):
        assert needed in text
    assert text.splitlines()[-1].startswith(("Next", "  "))


def test_ten_seconds_of_reading_at_most() -> None:
    findings = tuple(make_finding(id=f"f-{number}") for number in range(500))
    lines = console_summary(make_report(findings, FAIL), 80).plain.splitlines()
    assert len(lines) < 90
    assert any("...and 490 more in summary.md" in line for line in lines)


def test_a_pass_is_short() -> None:
    lines = console_summary(make_report(verdict=PASS), 100).plain.splitlines()
    assert lines[0].startswith("PASS  hall")
    assert len(lines) < 12


def test_the_whole_reason_is_there_and_the_next_step_goes_by_its_estimate() -> None:
    text = " ".join(console_summary(make_report(verdict=LONG), 80).plain.split())
    assert LONG.reason in text
    assert "--steps 723000" in text


def test_a_known_bug_names_author_and_expiry_whatever_the_reason() -> None:
    report = make_report((make_finding(gating=False, suppressed_by="baseline"),))
    told = {"reason": "so it is " * 50, "author": "Mia", "expires": "2030-05-31", "title": "A hole"}
    known = {"finding": make_finding().id, "id": "known-1", "kind": "stuck", "position": [4, 3, -10], **told}
    report.document["baseline"] = {"known": [known], "expired": [], "worse": [], "fixed": [], "not_seen": []}
    assert "(Mia, until 2030-05-31)" in " ".join(console_summary(report, 80).plain.split())
    assert "(Mia, until 2030-05-31)" in summary.render(report)


def test_what_became_of_a_known_bug_is_told_with_title_and_place() -> None:
    report = make_report()
    told = {"id": "known-1", "kind": "stuck", "title": "A hole", "position": [4, 3, -10]}
    report.document["baseline"] = {
        "known": [],
        "expired": [],
        "worse": [{**told, "finding": "fall-1"}],
        "fixed": [told],
        "not_seen": [{**told, "doubt": "the run was too short"}],
    }
    text = " ".join(console_summary(report, 80).plain.split())
    hole = "A hole at 400, -1000, -300 (known-1)"
    assert f"got worse: {hole}, now fall-1" in text
    assert f"; fixed: {hole}" in text
    assert f"not shown to be fixed (the run was too short): {hole}" in text


def test_colour_follows_the_verdict() -> None:
    styles = {
        verdict.name: console_summary(make_report(verdict=verdict), 80).spans[0].style
        for verdict in (PASS, FAIL, INCONCLUSIVE)
    }
    assert [style.split()[-1] for style in map(str, styles.values())] == ["green", "red", "yellow"]


def test_names_from_the_level_cannot_steer_the_terminal() -> None:
    finding = make_finding(
        title="door\x1b]0;owned\x07 [bold]x[/bold]", nearest_named="a\nb", position=np.zeros(3)
    )
    stream = io.StringIO()
    Console(file=stream, width=80, force_terminal=False).print(
        console_summary(make_report((finding,), FAIL), 80)
    )
    printed = stream.getvalue()
    assert "\x1b" not in printed
    assert "\x07" not in printed
    assert "[bold]x[/bold]" in printed
    assert "near a b" in printed
