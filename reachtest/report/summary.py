"""summary.md: the report for the level designer, also as GitHub's step summary."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence

from reachtest.records import Finding, Level, Report
from reachtest.report import run_wording, wording
from reachtest.report.risk import sparkline

MAX_FINDINGS = 50  # in a table; GitHub drops a step summary over 1 MiB whole
BADGES = {"pass": "✅ PASS", "fail": "❌ FAIL", "inconclusive": "⚠️ INCONCLUSIVE"}

_SPECIAL = re.compile(r"([\\`*_\[\]#|~$])")


def render(report: Report) -> str:
    """The verdict and why, what to fix and where, what else there is, how the run went, what to do next."""
    gating = wording.gating(report.findings)
    known = wording.known(report.findings)
    fragile = wording.fragile(report.findings)
    others = [f for f in report.findings if not (f.gating or f.fragile) and f.suppressed_by is None]
    blocks = [f"# {BADGES[report.verdict.name]}: {escape_sentence(report.verdict.reason)}", _about(report)]
    if gating:
        header = "| # | what | where (x, y, z) | how bad | how to see it |"
        blocks += [f"## Fails the build ({len(gating)})", _table(header, gating, report.level, _gating_row)]
    if others:
        header = "| # | what | where (x, y, z) | why not |"
        blocks += [
            f"## Does not fail the build ({len(others)})",
            _table(header, others, report.level, _other_row),
        ]
    if fragile:
        header = "| # | what | where (x, y, z) | why it is not called a bug |"
        blocks += [
            f"## Fragile: not confirmed ({len(fragile)})",
            _table(header, fragile, report.level, _other_row),
        ]
    if known:
        blocks += [f"## Known bugs ({len(known)})", _known_table(known, report)]
    if (missed := wording.missed_ground(report)) is not None:
        listed = [f"- {escape(place)}" for place in missed[:MAX_FINDINGS]] or ["None."]
        blocks += [f"## Ground that the nav-mesh misses ({len(missed)})", "\n".join(listed)]
    facts = [f"- **{label}:** {escape_sentence(text)}" for label, text in run_wording.run_facts(report)]
    if drawn := sparkline(report):
        facts.append(f"- **Share of episodes that found a new place, over the run:** `{drawn}`")
    blocks += ["## The run", "\n".join(facts), f"**Next:** {run_wording.next_step(report)}."]
    return "\n\n".join(blocks) + "\n"


def escape(text: str) -> str:
    """A name on one line, not too long, shown as it is: neither markdown nor HTML nor a table cell's end."""
    return escape_sentence(wording.one_line(text))


def escape_sentence(text: str) -> str:
    """The same of a whole sentence, which is not cut."""
    line = wording.sentence(text).replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
    return _SPECIAL.sub(r"\\\1", line)


def _about(report: Report) -> str:
    level = report.level
    return (
        f"Level **{escape(level.name)}**, seed {report.exploration.seed}. Positions are in the level file's "
        f"own coordinates ({escape(wording.axes(level))}): paste them into the editor."
    )


def _table(
    header: str, findings: Sequence[Finding], level: Level, row: Callable[[int, Finding, Level], list[str]]
) -> str:
    lines = [header, "|---" * (header.count("|") - 1) + "|"]
    for number, finding in enumerate(findings[:MAX_FINDINGS], start=1):
        lines.append(f"| {' | '.join(row(number, finding, level))} |")
    if len(findings) > MAX_FINDINGS:
        lines.append(f"\n...and {len(findings) - MAX_FINDINGS:,} more in `report.json`.")
    return "\n".join(lines)


def _known_table(known: Sequence[Finding], report: Report) -> str:
    def row(number: int, finding: Finding, level: Level) -> list[str]:
        return [
            str(number),
            _what(finding),
            _where(finding, level),
            escape_sentence(wording.why_known(report, finding)),
        ]

    return _table("| # | what | where (x, y, z) | why it is let be |", known, report.level, row)


def _what(finding: Finding) -> str:
    kind = escape(wording.kind_words(finding.kind))
    details = "".join(f"<br>- {escape(detail)}" for detail in finding.details)
    title = escape(wording.title(finding))
    return f"**{title}**<br>{kind}, {escape(finding.severity)}, {escape(finding.id)}{details}"


def _where(finding: Finding, level: Level) -> str:
    near = f"<br>near {escape(finding.nearest_named)}" if finding.nearest_named else ""
    return f"`{wording.place(level, finding.position)}`{near}"


def _gating_row(number: int, finding: Finding, level: Level) -> list[str]:
    where = _where(finding, level)
    if left_at := wording.exit_place(level, finding):
        where += f"<br>left the nav-mesh at `{left_at}`"
    return [str(number), _what(finding), where, wording.extent(finding, level), _see(finding)]


def _see(finding: Finding) -> str:
    return wording.evidence(finding) + ("<br>`run.mcap`" if finding.path else "")


def _other_row(number: int, finding: Finding, level: Level) -> list[str]:
    return [
        str(number),
        _what(finding),
        _where(finding, level),
        escape(wording.why_not_gating(finding, level)),
    ]
