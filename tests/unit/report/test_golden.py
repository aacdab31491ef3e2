"""Whole outputs against golden files; REACHTEST_UPDATE_GOLDEN=1 rewrites them for a human to compare."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from reachtest.report import REPORTS
from tests.unit.report.make import FAIL, make_findings, make_report

GOLDEN = Path(__file__).parents[2] / "golden"


@pytest.mark.parametrize("name", ["report.json", "summary.md"])
def test_output_is_as_it_was(name: str) -> None:
    text = REPORTS[name](make_report(make_findings(), FAIL))
    if os.environ.get("REACHTEST_UPDATE_GOLDEN"):
        (GOLDEN / name).write_text(text, encoding="utf-8")
    assert text == (GOLDEN / name).read_text(encoding="utf-8")
