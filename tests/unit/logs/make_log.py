"""A short made-up run, and its log."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from reachtest.logs import McapLog
from reachtest.records import Finding, RoundRecord
from tests.unit.report.make import make_finding, make_level

STEPS, AGENTS, ROUND_S = 128, 16, 16.0


def make_round(number: int, new: int = 25) -> RoundRecord:
    """Round `number`: wandering agents, one of them lost in its second half, and `new` new points."""
    random = np.random.default_rng(number)
    trajectories = np.cumsum(random.normal(0.0, 0.4, (STEPS, AGENTS, 3)), axis=0)
    trajectories[STEPS // 2 :, 3] = np.nan
    return RoundRecord(
        round=number,
        agent_steps=(number + 1) * STEPS * AGENTS,
        sim_time_s=(number + 1) * ROUND_S,
        trajectories=trajectories,
        new_points=random.uniform(-50.0, 50.0, (new, 3)),
        new_expected=random.random(new) < 0.8,
        points=(number + 1) * new,
        goals_reached=min(number, 20),
        goals_total=20,
        falls=number // 5,
    )


def make_findings() -> tuple[Finding, ...]:
    """An error with a path and a warning without."""
    return make_finding(), make_finding(id="stuck-1", severity="warning", kind="stuck", path=None)


def write_log(path: Path, rounds: int, findings: tuple[Finding, ...] = ()) -> Path:
    """Write the log of `rounds` rounds to `path`."""
    with McapLog(path, make_level(), ROUND_S) as log:
        for number in range(rounds):
            log.on_round(make_round(number))
        log.finish(findings)
    return path
