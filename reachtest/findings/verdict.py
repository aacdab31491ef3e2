"""The verdict: fail, pass, or not enough explored to say."""

from __future__ import annotations

from collections.abc import Sequence

from reachtest.errors import EXIT_FAIL, EXIT_INCONCLUSIVE, EXIT_PASS, EXIT_SIGINT, EXIT_SIGTERM
from reachtest.records import Exploration, Finding, GateSettings, StopReason, Verdict

SIGNALLED = {StopReason.INTERRUPTED: EXIT_SIGINT, StopReason.TERMINATED: EXIT_SIGTERM}


def judge(gate: GateSettings, exploration: Exploration, findings: Sequence[Finding]) -> Verdict:
    """A bug fails whatever else is known; a pass needs an exploration that could have found one."""
    stopped = SIGNALLED.get(exploration.stop_reason)
    gating = [finding for finding in findings if finding.gating and finding.suppressed_by is None]
    if gating:
        count = f"{len(gating)} gating finding{'s' if len(gating) > 1 else ''}"
        return Verdict("fail", stopped or EXIT_FAIL, count)
    if stopped:
        return Verdict("inconclusive", stopped, exploration.stop_reason.value)
    missing = _missing(gate, exploration)
    if missing:
        return Verdict(
            "inconclusive", EXIT_INCONCLUSIVE, "not explored enough to pass: " + "; ".join(missing)
        )
    return Verdict("pass", EXIT_PASS, "nothing that gates was found, and the level was explored")


def _missing(gate: GateSettings, exploration: Exploration) -> list[str]:
    missing = []
    total, reached = len(exploration.goals), int((exploration.goal_step >= 0).sum())
    if reached < gate.min_goals_reached * total:
        missing.append(
            f"{reached} of {total} nav-mesh goals were reached, gate.min_goals_reached asks for"
            f" {gate.min_goals_reached:.0%}"
        )
    chance = exploration.discovery_probability
    limit = gate.max_discovery_probability
    if limit is not None and chance > limit:
        missing.append(
            f"the next episode finds something new with a probability of up to {chance:.0%},"
            f" gate.max_discovery_probability asks for {limit:.0%}"
        )
    return missing
