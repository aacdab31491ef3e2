"""The sentences about findings that the outputs for people share: plain text, one line each, nothing escaped yet."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable
from typing import Any

import numpy as np

from reachtest.records import Finding, Level, Report

MAX_TEXT = 160  # characters of a name or title: a generated name can be longer than the page

ONE_PLACE_M = 0.1  # a smaller box is no area


def sentence(text: str) -> str:
    """`text` made fit to print: no control characters or line breaks, no broken Unicode."""
    printable = "".join(char if char.isprintable() else " " for char in text)
    return " ".join(printable.split())


def one_line(text: str) -> str:
    """A name or title made fit to print, and not too long."""
    line = sentence(text)
    return line if len(line) <= MAX_TEXT else f"{line[: MAX_TEXT - 3]}..."


def place(level: Level, position: Any) -> str:
    """A position [3] [m] as "x, y, z" in the level file's own axes and units, to 1 cm, ready to paste."""
    digits = max(0, math.ceil(math.log10(level.frame.unit_m / 0.01) - 1e-9))
    values = level.frame.to_source(position).round(digits) + 0.0  # + 0.0: no "-0"
    return ", ".join(f"{value:.{digits}f}" for value in values.tolist())


def exit_place(level: Level, finding: Finding) -> str | None:
    """Where the way to the finding left the nav-mesh, as `place` puts it; None if there is none."""
    if finding.exit_point is None or not np.isfinite(finding.exit_point).all():
        return None
    return place(level, finding.exit_point)


def axes(level: Level) -> str:
    """Says in which coordinates `place` speaks."""
    return f"{level.frame.up_axis} up, {level.frame.units}"


def kind_words(kind: str) -> str:
    """`fell_out_of_world` as people say it."""
    return kind.replace("_", " ")


def title(finding: Finding) -> str:
    """What is wrong, in one line."""
    return one_line(finding.title) or kind_words(finding.kind)


def gating(findings: Iterable[Finding]) -> list[Finding]:
    """The findings that fail the build."""
    return [finding for finding in findings if finding.gating]


def known(findings: Iterable[Finding]) -> list[Finding]:
    """The findings that the file of known bugs accounts for."""
    return [finding for finding in findings if finding.suppressed_by is not None]


def extent(finding: Finding, level: Level) -> str:
    """How big it is: number of points and the size of the box around them, along the file's axes."""
    if finding.points == 1:
        return plural(1, "point")
    if (finding.high - finding.low).max() < ONE_PLACE_M:
        return f"{plural(finding.points, 'point')}, stood at one place"
    sides = " x ".join(f"{side:.1f}" for side in level.frame.size_m(finding.low, finding.high).tolist())
    return f"{plural(finding.points, 'point')} over {sides} m"


def evidence(finding: Finding) -> str:
    """How to see it again: length of the recorded path and how often it reproduced."""
    path = finding.path
    if path is None:
        return "no recorded path"
    length = f"{path.duration_s:.1f} s from the spawn"
    if path.found_s is not None and path.found_s > path.duration_s:
        length += f" (found in {path.found_s:.1f} s)"
    if finding.confirmation is None:
        return f"{length}, reproduced {path.succeeded} of {path.attempts}, unconfirmed"
    exact, half, nearby = (
        f"{succeeded} of {attempts}" for attempts, succeeded in dataclasses.astuple(finding.confirmation)
    )
    return f"{length}, reproduced {exact} exactly, {half} at half the time step, {nearby} with other actions"


def fragile(findings: Iterable[Finding]) -> list[Finding]:
    """The findings that did not come about again as a bug of the level does."""
    return [finding for finding in findings if finding.fragile and finding.suppressed_by is None]


def why_fragile(finding: Finding) -> str:
    """What is wrong with the evidence."""
    confirmation = finding.confirmation
    if confirmation is None or confirmation.exact[0] > confirmation.exact[1]:
        return "did not come out bit for bit when it was simulated again: please report that"
    return (
        f"only at the coarse time step: {confirmation.half_step[1]} of {confirmation.half_step[0]} at half of it,"
        f" {confirmation.nearby[1]} of {confirmation.nearby[0]} with other actions"
    )


def why_not_gating(finding: Finding, level: Level) -> str:
    """Why the build does not fail because of it."""
    if finding.suppressed_by is not None:
        return f"suppressed by {one_line(finding.suppressed_by)}"
    if finding.fragile:
        return why_fragile(finding)
    if {finding.kind, finding.severity, "warning"} & set(level.gate.fail_on):
        return "no failure by itself"
    return f"{finding.kind} is not in fail_on"


def why_known(report: Report, finding: Finding) -> str:
    """The reason, the author and the expiry of the known bug that a finding is."""
    section = report.document.get("baseline") or {"known": []}
    for entry in section["known"]:
        if entry["finding"] == finding.id:
            until = f"until {entry['expires']}" if entry["expires"] else "for good"
            return f"{one_line(entry['reason'])} ({one_line(entry['author'])}, {until})"
    return why_not_gating(finding, report.level)


def missed_ground(report: Report) -> list[str] | None:
    """The places of `--audit`, largest first, a line each; None where nobody asked."""
    audit = report.document.get("audit")
    if audit is None:
        return None
    return [
        f"{place(report.level, np.array(entry['position']))}: {_audited(report.level, entry)}"
        + (f", near {one_line(entry['nearest_named'])}" if entry["nearest_named"] else "")
        for entry in audit
    ]


def _audited(level: Level, entry: dict[str, Any]) -> str:
    low, high = (np.array(corner) for corner in entry["bounds"])
    sides = " x ".join(f"{side:.1f}" for side in level.frame.size_m(low, high).tolist())
    return plural(entry["points"], "point") + (f" over {sides} m" if entry["points"] > 1 else "")


def plural(count: int, noun: str) -> str:
    """ "1 point", "1,200 points"."""
    return f"{count:,} {noun}{'' if count == 1 else 's'}"
