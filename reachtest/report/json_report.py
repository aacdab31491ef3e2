"""report.json: the report for programs."""

from __future__ import annotations

import json
import re

from reachtest.records import Report

# A raw newline after the bracket cannot occur inside a JSON string, so this matches lists of numbers only.
_NUMBER_LIST = re.compile(r"\[\n\s*([^\[\]{}\"]*?)\n\s*\]")


def render(report: Report) -> str:
    """The document, lists of numbers on one line each; ASCII, so that any console prints it."""
    text = json.dumps(report.document, indent=2, allow_nan=False)
    return _NUMBER_LIST.sub(lambda match: f"[{' '.join(match[1].split())}]", text) + "\n"
