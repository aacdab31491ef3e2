"""Compares two runs of one level: findings by place, coverage, and the areas that only one of them reached."""

from __future__ import annotations

from dataclasses import dataclass

from reachtest.baseline.place import match
from reachtest.diffing.areas import Area, lost
from reachtest.errors import EXIT_FAIL, EXIT_PASS, BadInput, Problem
from reachtest.results import FoundBefore, ReportBefore, Result

SATURATED_PROBABILITY = 0.05  # below it, one more episode hardly finds a new place


@dataclass(frozen=True)
class Difference:
    """What changed from `old` to `new`."""

    old: Result
    new: Result
    notes: tuple[str, ...]  # what makes the runs less comparable
    appeared: tuple[FoundBefore, ...]
    gone: tuple[FoundBefore, ...]
    still: tuple[tuple[FoundBefore, FoundBefore], ...]  # (old, new)
    surely_gone: bool  # the new run explored enough to call it fixed
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
    seen = match([finding.place for finding in after], [finding.place for finding in before])
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
        gone=tuple(finding for i, finding in enumerate(before) if i not in seen),
        still=tuple((before[i], finding) for finding, i in zip(after, seen, strict=True) if i is not None),
        surely_gone=new.report.explored_enough,
        unreachable=unreachable,
        reachable=reachable,
        may_be_chance=not (_saturated(old.report) and _saturated(new.report)),
    )


def _saturated(report: ReportBefore) -> bool:
    """Whether a longer run would hardly have reached more."""
    chance = report.risk.discovery_probability
    return chance is not None and chance <= SATURATED_PROBABILITY


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
