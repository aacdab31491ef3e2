"""`reachtest baseline update`: what it adds, and what it leaves alone."""

from __future__ import annotations

from dataclasses import replace
from datetime import date
from pathlib import Path
from textwrap import indent

import numpy as np
import pytest

from reachtest.baseline import read_baseline
from reachtest.baseline.update import Note, update_baseline
from reachtest.errors import BadInput
from reachtest.records import Finding
from reachtest.report.write import write_coverage, write_reports
from reachtest.results import Result, read_result
from tests.unit.report.make import FAIL, PASS, make_finding, make_level, make_report

NOTE = Note("ticket 7", "Mia", date(2030, 5, 1), None)
ELSEWHERE = make_finding(id="fell_out_of_world-aaaabbbb", exit_point=np.array([60.0, 0, 0]))


def result(folder: Path, *findings: Finding, enough: bool = True, sha256: str = "ab" * 32) -> Result:
    report = make_report(findings, FAIL if findings else PASS, level=make_level(sha256=sha256))
    report.document["coverage"]["sufficient"] = enough
    folder.mkdir(exist_ok=True)
    write_reports(report, folder)
    write_coverage(report, folder)
    return read_result(folder)


def test_gating_findings_are_written_and_then_known(tmp_path) -> None:
    quiet = make_finding(gating=False, exit_point=np.array([-60.0, 0, 0]))
    run, file = result(tmp_path / "out", make_finding(), ELSEWHERE, quiet), tmp_path / "known.yaml"
    done = update_baseline(file, run, NOTE)
    assert (len(done.added), done.kept) == (2, 0)
    entries = read_baseline(file, "hall").entries
    assert [(e.id, e.reason, e.author, e.added, e.expires) for e in entries] == [
        (make_finding().id, "ticket 7", "Mia", date(2030, 5, 1), None),
        (ELSEWHERE.id, "ticket 7", "Mia", date(2030, 5, 1), None),
    ]
    assert not update_baseline(file, run, NOTE).added


@pytest.mark.parametrize("margin", ["", "  "])
def test_what_stands_there_stays_byte_for_byte(tmp_path, margin: str) -> None:
    file = tmp_path / "known.yaml"
    update_baseline(file, result(tmp_path / "one", make_finding()), NOTE)
    head, entries = file.read_text().split("entries:\n")
    entries = indent(entries.replace("- id", "# asked Mia, 3 May\n- id"), margin)
    before = f"{head}entries:\n{entries}"
    file.write_text(before)
    update_baseline(file, result(tmp_path / "two", make_finding(), ELSEWHERE), replace(NOTE, reason="other"))
    assert file.read_text().startswith(before)
    assert [e.reason for e in read_baseline(file, "hall").entries] == ["ticket 7", "other"]


def test_a_file_laid_out_in_another_way_is_extended_too(tmp_path) -> None:
    file = tmp_path / "known.yaml"
    update_baseline(file, result(tmp_path / "one", make_finding()), NOTE)
    text = file.read_text()
    file.write_text(text.replace("level: hall\n", "") + "level: hall\n")
    update_baseline(file, result(tmp_path / "two", ELSEWHERE), NOTE)
    assert [e.id for e in read_baseline(file, "hall").entries] == [make_finding().id, ELSEWHERE.id]


def test_only_takes_the_named_findings_and_names_the_known_ids(tmp_path) -> None:
    run, file = result(tmp_path / "out", make_finding(), ELSEWHERE), tmp_path / "known.yaml"
    assert [e.id for e in update_baseline(file, run, NOTE, only=[ELSEWHERE.id]).added] == [ELSEWHERE.id]
    with pytest.raises(BadInput, match=r"no finding 'typo'.*aaaabbbb"):
        update_baseline(file, run, NOTE, only=["typo"])


def test_an_expired_bug_that_is_still_there_gets_a_new_entry(tmp_path) -> None:
    run, file = result(tmp_path / "out", make_finding()), tmp_path / "known.yaml"
    update_baseline(file, run, replace(NOTE, expires=date(2030, 5, 2)))
    later = replace(NOTE, today=date(2030, 6, 1), reason="took longer")
    assert [e.reason for e in update_baseline(file, run, later).added] == ["took longer"]
    entries = read_baseline(file, "hall").entries
    assert len({e.id for e in entries}) == 2
    assert len(update_baseline(file, run, later, prune=True).removed) == 1
    assert [e.reason for e in read_baseline(file, "hall").entries] == ["took longer"]


def test_prune_removes_what_is_fixed_if_the_run_could_tell(tmp_path) -> None:
    file = tmp_path / "known.yaml"
    update_baseline(file, result(tmp_path / "one", make_finding(), ELSEWHERE), NOTE)
    unsure = result(tmp_path / "two", make_finding(), enough=False, sha256="changed")
    assert not update_baseline(file, unsure, NOTE, prune=True).removed
    unchanged = result(tmp_path / "same", make_finding())
    assert not update_baseline(file, unchanged, NOTE, prune=True).removed
    sure = result(tmp_path / "three", make_finding(), sha256="changed")
    assert [e.id for e in update_baseline(file, sure, NOTE, prune=True).removed] == [ELSEWHERE.id]
    update_baseline(file, result(tmp_path / "four", sha256="changed"), NOTE, prune=True)
    assert read_baseline(file, "hall").entries == ()


def test_prune_keeps_what_got_worse(tmp_path) -> None:
    file = tmp_path / "known.yaml"
    stood = make_finding(kind="unexpected_area", id="stood")
    update_baseline(file, result(tmp_path / "one", stood), NOTE)
    done = update_baseline(file, result(tmp_path / "two", make_finding(), sha256="changed"), NOTE, prune=True)
    assert ([e.id for e in done.added], done.removed) == ([make_finding().id], ())


def test_a_file_of_another_level_is_left_alone(tmp_path) -> None:
    file = tmp_path / "known.yaml"
    file.write_text("version: 1\nlevel: cellar\nentries: []\n")
    with pytest.raises(BadInput, match="cellar"):
        update_baseline(file, result(tmp_path / "out", make_finding()), NOTE)
    assert file.read_text() == "version: 1\nlevel: cellar\nentries: []\n"
