"""Findings, the verdict and the report."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from reachtest.records.arrays import Floats
from reachtest.records.exploration import Exploration, Fall, Origin
from reachtest.records.level import Level

KINDS = (
    "unexpected_area",
    "fell_out_of_world",
    "inside_solid",
    "forbidden_zone",
    "stuck",
    "no_return",
    "unreached_area",
    "required_unreached",
    "navmesh_mismatch",
)


SEVERITIES = ("error", "warning")


@dataclass(frozen=True)
class ReplayPath:
    """The way to a finding, re-simulated: episode by episode from a spawn."""

    start: Floats  # [3]
    episodes: tuple[Origin, ...]
    positions: Floats  # [N, 3] every agent step
    duration_s: float
    attempts: int
    succeeded: int
    state: Floats | None = None  # [S] the simulator's state at the start
    actions: NDArray[np.int8] | None = (
        None  # [N, 2] every agent step; of a cut path no chain of episodes is left
    )
    states: Floats | None = None  # [N, S] after every agent step
    stood: Floats | None = None  # [N, 3] where it stood last during the step; NaN if it did not
    found_s: float | None = None  # how long the way was before it was cut


@dataclass(frozen=True)
class Confirmation:
    """How often a finding came about again, each as (attempts, succeeded)."""

    exact: tuple[int, int]  # bit for bit, from its path
    half_step: tuple[int, int]  # at half the physics time step: the found actions and variations of them
    nearby: tuple[int, int]  # variations at the run's own time step


@dataclass(frozen=True)
class Finding:
    """One bug for one human to look at."""

    id: str  # by name where it has one, else by place on a coarse grid: seeds agree but for places at its lines
    kind: str
    severity: str  # "error" | "warning"
    gating: bool
    title: str
    position: Floats  # [3]
    low: Floats  # [3]
    high: Floats  # [3]
    points: int
    exit_point: Floats | None  # [3]
    nearest_named: str | None
    first_seen_step: int | None
    path: ReplayPath | None
    suppressed_by: str | None
    confirmation: Confirmation | None = None  # None: nothing to re-simulate
    fragile: bool = False  # came about again at the coarse time step only, or not at all
    exits: Floats | None = None  # [n, 3] where paths left the nav-mesh on the way to it, thinned out
    details: tuple[str, ...] = ()  # what else there is to say, a line each
    standing: Floats | None = None  # [k, 3] of a pocket: where somebody stood or lay in it
    reach_m: float | None = None  # of a pocket: farthest that anybody got from where it began in it
    target: str | None = None  # the name of the solid, zone or required point that it is about
    others: tuple[Fall, ...] = ()  # falls over other parts of its edge, for where its own path is not enough


@dataclass(frozen=True)
class Verdict:
    """The outcome of a run."""

    name: str  # "pass" | "fail" | "inconclusive"
    exit_code: int
    reason: str
    steps_to_go: int | None = None  # an estimate, where goals or required points are what a pass still takes
    goals_given_up: int = 0  # unreached after enough attempts, and no reason to fail: known, or not asked for


@dataclass(frozen=True)
class Report:
    """What every report output is written from."""

    level: Level
    exploration: Exploration
    findings: tuple[Finding, ...]
    verdict: Verdict
    tool_version: str
    started_at: str  # ISO 8601
    document: dict[str, Any]  # report.json, as the contract has it
