"""What fails a run: kinds and severities by name."""

from __future__ import annotations

from collections.abc import Collection


def gates(kind: str, severity: str, fail_on: Collection[str]) -> bool:
    """Whether a finding fails the run: `fail_on` names its kind or its severity; `warning` means errors too."""
    return kind in fail_on or severity in fail_on or "warning" in fail_on
