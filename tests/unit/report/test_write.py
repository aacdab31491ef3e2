"""Report files on disk."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from reachtest.interfaces import ReportOutput
from reachtest.records import Report
from reachtest.report import REPORTS
from reachtest.report.write import write_reports
from tests.unit.report.make import FAIL, make_finding, make_findings, make_report


def test_every_output_is_written_and_nothing_else(tmp_path: Path) -> None:
    folder = tmp_path / "new" / "folder"
    written = write_reports(make_report(make_findings(), FAIL), folder)
    assert [path.name for path in written] == list(REPORTS)
    assert sorted(folder.iterdir()) == sorted(written)


def test_json_on_disk_is_the_document(tmp_path: Path) -> None:
    report = make_report(make_findings(), FAIL)
    write_reports(report, tmp_path)
    assert json.loads((tmp_path / "report.json").read_text("utf-8")) == report.document


def test_a_name_with_broken_unicode_does_not_cost_the_report(tmp_path: Path) -> None:
    broken = make_finding(title="half a pair: \ud83d", nearest_named="\udc00")
    for path in write_reports(make_report((broken,), FAIL), tmp_path):
        assert "half a pair" in path.read_text("utf-8")


def test_an_output_that_fails_leaves_the_last_report_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = {path: path.read_bytes() for path in write_reports(make_report(), tmp_path)}

    def broken(report: Report) -> str:
        raise ZeroDivisionError

    output: ReportOutput = broken
    monkeypatch.setitem(REPORTS, "junit.xml", output)
    with pytest.raises(ZeroDivisionError):
        write_reports(make_report(make_findings(), FAIL), tmp_path)
    assert {path: path.read_bytes() for path in tmp_path.iterdir()} == before
