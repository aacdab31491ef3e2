"""The risk that remains, for programs and for people: a bound, what was observed lately, and how both went."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from reachtest.records import Exploration, Report, RiskSample

DIGITS = 6  # of a probability
CONFIDENCE = 0.95
SETTLED = 0.8  # of the most cells seen once at any time: above it, estimates fell short of longer runs
BARS = "▁▂▃▄▅▆▇█"


def risk_section(exploration: Exploration, goals_open: bool) -> dict[str, Any]:
    """report.json's `risk`: Good-Turing and Chao2 for incidence data; the unit of sampling is one episode.

    `goals_open`: the nav-mesh knows of ground that nobody has come to yet.
    """
    if exploration.episodes == 0:
        return {"discovery_probability": None, "estimated_positions_total": None, "unit": "episode"}
    curve = exploration.risk_curve
    return {
        "discovery_probability": round(exploration.discovery_probability, DIGITS),
        "estimated_positions_total": round(exploration.estimated_cells_total, 1),
        "unit": "episode",
        "positions_seen": exploration.cells_total,
        "recent": _recent(curve[-1]) if curve else None,
        "ten_times_longer": _ten_times_longer(curve) if is_settled(curve, goals_open) else None,
        "curve": [_sample(sample) for sample in curve],
    }


def _recent(sample: RiskSample) -> dict[str, Any] | None:
    """What became of the latest episodes, with Wilson's interval for the share that found something new."""
    from scipy.stats import binomtest  # slow to import, and only wanted at the end of a run

    share = sample.recent_share
    if share is None:
        return None
    test = binomtest(sample.recent_discovering, sample.recent_episodes)
    interval = test.proportion_ci(CONFIDENCE, method="wilson")
    return {
        "episodes": sample.recent_episodes,
        "discovering": sample.recent_discovering,
        "share": round(share, DIGITS),
        "low": round(float(interval.low), DIGITS),
        "high": round(float(interval.high), DIGITS),
    }


def _ten_times_longer(curve: Sequence[RiskSample]) -> dict[str, float]:
    low, high = curve[-1].ten_times_longer
    return {"positions_low": round(low, 1), "positions_high": round(high, 1)}


def is_settled(curve: Sequence[RiskSample], goals_open: bool) -> bool:
    """Whether known ground fills up; as long as new ground opens up, what lies behind it shows in no statistics."""
    once = [sample.cells_once for sample in curve]
    return bool(once) and not goals_open and once[-1] <= SETTLED * max(once)


def _sample(sample: RiskSample) -> dict[str, Any]:
    share = sample.recent_share
    return {
        "agent_steps": sample.agent_steps,
        "episodes": sample.episodes,
        "discovering": sample.discovering,
        "cells": sample.cells_total,
        "discovery_probability": round(sample.discovery_probability, DIGITS),
        "recent_share": None if share is None else round(share, DIGITS),
        "estimated_positions_total": round(sample.estimated_cells_total, 1),
        "goals_reached": sample.goals_reached,
        "points": sample.points,
    }


def risk_sentence(report: Report) -> str:
    """The bound and the estimated total."""
    risk, settings = report.document["risk"], report.exploration.settings
    if risk["discovery_probability"] is None:
        return "unknown: no episode was run"
    episode_s = settings.reset_interval * settings.action_repeat / settings.physics_hz
    return (
        f"one more {risk['unit']} ({episode_s:.0f} s of play) finds a new place with at most "
        f"{_percent(risk['discovery_probability'])} % probability; {report.exploration.cells_total:,} of an "
        f"estimated {risk['estimated_positions_total']:,.0f} places were seen"
    )


def recent_sentence(report: Report) -> str:
    """What the latest episodes found, and what a longer run would; empty where nobody kept count."""
    recent = report.document["risk"].get("recent")
    if recent is None:
        return ""
    between = f"{_percent(recent['low'])} to {_percent(recent['high'])} %"
    found = f"{_percent(recent['share'])} % of the latest {recent['episodes']:,} episodes found a new place"
    return f"{found} ({between}); {_longer(report)}"


def _longer(report: Report) -> str:
    longer = report.document["risk"]["ten_times_longer"]
    if longer is None:
        missing = bool((report.exploration.goal_step < 0).any())
        why = (
            "what lies behind goals that are still open is in no count"
            if missing
            else "new ground still opens up"
        )
        return f"{why}, so it is too early to tell what a longer run would see"
    low, high = longer["positions_low"], longer["positions_high"]
    return f"ten times the steps are likely to see {low:,.0f} to {high:,.0f} places"


def sparkline(report: Report) -> str:
    """How the share of episodes that found a new place went, a character a sample; full height is all of them."""
    shares = [sample["recent_share"] for sample in report.document["risk"].get("curve", ())]
    return "".join(BARS[min(int(share * len(BARS)), len(BARS) - 1)] for share in shares if share is not None)


def _percent(share: float) -> str:
    return f"{100 * share:.3g}"
