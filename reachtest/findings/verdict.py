"""The verdict: fail, pass, or not enough explored to say."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from reachtest.errors import EXIT_FAIL, EXIT_INCONCLUSIVE, EXIT_PASS, EXIT_SIGINT, EXIT_SIGTERM
from reachtest.findings.effort import given_up, lacking
from reachtest.records import Bools, Exploration, Finding, GateSettings, StopReason, Verdict

SIGNALLED = {StopReason.INTERRUPTED: EXIT_SIGINT, StopReason.TERMINATED: EXIT_SIGTERM}


def judge(
    gate: GateSettings, exploration: Exploration, findings: Sequence[Finding], counts: Bools | None = None
) -> Verdict:
    """A bug fails whatever else is known; a pass needs an exploration that could have found one.

    `counts` [G] are the goals that a pass needs (default: all): see `navmesh.survey`. Those that can be called
    unreached are a finding; where it does not gate (it is known, or the gate does not ask for it) they are given up.
    """
    counts = np.ones(len(exploration.goals), dtype=np.bool_) if counts is None else counts
    lost = given_up(exploration, counts)
    stopped = SIGNALLED.get(exploration.stop_reason)
    gating = [finding for finding in findings if finding.gating and finding.suppressed_by is None]
    quiet = 0 if any(finding.kind == "unreached_area" for finding in gating) else int(lost.sum())
    if gating:
        count = f"{len(gating)} gating finding{'s' if len(gating) > 1 else ''}"
        return Verdict("fail", stopped or EXIT_FAIL, count, goals_given_up=quiet)
    if stopped:
        return Verdict("inconclusive", stopped, exploration.stop_reason.value, goals_given_up=quiet)
    missing, steps = _missing(gate, exploration, counts & ~lost)
    known = _known_unreached(lost)
    if missing:
        reason = "not explored enough to pass: " + "; ".join(missing) + known
        return Verdict("inconclusive", EXIT_INCONCLUSIVE, reason, steps, quiet)
    reason = "nothing that gates was found, and the level was explored"
    reason += known + _left_out(exploration, counts)
    return Verdict("pass", EXIT_PASS, reason, goals_given_up=quiet)


def _known_unreached(lost: Bools) -> str:
    """The goals [G] that were given up and do not gate."""
    count = int(lost.sum())
    are = "are" if count != 1 else "is"
    told = f"{count} of {len(lost)} goals {are} known to be unreached"
    return f"; {told}, which does not fail the build" if count else ""


def _left_out(exploration: Exploration, counts: Bools) -> str:
    """What a pass does not speak of: the unreached goals that do not count."""
    left = int((~counts & (exploration.goal_step < 0)).sum())
    goals = f"{left} of {len(exploration.goals)} goals do not count"
    return f"; {goals}: no spawn is connected to them, or the character is barred" if left else ""


def _missing(gate: GateSettings, exploration: Exploration, wanted: Bools) -> tuple[list[str], int | None]:
    """What a pass still takes, with the goals that are `wanted` [G], and an estimate of the agent steps."""
    missing = []
    steps = exploration.goal_step[wanted]
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
    untried, to_go = lacking(exploration, wanted, too_few)
    missing += untried
    chance = exploration.risk
    limit = gate.max_discovery_probability
    if limit is not None and chance > limit:
        missing.append(
            f"the next episode finds something new with a probability of up to {chance:.0%},"
            f" gate.max_discovery_probability asks for {limit:.0%}"
        )
    return missing, to_go
