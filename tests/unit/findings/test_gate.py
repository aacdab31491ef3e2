"""Kinds and severities fail a run by name."""

from __future__ import annotations

import pytest

from reachtest.findings.gate import gates


@pytest.mark.parametrize(
    ("kind", "severity", "fail_on", "fails"),
    [
        ("stuck", "error", ("stuck",), True),
        ("stuck", "error", ("no_return",), False),
        ("stuck", "error", ("error",), True),
        ("no_return", "warning", ("error",), False),
        ("no_return", "warning", ("error", "no_return"), True),
        ("no_return", "warning", ("warning",), True),
        ("stuck", "error", ("warning",), True),
        ("stuck", "error", (), False),
    ],
)
def test_gates(kind, severity, fail_on, fails) -> None:
    assert gates(kind, severity, fail_on) is fails
