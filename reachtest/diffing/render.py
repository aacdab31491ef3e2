"""A comparison as text, Markdown and JSON. Positions are in the level file's own axes and units, as NEW has them."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np

from reachtest.diffing.areas import Area
from reachtest.diffing.compare import Difference
from reachtest.records import Floats, Frame
from reachtest.results import FoundBefore, Result

MOST = 20  # of a list, for people
_SPECIAL = re.compile(r"([\\`*_\[\]#|~$<>])")
Section = tuple[str, list[str]]


def text(difference: Difference) -> str:
    """For the terminal."""
    lines = _head(difference)
    for title, rows in _sections(difference):
        lines += ["", f"{title} ({len(rows)})", *(f"  {row}" for row in _some(rows))]
    return "\n".join(map(_printable, lines)) + "\n"


def markdown(difference: Difference) -> str:
    """For a pull request."""
    name = difference.new.report.level.name
    lines = [f"# {_escape(name)}: what changed", "", *(f"- {_escape(line)}" for line in _head(difference))]
    for title, rows in _sections(difference):
        lines += ["", f"## {title} ({len(rows)})", ""]
        lines += [f"- {_escape(row)}" for row in _some(rows)] or ["none"]
    return "\n".join(lines) + "\n"


def as_json(difference: Difference) -> str:
    """For programs."""
    areas = None
    if difference.unreachable is not None and difference.reachable is not None:
        areas = {
            "may_be_chance": difference.may_be_chance,
            "became_unreachable": [_area(area, difference) for area in difference.unreachable],
            "became_reachable": [_area(area, difference) for area in difference.reachable],
        }
    document = {
        "schema_version": 1,
        "old": _run(difference.old),
        "new": _run(difference.new),
        "notes": list(difference.notes),
        "findings": {
            "new": [_finding(finding) for finding in difference.appeared],
            "worse": [{**_finding(new), "old_id": old.id} for old, new in difference.worse],
            "fixed": [_finding(finding) for finding in difference.fixed],
            "not_seen": [{**_finding(finding), "doubt": doubt} for finding, doubt in difference.not_seen],
            "still_there": [{**_finding(new), "old_id": old.id} for old, new in difference.still],
        },
        "areas": areas,
        "exit_code": difference.exit_code,
    }
    return json.dumps(document, indent=1) + "\n"


RENDERERS: dict[str, Callable[[Difference], str]] = {"text": text, "markdown": markdown, "json": as_json}


def _head(difference: Difference) -> list[str]:
    lines = []
    for label, result in (("old", difference.old), ("new", difference.new)):
        report = result.report
        goals = f"{report.coverage.goals_reached:,} of {report.coverage.goals_total:,} goals"
        run = f"seed {report.seed}, {report.run.agent_steps:,} agent steps"
        lines.append(f"{label}: {report.verdict.upper()}, {goals}, {run}  ({result.name})")
    return lines + [f"note: {note}" for note in difference.notes]


def _sections(difference: Difference) -> list[Section]:
    sections = [
        ("New", [_found(finding) for finding in difference.appeared]),
        ("Got worse", [f"{_found(old)} is now {new.id}: {new.title}" for old, new in difference.worse]),
        ("Fixed", [_found(finding) for finding in difference.fixed]),
        (
            "Not seen, but not shown to be fixed",
            [f"{_found(finding)}: {doubt}" for finding, doubt in difference.not_seen],
        ),
        ("Still there", [_found(finding) for _, finding in difference.still]),
    ]
    chance = ", may be chance" if difference.may_be_chance else ""
    for title, areas in (("unreachable", difference.unreachable), ("reachable", difference.reachable)):
        if areas is not None:
            sections.append((f"Became {title}{chance}", [_place(area, difference) for area in areas]))
    return sections


def _found(finding: FoundBefore) -> str:
    where = ", ".join(f"{value:.2f}" for value in finding.source_position)
    gate = (
        "fails the build"
        if finding.gating
        else "known"
        if finding.suppressed_by
        else "does not fail the build"
    )
    return f"{finding.title} at {where}  ({finding.id}, {gate})"


def _place(area: Area, difference: Difference) -> str:
    where = ", ".join(f"{value:.2f}" for value in _source(area.position, difference))
    sides = " x ".join(f"{side:.0f}" for side in _frame(difference).size_m(area.low, area.high).tolist())
    counted = (("goal", area.goals), ("place", area.cells))
    mesh = "on the nav-mesh" if area.on_navmesh else "off the nav-mesh"
    counts = [f"{count:,} {noun}{'s' * (count != 1)}" for noun, count in counted if count]
    size = f" over {sides} m" if (area.high - area.low).max() >= 0.5 else ""
    return f"{where}  ({mesh}, {' and '.join(counts)}{size})"


def _some(rows: list[str]) -> Iterable[str]:
    return rows if len(rows) <= MOST else [*rows[:MOST], f"...and {len(rows) - MOST:,} more in --format json"]


def _source(position: Floats, difference: Difference) -> list[float]:
    return [value + 0.0 for value in _frame(difference).to_source(position).round(3).tolist()]


def _frame(difference: Difference) -> Frame:
    return Frame(np.array(difference.new.report.config.frame.matrix), "", "")


def _run(result: Result) -> dict[str, Any]:
    report = result.report
    return {
        "level": report.level.name,
        "sha256": report.level.sha256,
        "verdict": report.verdict,
        "seed": report.seed,
        "agent_steps": report.run.agent_steps,
        "goals_total": report.coverage.goals_total,
        "goals_reached": report.coverage.goals_reached,
    }


def _finding(finding: FoundBefore) -> dict[str, Any]:
    keys = {"id", "kind", "severity", "gating", "title", "position", "source_position", "suppressed_by"}
    return finding.model_dump(mode="json", include=keys)


def _area(area: Area, difference: Difference) -> dict[str, Any]:
    return {
        "position": area.position.round(3).tolist(),
        "source_position": _source(area.position, difference),
        "bounds": [area.low.round(3).tolist(), area.high.round(3).tolist()],
        "goals": area.goals,
        "cells": area.cells,
        "on_navmesh": area.on_navmesh,
    }


def _printable(line: str) -> str:
    return "".join(char if char.isprintable() else " " for char in line)


def _escape(line: str) -> str:
    return _SPECIAL.sub(r"\\\1", _printable(line))
