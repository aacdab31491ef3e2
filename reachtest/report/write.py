"""Writes every report output, each whole or not at all."""

from __future__ import annotations

from pathlib import Path

from reachtest.files import write_whole
from reachtest.records import Report
from reachtest.report import REPORTS, coverage


def write_reports(report: Report, folder: Path) -> list[Path]:
    """Render `REPORTS` into `folder` (made if missing); returns the files written. Raises OSError."""
    texts = {name: render(report) for name, render in REPORTS.items()}
    return [_write(folder / name, text) for name, text in texts.items()]


def write_coverage(report: Report, folder: Path) -> Path:
    """Write coverage.json, which no person reads, beside the reports. Raises OSError."""
    return _write(folder / "coverage.json", coverage.render(report))


def _write(path: Path, text: str) -> Path:
    # Names out of a level file may hold half a surrogate pair: lose that character, not the report.
    data = text.encode("utf-8", errors="replace")
    return write_whole(path, lambda part: part.write_bytes(data))
