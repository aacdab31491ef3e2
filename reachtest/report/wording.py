"""The sentences that the outputs for people share: plain text, one line each, nothing escaped yet."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable
from typing import Any

import numpy as np

from reachtest.records import SATURATED_RISK, Finding, Ints, Level, Report, StopReason
from reachtest.report.risk import recent_sentence, risk_sentence

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
    metres_a_unit = float(np.linalg.norm(level.frame.matrix[:, 0]))
    digits = max(0, math.ceil(math.log10(metres_a_unit / 0.01) - 1e-9))
    values = level.frame.to_source(position).round(digits) + 0.0  # + 0.0: no "-0"
    return ", ".join(f"{value:.{digits}f}" for value in values.tolist())


def exit_place(level: Level, finding: Finding) -> str | None:
    """The last place on the nav-mesh before the finding, as `place` puts it; None if there is none."""
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


def extent(finding: Finding) -> str:
    """How big it is: number of points and the size of the box around them."""
    if finding.points == 1:
        return plural(1, "point")
    if (finding.high - finding.low).max() < ONE_PLACE_M:
        return f"{plural(finding.points, 'point')}, stood at one place"
    sides = " x ".join(f"{side:.1f}" for side in (finding.high - finding.low).tolist())
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
        f"only at the coarse time step: 0 of {confirmation.half_step[0]} at half of it,"
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


def known_bugs(report: Report) -> str:
    """What became of the known bugs, with those named that want a look; empty without a file of them."""
    section = report.document.get("baseline")
    if section is None:
        return ""
    told = [f"{len(section['known'])} seen"]
    told += [f"expired {e['expires']}, so it gates again: {e['finding']}" for e in section["expired"]]
    told += [f"got worse: {_known_bug(report, e)}, now {one_line(e['finding'])}" for e in section["worse"]]
    told += [f"fixed: {_known_bug(report, e)}" for e in section["fixed"]]
    told += [
        f"not seen, but not shown to be fixed ({e['doubt']}): {_known_bug(report, e)}"
        for e in section["not_seen"]
    ]
    return "; ".join(told)


def _known_bug(report: Report, entry: dict[str, Any]) -> str:
    """An entry of the file of known bugs: title, place and id."""
    where = place(report.level, np.array(entry["position"]))
    return f"{one_line(entry['title'] or kind_words(entry['kind']))} at {where} ({one_line(entry['id'])})"


def missed_ground(report: Report) -> list[str] | None:
    """The places of `--audit`, largest first, a line each; None where nobody asked."""
    audit = report.document.get("audit")
    if audit is None:
        return None
    return [
        f"{place(report.level, np.array(entry['position']))}: {_audited(entry)}"
        + (f", near {one_line(entry['nearest_named'])}" if entry["nearest_named"] else "")
        for entry in audit
    ]


def _audited(entry: dict[str, Any]) -> str:
    low, high = (np.array(corner) for corner in entry["bounds"])
    sides = " x ".join(f"{side:.1f}" for side in (high - low).tolist())
    return plural(entry["points"], "point") + (f" over {sides} m" if entry["points"] > 1 else "")


def plural(count: int, noun: str) -> str:
    """ "1 point", "1,200 points"."""
    return f"{count:,} {noun}{'' if count == 1 else 's'}"


def run_facts(report: Report) -> list[tuple[str, str]]:
    """What was explored, how sure that is and why it stopped, as (label, sentence)."""
    exploration = report.exploration
    total, reached = len(exploration.goals), int((exploration.goal_step >= 0).sum())
    percent = math.floor(1000 * reached / total) / 10 if total else 0.0  # 99.97 % is not 100 %
    positions = report.document["positions"]
    facts = [
        ("Goals", f"{reached:,} of {total:,} reached ({percent:g} %){_goals_that_count(report)}"),
        ("Border", _border(exploration.border_pushes)),
        ("Positions", f"{positions['discovered']:,}, of which {positions['unexpected']:,} off the nav-mesh"),
        ("Risk", risk_sentence(report)),
        ("Discovery", recent_sentence(report)),
        ("Stopped", _stop(report)),
    ]
    if len(exploration.required_step):
        text = f"{(exploration.required_step >= 0).sum():,} of {len(exploration.required_step):,} reached"
        facts.insert(1, ("Required", text))
    facts.append(("Known bugs", known_bugs(report)))
    if exploration.diverged_episodes:
        text = f"{plural(exploration.diverged_episodes, 'episode')} dropped because the simulation diverged"
        facts.append(("Physics", text))
    return [(label, sentence) for label, sentence in facts if sentence]


def goals_that_count(report: Report) -> tuple[int, int]:
    """Goals reached, and goals there are, of those that a pass needs."""
    coverage = report.document["coverage"]
    total = coverage["goals_connected"] - coverage["goals_unreached_by_mismatch"]
    return coverage["goals_connected_reached"], total


def _goals_that_count(report: Report) -> str:
    reached, total = goals_that_count(report)
    if total == len(report.exploration.goals):
        return ""
    return f"; {reached:,} of the {total:,} that a spawn is connected to and the character can get to"


def _border(pushes: Ints) -> str:
    """How much of the nav-mesh's border was tried, by the pushes at each place [n]; empty without any."""
    if not len(pushes):
        return ""
    tried = f"{(pushes > 0).sum():,} of {len(pushes):,} places along the nav-mesh's border were pushed at"
    return f"{tried}, half of them at least {np.median(pushes):,.0f} times"


def _stop(report: Report) -> str:
    exploration = report.exploration
    wall_s = exploration.timing.get("wall_s")
    took = "" if wall_s is None else f" and {wall_s:,.0f} s"
    return (
        f"{exploration.stop_reason.value} after {exploration.agent_steps:,} agent steps, "
        f"{plural(exploration.episodes, 'episode')}{took}"
    )


def next_step(report: Report) -> str:
    """What to do now."""
    if report.verdict.name == "inconclusive":
        return _next_inconclusive(report)
    if report.verdict.name == "fail":
        return (
            "paste a position into your editor, or open run.mcap in Foxglove, Lichtblick or Rerun "
            "to see how the character got there"
        )
    if report.findings:
        return "look at the findings that do not fail the build"
    return _next_pass(report)


def _next_pass(report: Report) -> str:
    risk, limit = report.exploration.risk, report.level.gate.max_discovery_probability
    if risk <= max(SATURATED_RISK, limit or 0.0):
        return "nothing to do"
    return (
        f"nothing to mend; one more episode may still find a new place (up to {100 * risk:.0f} %): now and then run"
        f" longer, for example with --steps {2 * report.exploration.agent_steps}"
    )


def _next_inconclusive(report: Report) -> str:
    exploration = report.exploration
    if exploration.stop_reason in (StopReason.INTERRUPTED, StopReason.TERMINATED):
        return "run again: what was found so far is in the report"
    if len(exploration.goals) and not (exploration.goal_step >= 0).any():
        return "no goal was reached at all: check the spawn, the axes and the units in the level file"
    more = report.verdict.steps_to_go or exploration.agent_steps
    longer = f"run longer, for example with --steps {exploration.agent_steps + more}"
    reached, total = goals_that_count(report)
    if reached == total and (exploration.required_step >= 0).all():
        return f"{longer}: everything was reached, but new places are still being found"
    return f"{longer}, or open run.mcap to see which places are cut off"
