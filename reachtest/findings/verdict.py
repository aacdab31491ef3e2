"""The verdict: fail, pass, or not enough explored to say."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from reachtest.errors import EXIT_FAIL, EXIT_INCONCLUSIVE, EXIT_PASS, EXIT_SIGINT, EXIT_SIGTERM
from reachtest.findings.effort import lacking
from reachtest.records import Bools, Exploration, Finding, GateSettings, StopReason, Verdict

SIGNALLED = {StopReason.INTERRUPTED: EXIT_SIGINT, StopReason.TERMINATED: EXIT_SIGTERM}


def judge(
    gate: GateSettings, exploration: Exploration, findings: Sequence[Finding], counts: Bools | None = None
) -> Verdict:
    """A bug fails whatever else is known; a pass needs an exploration that could have found one.

    `counts` [G] are the goals that a pass needs (default: all): see `navmesh.survey`.
    """
    stopped = SIGNALLED.get(exploration.stop_reason)
    gating = [finding for finding in findings if finding.gating and finding.suppressed_by is None]
    if gating:
        count = f"{len(gating)} gating finding{'s' if len(gating) > 1 else ''}"
        return Verdict("fail", stopped or EXIT_FAIL, count)
    if stopped:
        return Verdict("inconclusive", stopped, exploration.stop_reason.value)
    missing = _missing(gate, exploration, counts)
    if missing:
        return Verdict(
            "inconclusive", EXIT_INCONCLUSIVE, "not explored enough to pass: " + "; ".join(missing)
        )
    reason = "nothing that gates was found, and the level was explored"
    return Verdict("pass", EXIT_PASS, reason + _left_out(exploration, counts))


def _left_out(exploration: Exploration, counts: Bools | None) -> str:
    """What a pass does not speak of: the unreached goals that do not count."""
    left = 0 if counts is None else int((~counts & (exploration.goal_step < 0)).sum())
    goals = f"{left} of {len(exploration.goals)} goals do not count"
    return f"; {goals}: no spawn is connected to them, or the character is barred" if left else ""


def _missing(gate: GateSettings, exploration: Exploration, counts: Bools | None) -> list[str]:
    missing = []
    everything = np.ones(len(exploration.goals), dtype=np.bool_)
    steps = exploration.goal_step if counts is None else exploration.goal_step[counts]
    total, reached = len(steps), int((steps >= 0).sum())
    if not total and len(exploration.goals):
        missing.append(
            f"none of the {len(exploration.goals)} nav-mesh goals is one that the character can get to"
        )
    too_few = reached < gate.min_goals_reached * total
    if too_few:
        missing.append(
            f"{reached} of {total} nav-mesh goals were reached, gate.min_goals_reached asks for"
            f" {gate.min_goals_reached:.0%}"
        )
    missing += lacking(exploration, everything if counts is None else counts, too_few)
    chance = exploration.risk
    limit = gate.max_discovery_probability
    if limit is not None and chance > limit:
        missing.append(
            f"the next episode finds something new with a probability of up to {chance:.0%},"
            f" gate.max_discovery_probability asks for {limit:.0%}"
        )
    return missing
