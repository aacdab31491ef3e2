"""junit.xml: the report for GitLab, Jenkins and whatever else draws test results.

One failing case a finding (its stable id in the name, so that a CI system sees which failures are new), one case
for each gating kind or severity that found nothing, a skipped one for each known bug and each fragile finding, one for
the goals and one for whether the run could tell.
"""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET

from reachtest.records import Finding, Level, Report
from reachtest.report import run_wording, wording

# What XML 1.0 cannot hold, escaped or not.
_ILLEGAL = re.compile("[^\t\n\r\u0020-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def render(report: Report) -> str:
    """A `testsuites` document with one suite."""
    name = f"reachtest.{wording.one_line(report.level.name)}"
    suite = ET.Element("testsuite", name=_legal(name))
    gating = wording.gating(report.findings)
    for finding in gating:
        _finding_case(suite, name, finding, report.level)
    for asked in report.level.gate.fail_on:  # kinds and severities
        if not any(asked in (finding.kind, finding.severity) for finding in gating):
            _case(suite, name, asked)
    for finding in wording.known(report.findings):
        _skipped_case(suite, name, finding, report.level, f"known: {wording.why_known(report, finding)}")
    for finding in wording.fragile(report.findings):
        _skipped_case(suite, name, finding, report.level, f"fragile: {wording.why_fragile(finding)}")
    _run_cases(suite, name, report)
    others = [f for f in report.findings if not (f.gating or f.fragile) and f.suppressed_by is None]
    if others:
        lines = [_other_line(finding, report.level) for finding in others]
        ET.SubElement(suite, "system-out").text = _legal("\n".join(lines))
    return _document(suite, report)


def _document(suite: ET.Element, report: Report) -> str:
    for attribute, elements in (
        ("tests", "testcase"),
        ("failures", "failure"),
        ("errors", "error"),
        ("skipped", "skipped"),
    ):
        suite.set(attribute, str(len(list(suite.iter(elements)))))
    suite.set("time", f"{report.exploration.timing.get('wall_s', 0.0):.3f}")
    suite.set("timestamp", _legal(report.started_at))
    root = ET.Element("testsuites")
    root.append(suite)
    ET.indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + ET.tostring(root, encoding="unicode") + "\n"


def _case(suite: ET.Element, suite_name: str, name: str) -> ET.Element:
    return ET.SubElement(suite, "testcase", classname=_legal(suite_name), name=_legal(name))


def _finding_case(suite: ET.Element, suite_name: str, finding: Finding, level: Level) -> None:
    title = wording.title(finding)
    case = _case(suite, suite_name, f"{finding.kind} [{wording.one_line(finding.id)}]")
    near = f"near {wording.one_line(finding.nearest_named)}" if finding.nearest_named else ""
    lines = [
        title,
        f"where:   {wording.place(level, finding.position)} ({wording.axes(level)}) {near}".rstrip(),
        f"how bad: {finding.severity}, {wording.extent(finding, level)}",
        f"see it:  {wording.evidence(finding)}",
    ]
    if left_at := wording.exit_place(level, finding):
        lines.insert(2, f"left the nav-mesh at {left_at}")
    lines += [f"- {wording.one_line(detail)}" for detail in finding.details]
    _problem(case, "failure", finding.kind, f"{title} at {wording.place(level, finding.position)}", lines)


def _skipped_case(suite: ET.Element, suite_name: str, finding: Finding, level: Level, message: str) -> None:
    case = _case(suite, suite_name, f"{finding.kind} [{wording.one_line(finding.id)}]")
    where = f"{wording.title(finding)} at {wording.place(level, finding.position)}"
    ET.SubElement(case, "skipped", message=_legal(message)).text = _legal(where)


def _run_cases(suite: ET.Element, suite_name: str, report: Report) -> None:
    """The goals, and whether the run could tell."""
    wanted = report.level.gate.min_goals_reached
    reached, total = run_wording.goals_that_count(report)
    total -= report.verdict.goals_given_up
    inconclusive = report.verdict.name == "inconclusive"
    goals_missing = report.verdict.name != "pass" and reached < wanted * total
    facts = [f"{label}: {text}" for label, text in run_wording.run_facts(report)]
    goals = _case(suite, suite_name, "goals_reached")
    if goals_missing:
        message = f"{reached} of {total} goals reached, {100 * wanted:g} % wanted"
        _problem(goals, "error" if inconclusive else "failure", "goals_reached", message, facts)
    explored = _case(suite, suite_name, "explored_enough")
    if inconclusive:
        _problem(explored, "error", "inconclusive", wording.sentence(report.verdict.reason), facts)


def _problem(case: ET.Element, tag: str, kind: str, message: str, lines: list[str]) -> None:
    ET.SubElement(case, tag, type=_legal(kind), message=_legal(message)).text = _legal("\n".join(lines))


def _other_line(finding: Finding, level: Level) -> str:
    title = wording.title(finding)
    return f"{wording.kind_words(finding.kind)}: {title} ({wording.why_not_gating(finding, level)})"


def _legal(text: str) -> str:
    return _ILLEGAL.sub("", text)
