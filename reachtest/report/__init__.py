"""Report outputs: one file each; a new one is a module with a `render` and a line in `REPORTS`."""

from reachtest.interfaces import ReportOutput
from reachtest.report import json_report, junit, summary
from reachtest.report.console import console_summary
from reachtest.report.document import build_document

REPORTS: dict[str, ReportOutput] = {
    "report.json": json_report.render,
    "summary.md": summary.render,
    "junit.xml": junit.render,
}

__all__ = ["REPORTS", "build_document", "console_summary"]
