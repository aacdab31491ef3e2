"""report.json as data: the public contract that other programs read.

Whatever depends on the clock or the machine stands under `timing` and nowhere else: the rest is the same,
byte for byte, for the same level, configuration and seed.
"""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np

from reachtest.navmesh.survey import Survey
from reachtest.records import Exploration, Finding, Ints, Level, ReplayPath, Verdict
from reachtest.report.risk import risk_section

SCHEMA_VERSION = 1
POSITION_DIGITS = 3  # 1 mm: finer than any editor's grid, coarse enough to read
FRACTION_DIGITS = 6


def build_document(
    level: Level,
    exploration: Exploration,
    findings: tuple[Finding, ...],
    verdict: Verdict,
    tool_version: str,
    started_at: str,
    survey: Survey | None = None,
) -> dict[str, Any]:
    """The whole of report.json, in plain JSON types, keys in the order of the contract."""
    settings = exploration.settings
    survey = survey or Survey(level, exploration)
    return {
        "schema_version": SCHEMA_VERSION,
        "tool": {"name": "reachtest", "version": tool_version},
        "verdict": verdict.name,
        "verdict_reason": verdict.reason,
        "exit_code": verdict.exit_code,
        "stop_reason": exploration.stop_reason.name.lower(),
        "level": {"name": level.name, "file": level.file.name, "sha256": level.sha256},
        "config": _config(level, exploration),
        "seed": exploration.seed,
        "run": {
            "agent_steps": exploration.agent_steps,
            "episodes": exploration.episodes,
            "agents": settings.agents,
            "diverged_episodes": exploration.diverged_episodes,
            "probe_episodes": exploration.probe_episodes,
            "probe_steps": exploration.probe_steps,
            "steps_to_go": verdict.steps_to_go,
        },
        "coverage": {**_coverage(exploration, survey), "goals_given_up": verdict.goals_given_up},
        "positions": _positions(exploration),
        "risk": risk_section(exploration, bool((exploration.goal_step[survey.counts] < 0).any())),
        "findings": [_finding(level, finding) for finding in findings],
        "timing": _timing(exploration, started_at),
    }


def plain(value: Any, digits: int = FRACTION_DIGITS) -> Any:
    """`value` in JSON types: arrays as lists, floats rounded, NaN and infinity as None."""
    if isinstance(value, dict):
        return {str(key): plain(item, digits) for key, item in value.items()}
    if isinstance(value, np.ndarray):
        return plain(value.tolist(), digits)
    if isinstance(value, list | tuple):
        return [plain(item, digits) for item in value]
    if isinstance(value, np.generic):
        return plain(value.item(), digits)
    if isinstance(value, float):
        return round(value, digits) + 0.0 if math.isfinite(value) else None  # + 0.0: no "-0.0"
    return value


def _place(position: Any) -> Any:
    return plain(position, POSITION_DIGITS)


def _config(level: Level, exploration: Exploration) -> dict[str, Any]:
    return {
        "character": plain(dataclasses.asdict(level.character)),
        "explore": plain(dataclasses.asdict(exploration.settings)),
        "gate": plain(dataclasses.asdict(level.gate)),
        "frame": {
            "up_axis": level.frame.up_axis,
            "units": level.frame.units,
            "matrix": plain(level.frame.matrix),
        },
        "kill_z_m": plain(level.kill_z_m),
        "bounds": _place(level.bounds),
        "spawns": [{"name": spawn.name, "position": _place(spawn.position)} for spawn in level.spawns],
        "zones": [
            {"name": zone.name, "kind": zone.kind, "bounds": _place([zone.low, zone.high])}
            for zone in level.zones
        ],
        "required": [
            {"name": place.name, "position": _place(place.position), "within_m": plain(place.within_m)}
            for place in level.required
        ],
        "solids": [solid.name for solid in level.solids],
        "collision_triangles": len(level.collision),
        "navmesh_triangles": len(level.navmesh.faces),
    }


