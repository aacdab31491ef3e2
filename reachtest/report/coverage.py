"""coverage.json: where the characters got to, coarse enough to compare two runs (`reachtest diff`)."""

from __future__ import annotations

import json
from typing import Any

import numpy as np

from reachtest.records import Exploration, Report

CELL_M = (
    4.0  # as the goals' default spacing: an area worth a look has a cell without neighbours in the other run
)
_DIGITS = 2


def render(report: Report) -> str:
    """Every goal and one standing place of every cell, one a line."""
    exploration = report.exploration
    head = {"schema_version": 1, "level": report.level.name, "sha256": report.level.sha256, "cell_m": CELL_M}
    rows = {"goals": _goals(exploration), "stood": _stood(exploration)}
    lists = ["  " + json.dumps(name) + ": [\n" + _lines(rows[name]) + "  ]" for name in rows]
    return (
        "{\n"
        + "".join(f"  {json.dumps(k)}: {json.dumps(v)},\n" for k, v in head.items())
        + ",\n".join(lists)
        + "\n}\n"
    )


def _lines(rows: list[list[Any]]) -> str:
    return ",\n".join(f"    {json.dumps(row)}" for row in rows) + ("\n" if rows else "")


def _goals(exploration: Exploration) -> list[list[Any]]:
    """x, y, z [m] in level coordinates and the agent step at which it was reached, -1 if it was not."""
    places = (exploration.goals.round(_DIGITS) + 0.0).tolist()
    return [[*place, step] for place, step in zip(places, exploration.goal_step.tolist(), strict=True)]


def _stood(exploration: Exploration) -> list[list[Any]]:
    """x, y, z [m] of the place found first in each cell, and 1 if it is expected, 0 if not; expected ones first."""
    points = exploration.points
    standing = np.flatnonzero(points.grounded)
    standing = standing[np.argsort(~points.expected[standing], kind="stable")]
    places = points.positions[standing].round(_DIGITS) + 0.0
    _, first = np.unique(np.floor(places / CELL_M), axis=0, return_index=True)
    chosen = np.sort(first)
    expected = points.expected[standing[chosen]].astype(int).tolist()
    return [[*place, known] for place, known in zip(places[chosen].tolist(), expected, strict=True)]
