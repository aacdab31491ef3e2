"""The result as it ends up in the terminal."""

from __future__ import annotations

import textwrap
from typing import TYPE_CHECKING

from reachtest.records import Finding, Level, Report
from reachtest.report import run_wording, wording

if TYPE_CHECKING:
    from rich.text import Text

MAX_GATING, MAX_OTHERS = 10, 5  # about one screen; summary.md has the rest
STYLES = {"pass": "bold green", "fail": "bold red", "inconclusive": "bold yellow"}
LABEL_WIDTH = 11


def console_summary(report: Report, width: int) -> Text:
    """Verdict, findings, coverage and the next step, wrapped to `width` columns (at least 40)."""
    from rich.text import Text

    text = Text(no_wrap=True, overflow="ignore")
    for line, style in _lines(report, max(width, 40)):
        text.append(line + "\n", style)
    text.right_crop()  # the caller's print ends the last line
    return text


def _lines(report: Report, width: int) -> list[tuple[str, str]]:
    verdict, gating = report.verdict, wording.gating(report.findings)
    known = wording.known(report.findings)
    fragile = wording.fragile(report.findings)
    others = [f for f in report.findings if not (f.gating or f.fragile) and f.suppressed_by is None]
    name, reason = wording.one_line(report.level.name), wording.sentence(verdict.reason)
    head = f"{verdict.name.upper()}  {name}: {reason}"
    lines = [(line, STYLES[verdict.name]) for line in textwrap.wrap(head, width, subsequent_indent="  ")]
    if report.findings:
        axes = wording.axes(report.level)
        note = f"Positions are in the level file's own coordinates ({axes})."
        lines += [(line, "dim") for line in textwrap.wrap(note, width)]
    for number, finding in enumerate(gating[:MAX_GATING], start=1):
        lines += _gating(number, finding, report.level, width)
    lines += _more(len(gating) - MAX_GATING)
    if others:
        lines += [("", ""), (f"Does not fail the build ({len(others)})", "bold")]
        for finding in others[:MAX_OTHERS]:
            why = wording.why_not_gating(finding, report.level)
            lines += [(line, "") for line in _other(finding, report.level, width, why)]
        lines += _more(len(others) - MAX_OTHERS)
    if fragile:
        lines += [("", ""), (f"Fragile: not confirmed ({len(fragile)})", "bold")]
        for finding in fragile[:MAX_OTHERS]:
            why = wording.why_fragile(finding)
            lines += [(line, "") for line in _other(finding, report.level, width, why)]
        lines += _more(len(fragile) - MAX_OTHERS)
    if known:
        lines += [("", ""), (f"Known bugs ({len(known)})", "bold")]
        for finding in known[:MAX_OTHERS]:
            why = wording.why_known(report, finding)
            lines += [(line, "") for line in _other(finding, report.level, width, why)]
        lines += _more(len(known) - MAX_OTHERS)
    lines += _audit(report, width)
    lines.append(("", ""))
    for label, sentence in [*run_wording.run_facts(report), ("Next", run_wording.next_step(report))]:
        lines += [(line, "bold" if label == "Next" else "") for line in _row("", label, sentence, width)]
    return lines


def _audit(report: Report, width: int) -> list[tuple[str, str]]:
    places = wording.missed_ground(report)
    if places is None:
        return []
    lines = [("", ""), (f"Ground that the nav-mesh misses ({len(places)})", "bold")]
    for place in places[:MAX_OTHERS]:
        lines += [(line, "") for line in textwrap.wrap(f"- {place}", width, initial_indent=" ")]
    return lines + _more(len(places) - MAX_OTHERS)


def _gating(number: int, finding: Finding, level: Level, width: int) -> list[tuple[str, str]]:
    title = f"{number}. {wording.title(finding)}"
    near = f"  near {wording.one_line(finding.nearest_named)}" if finding.nearest_named else ""
    rows = [("where", wording.place(level, finding.position) + near)]
    if left_at := wording.exit_place(level, finding):
        rows.append(("left at", f"{left_at}  (where the way left the nav-mesh)"))
    rows.append(("how bad", f"{finding.severity}, {wording.extent(finding, level)}"))
    rows.append(("see it", wording.evidence(finding)))
    lines = [("", "")]
    lines += [(line, "bold") for line in textwrap.wrap(title, width, subsequent_indent="   ")]
    for label, sentence in rows:
        lines += [(line, "") for line in _row("   ", label, sentence, width)]
    lines += [(line, "") for detail in finding.details for line in _detail(detail, width)]
    kind_and_id = f"{finding.kind}, {wording.one_line(finding.id)}"
    return lines + [(line, "dim") for line in _row("   ", "kind, id", kind_and_id, width)]


def _other(finding: Finding, level: Level, width: int, why: str) -> list[str]:
    title = f"- {wording.title(finding)}"
    place = f"{wording.place(level, finding.position)}  ({why})"
    lines = textwrap.wrap(title, width, initial_indent=" ", subsequent_indent="   ")
    lines += _row("   ", "where", place, width)
    return lines + [line for detail in finding.details for line in _detail(detail, width)]


def _detail(detail: str, width: int) -> list[str]:
    return textwrap.wrap(
        f"- {wording.one_line(detail)}", width, initial_indent="   ", subsequent_indent="     "
    )


def _more(count: int) -> list[tuple[str, str]]:
    return [(f"   ...and {count:,} more in summary.md", "dim")] if count > 0 else []


def _row(indent: str, label: str, sentence: str, width: int) -> list[str]:
    first = indent + label.ljust(LABEL_WIDTH)
    return textwrap.wrap(sentence, width, initial_indent=first, subsequent_indent=" " * len(first))
