"""Compares two runs of one level: findings by place, coverage, and the areas that only one of them reached."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from reachtest.baseline.gone import Look, new_ones
from reachtest.baseline.place import match
from reachtest.diffing.areas import Area, lost
from reachtest.errors import EXIT_FAIL, EXIT_PASS, BadInput, Problem
from reachtest.results import FoundBefore, Result

Pair = tuple[FoundBefore, FoundBefore]  # (old, new)


@dataclass(frozen=True)
class Difference:
    """What changed from `old` to `new`."""

    old: Result
    new: Result
    notes: tuple[str, ...]  # what makes the runs less comparable
    appeared: tuple[FoundBefore, ...]
    worse: tuple[Pair, ...]  # the new one is among `appeared` too
    fixed: tuple[FoundBefore, ...]
    not_seen: tuple[tuple[FoundBefore, str], ...]  # and why it may be there all the same
    still: tuple[Pair, ...]
    unreachable: tuple[Area, ...] | None  # None: one of the runs has no coverage.json
    reachable: tuple[Area, ...] | None
    may_be_chance: bool  # of the areas: not both runs were saturated

    @property
    def exit_code(self) -> int:
        """1 with a new gating finding, else 0."""
        return EXIT_FAIL if any(finding.gating for finding in self.appeared) else EXIT_PASS


def compare(old: Result, new: Result) -> Difference:
    """What changed. Raises BadInput for runs of different levels."""
    names = old.report.level.name, new.report.level.name
    if names[0] != names[1]:
        found = f"is a run of level {names[1]!r}, {old.name} one of {names[0]!r}"
        raise BadInput([Problem(new.name, found, "give two runs of one level")])
    before, after = old.report.findings, new.report.findings
    places = tuple(finding.place for finding in after)
    seen = match(places, [finding.place for finding in before])
    gone = [finding for i, finding in enumerate(before) if i not in seen]
    worse, fixed, not_seen = _became(gone, old, new, new.report.look(places, new_ones(places, seen)))
    unreachable = reachable = None
    if old.coverage is not None and new.coverage is not None:
        spacing = max(result.report.config.explore.goal_spacing_m for result in (old, new))
        unreachable = tuple(lost(old.coverage, new.coverage, spacing))
        reachable = tuple(lost(new.coverage, old.coverage, spacing))
    return Difference(
        old,
        new,
        tuple(_notes(old, new)),
        appeared=tuple(finding for finding, index in zip(after, seen, strict=True) if index is None),
        worse=worse,
        fixed=fixed,
        not_seen=not_seen,
        still=tuple((before[i], finding) for finding, i in zip(after, seen, strict=True) if i is not None),
        unreachable=unreachable,
        reachable=reachable,
        may_be_chance=not (old.report.saturated and new.report.saturated),
    )


def _became(
    gone: Sequence[FoundBefore], old: Result, new: Result, look: Look
) -> tuple[tuple[Pair, ...], tuple[FoundBefore, ...], tuple[tuple[FoundBefore, str], ...]]:
    """Which of the findings that are gone got worse, are fixed, or were only not seen."""
    by_id = {finding.id: finding for finding in new.report.findings}
    falls = [(finding, look.worse(finding.place)) for finding in gone]
    doubts = [
        (finding, look.doubt(finding.place, old.report.level.sha256))
        for finding, fall in falls
        if fall is None
    ]
    return (
        tuple((finding, by_id[fall.id]) for finding, fall in falls if fall is not None),
        tuple(finding for finding, doubt in doubts if not doubt),
        tuple((finding, doubt) for finding, doubt in doubts if doubt),
    )


def _notes(old: Result, new: Result) -> list[str]:
    one, other = old.report, new.report
    notes = []
    if one.level.sha256 != other.level.sha256:
        notes.append("the level file or a file it names has changed")
    if one.seed != other.seed:
        notes.append(f"seeds {one.seed} and {other.seed}: what was reached differs by chance")
    if one.run.agent_steps != other.run.agent_steps:
        steps = f"{one.run.agent_steps:,} and {other.run.agent_steps:,} agent steps"
        notes.append(f"{steps}: the longer run reaches more")
    notes += [
        f"{result.name} has no coverage.json: areas are not compared"
        for result in (old, new)
        if not result.coverage
    ]
    return notes