def _coverage(exploration: Exploration, survey: Survey) -> dict[str, Any]:
    islands = survey.islands
    total = len(exploration.goals)
    reached = int((exploration.goal_step >= 0).sum())
    all_reached = total > 0 and reached == total
    return {
        "goals_total": total,
        "goals_reached": reached,
        "goals_unreached": total - reached,
        "goals_reached_fraction": plain(reached / total) if total else None,
        "all_goals_step": int(exploration.goal_step.max()) if all_reached else None,
        "required_total": len(exploration.required_step),
        "required_reached": int((exploration.required_step >= 0).sum()),
        "goals_connected": int(islands.goals_count.sum()),
        "goals_connected_reached": int((exploration.goal_step[islands.goals_count] >= 0).sum()),
        "goals_unreached_by_mismatch": int(survey.explained.sum()),
        "islands": len(islands.connected),
        "islands_connected": int(islands.connected.sum()),
        "border": _border(exploration.border_pushes),
    }


def _border(pushes: Ints) -> dict[str, Any]:
    """How much of the nav-mesh's border was tried: episodes that pushed at each of its places [n]."""
    return {
        "places": len(pushes),
        "pushed": int((pushes > 0).sum()),
        "pushes_least": int(pushes.min()) if len(pushes) else None,
        "pushes_median": plain(float(np.median(pushes))) if len(pushes) else None,
    }


def _positions(exploration: Exploration) -> dict[str, int]:
    discovered = len(exploration.points)
    expected = int(exploration.points.expected.sum())
    return {"discovered": discovered, "expected": expected, "unexpected": discovered - expected}


def _finding(level: Level, finding: Finding) -> dict[str, Any]:
    path = finding.path
    return {
        "id": finding.id,
        "kind": finding.kind,
        "severity": finding.severity,
        "gating": finding.gating,
        "title": finding.title,
        "position": _place(finding.position),
        "source_position": _place(level.frame.to_source(finding.position)),
        "bounds": _place([finding.low, finding.high]),
        "points": finding.points,
        "exit_point": _exit_point(finding),
        "nearest_named": finding.nearest_named,
        "first_seen_step": finding.first_seen_step,
        "reproduced": {
            "attempts": path.attempts if path else 0,
            "succeeded": path.succeeded if path else 0,
        },
        "confirmation": _confirmation(finding),
        "fragile": finding.fragile,
        "path": _path(path) if path else None,
        "suppressed_by": finding.suppressed_by,
        "exits": None if finding.exits is None else _place(finding.exits),
        "details": list(finding.details),
    }


def _exit_point(finding: Finding) -> Any:
    known = finding.exit_point is not None and np.isfinite(finding.exit_point).all()
    return _place(finding.exit_point) if known else None


def _path(path: ReplayPath) -> dict[str, Any]:
    return {
        "start": _place(path.start),
        "episodes": [dataclasses.asdict(origin) for origin in path.episodes],
        "duration_s": plain(path.duration_s, 3),
        "agent_steps": len(path.positions),
        "found_duration_s": plain(path.duration_s if path.found_s is None else path.found_s, 3),
    }


def _confirmation(finding: Finding) -> dict[str, Any] | None:
    if finding.confirmation is None:
        return None
    return {
        name: {"attempts": attempts, "succeeded": succeeded}
        for name, (attempts, succeeded) in vars(finding.confirmation).items()
    }


def _timing(exploration: Exploration, started_at: str) -> dict[str, Any]:
    measured = {name: plain(seconds, 3) for name, seconds in exploration.timing.items()}
    wall_s = exploration.timing.get("wall_s", 0.0)
    return {
        "started_at": started_at,
        "wall_s": measured.pop("wall_s", None),
        "agent_steps_per_s": round(exploration.agent_steps / wall_s, 1) if wall_s > 0 else None,
        "physics_s": measured.pop("physics_s", None),
        "cache_s": measured.pop("cache_s", None),
        **measured,
    }
