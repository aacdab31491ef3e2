"""What known bugs mean for a run: which findings they are, which gate again, and which are gone."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import date
from typing import Any

from reachtest.baseline.document import Baseline, Entry
from reachtest.baseline.gone import Look, new_ones
from reachtest.baseline.place import Place, match
from reachtest.records import Finding


@dataclass(frozen=True)
class Outcome:
    """Known bugs beside the findings of one run."""

    baseline: Baseline
    today: date
    known: tuple[tuple[str, Entry], ...]  # (id of the finding, the entry that keeps it from gating)
    expired: tuple[tuple[str, Entry], ...]  # (id of the finding, the entry that does so no longer)
    absent: tuple[Entry, ...]  # entries without a finding
    found: tuple[Place, ...]  # of every finding
    new: tuple[Place, ...]  # of those without an entry

    def section(self, sha256: str, enough: bool, risk: float) -> dict[str, Any]:
        """`baseline` of report.json, for a run of the level of that `sha256`: see `Look`."""
        look = Look(sha256, enough, risk, self.found, self.new)
        worse = [(entry, look.worse(entry.place)) for entry in self.absent]
        absent = [
            (entry, look.doubt(entry.place, entry.level_sha256)) for entry, fall in worse if fall is None
        ]
        return {
            "file": self.baseline.file,
            "date": self.today.isoformat(),
            "known": [_told(entry, finding) for finding, entry in self.known],
            "expired": [_told(entry, finding) for finding, entry in self.expired],
            "worse": [_told(entry, fall.id) for entry, fall in worse if fall is not None],
            "fixed": [_told(entry) for entry, doubt in absent if not doubt],
            "not_seen": [{**_told(entry), "doubt": doubt} for entry, doubt in absent if doubt],
        }


def apply_baseline(
    baseline: Baseline, findings: Sequence[Finding], today: date
) -> tuple[tuple[Finding, ...], Outcome]:
    """The findings with known ones marked and no longer gating, gating ones first as before; and what was known.

    An entry counts up to and including its day of expiry. One in force goes before an expired one.
    """
    places = [Place.of(finding) for finding in findings]
    in_force = [entry for entry in baseline.entries if entry.in_force(today)]
    expired = [entry for entry in baseline.entries if not entry.in_force(today)]
    by, formerly = (match(places, [entry.place for entry in some]) for some in (in_force, expired))
    marked = [
        finding if index is None else _known(finding, in_force[index])
        for finding, index in zip(findings, by, strict=True)
    ]
    ids = [finding.id for finding in findings]
    outcome = Outcome(
        baseline,
        today,
        known=tuple((id_, in_force[i]) for id_, i in zip(ids, by, strict=True) if i is not None),
        expired=tuple(
            (id_, expired[j])
            for id_, i, j in zip(ids, by, formerly, strict=True)
            if i is None and j is not None
        ),
        absent=tuple(entry for i, entry in enumerate(in_force) if i not in by)
        + tuple(entry for j, entry in enumerate(expired) if j not in formerly),
        found=tuple(places),
        new=new_ones(places, [formerly[n] if i is None else i for n, i in enumerate(by)]),
    )
    return tuple(sorted(marked, key=lambda finding: not finding.gating)), outcome


def _known(finding: Finding, entry: Entry) -> Finding:
    return dataclasses.replace(finding, gating=False, suppressed_by=f"baseline: {entry.id} ({entry.reason})")


def _told(entry: Entry, finding: str | None = None) -> dict[str, Any]:
    told = {
        "id": entry.id,
        "kind": entry.kind,
        "title": entry.title,
        "position": list(entry.position),
        "reason": entry.reason,
        "author": entry.author,
        "expires": entry.expires.isoformat() if entry.expires else None,
    }
    return told if finding is None else {"finding": finding, **told}
