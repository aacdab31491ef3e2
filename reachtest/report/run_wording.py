"""The sentences about the run as a whole that the outputs for people share: what was explored, and what to do now."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from reachtest.records import SATURATED_RISK, Ints, Report, StopReason
from reachtest.report.risk import recent_sentence, risk_sentence
from reachtest.report.wording import kind_words, one_line, place, plural


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
    missed, connected = exploration.required_step < 0, exploration.required_connected
    reached, total = goals_that_count(report)
    if reached == total and len(connected) and missed.any() and not (missed & connected).any():
        return "check where the required points lie, or connect the nav-mesh to them: more steps know no better way"
    more = report.verdict.steps_to_go or exploration.agent_steps
    longer = f"run longer, for example with --steps {exploration.agent_steps + more}"
    if reached == total and (exploration.required_step >= 0).all():
        return f"{longer}: everything was reached, but new places are still being found"
    return f"{longer}, or open run.mcap to see which places are cut off"
