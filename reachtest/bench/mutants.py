"""How good the tester is on a level: bugs are planted one at a time, and the test is run on each."""

from __future__ import annotations

import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np

from reachtest import pipeline
from reachtest.errors import BadInput, Problem
from reachtest.explore.goals import sample_goals
from reachtest.mutants.decide import Change
from reachtest.mutants.detect import found_by, unreached_in
from reachtest.mutants.ground import Ground, survey_ground
from reachtest.mutants.plant import KINDS, plant
from reachtest.mutants.records import Planted
from reachtest.navmesh.coverage import goal_islands
from reachtest.navmesh.islands import Islands
from reachtest.records import Floats, Level, Report


@dataclass(frozen=True)
class Tried:
    """One mutant that counts, and what the test made of it."""

    kind: str
    position: tuple[float, float, float]  # level coordinates [m]
    source_position: tuple[float, float, float]
    size: tuple[float, float, float]  # [m]
    changes: tuple[str, ...]  # by the flood fill
    found: str | None  # the kind of the finding that tells it
    noticed: bool  # not found, but its goals were unreached and the verdict was inconclusive
    first_seen_step: int | None
    verdict: str
    findings: tuple[str, ...]  # kinds of all findings
    wall_s: float


@dataclass(frozen=True)
class Recall:
    """What a level's mutants came to."""

    level: str
    seed: int
    steps: int
    verdict: str  # of the level without a mutant
    planted: dict[str, int]  # by kind, those that change nothing included
    tried: tuple[Tried, ...]
    wall_s: float

    def row(self, kind: str | None = None) -> tuple[int, int, int, int | None]:
        """Mutants counted, found and noticed, and the median step at which they were first seen."""
        some = [mutant for mutant in self.tried if kind in (None, mutant.kind)]
        steps = [m.first_seen_step for m in some if m.found and m.first_seen_step is not None]
        found = sum(mutant.found is not None for mutant in some)
        return len(some), found, sum(m.noticed for m in some), int(median(steps)) if steps else None


def chosen_kinds(names: str | None) -> tuple[str, ...]:
    """The kinds that a list by commas names, in its order; all for none. Raises BadInput."""
    if names is None:
        return tuple(KINDS)
    chosen = tuple(dict.fromkeys(name.strip() for name in names.split(",") if name.strip()))
    unknown = [name for name in chosen if name not in KINDS]
    if unknown or not chosen:
        remedy = f"known kinds are {', '.join(KINDS)}"
        found = [f"'{name}' is no kind of mutant" for name in unknown] or ["no kind is named"]
        raise BadInput([Problem("command line: --kinds", text, remedy) for text in found])
    return chosen


def measure_recall(
    path: Path, count: int, seed: int, steps: int | None, kinds: tuple[str, ...] = tuple(KINDS)
) -> Recall:
    """Plant up to `count` bugs in the level at `path`, kind after kind in turn. Raises BadInput."""
    began = time.perf_counter()
    options = pipeline.with_overrides(pipeline.RunOptions(path, seed=seed), explore={"steps": steps})
    level = pipeline.load(options)
    ground = survey_ground(level, _goals(level))
    without = _run(level, options)
    planted = dict.fromkeys(kinds, 0)
    tried: list[Tried] = []
    for mutant, change in _in_turn(ground, kinds, seed, planted):
        tried.append(_try(mutant, change, without, options))
        print(f"{len(tried)}/{count} {_line(tried[-1])}", file=sys.stderr, flush=True)
        if len(tried) == count:
            break
    wall_s = time.perf_counter() - began
    return Recall(level.name, seed, level.explore.steps, without.verdict.name, planted, tuple(tried), wall_s)


def _goals(level: Level) -> Floats:
    """The goals [G, 3] that a run asks for: those on islands that the nav-mesh connects to no spawn do not count."""
    goals = sample_goals(level.navmesh, level.explore.goal_spacing_m)
    spawns = np.array([spawn.position for spawn in level.spawns])
    return goals[goal_islands(Islands(level.navmesh), spawns, goals).goals_count]


def _in_turn(
    ground: Ground, kinds: tuple[str, ...], seed: int, planted: dict[str, int]
) -> Iterator[tuple[Planted, Change]]:
    """Mutants that count, one of each kind in turn for as long as the level has a place for it."""
    sources = {kind: plant(ground, kind, seed) for kind in kinds}
    while sources:
        for kind in tuple(sources):
            for mutant, change in sources[kind]:
                planted[kind] += 1
                if change.reasons:
                    yield mutant, change
                    break
            else:
                del sources[kind]


def _try(planted: Planted, change: Change, without: Report, options: pipeline.RunOptions) -> Tried:
    began = time.perf_counter()
    report = _run(planted.level, options)
    mutant, exploration = planted.mutant, report.exploration
    finding = found_by(mutant, change, report.findings, without.findings)
    missing = unreached_in(change, exploration.goals, exploration.goal_step >= 0)
    source = planted.level.frame.to_source(mutant.position)
    return Tried(
        kind=mutant.kind,
        position=_point(mutant.position),
        source_position=_point(source),
        size=_point(2 * mutant.box.half),
        changes=change.reasons,
        found=finding.kind if finding else None,
        noticed=finding is None and missing > 0 and report.verdict.name == "inconclusive",
        first_seen_step=finding.first_seen_step if finding else None,
        verdict=report.verdict.name,
        findings=tuple(f.kind for f in report.findings),
        wall_s=round(time.perf_counter() - began, 1),
    )


def _run(level: Level, options: pipeline.RunOptions) -> Report:
    with tempfile.TemporaryDirectory(prefix="reachtest-") as folder:
        report, _ = pipeline.run(level, replace(options, out=Path(folder)))
    return report


def _point(values: Any) -> tuple[float, float, float]:
    x, y, z = (round(float(value), 2) for value in values)
    return x, y, z


def _line(mutant: Tried) -> str:
    outcome = mutant.found or ("noticed: inconclusive" if mutant.noticed else "MISSED")
    return f"{mutant.kind} at {mutant.source_position} ({', '.join(mutant.changes)}): {outcome}"


def as_markdown(recall: Recall) -> str:
    """The table by kind, and the list of what was missed."""
    head = "| kind | planted | counted | found | recall | noticed | median steps to find |"
    lines = [head, "|---|---:|---:|---:|---:|---:|---:|"]
    rows = [(kind, number, recall.row(kind)) for kind, number in recall.planted.items()]
    rows.append(("all", sum(recall.planted.values()), recall.row()))
    for name, planted, (counted, found, noticed, steps) in rows:
        share = f"{found / counted:.0%}" if counted else "-"
        first = f"{steps:,}" if steps is not None else "-"
        lines.append(f"| {name} | {planted} | {counted} | {found} | {share} | {noticed} | {first} |")
    lines += [
        "",
        f"{recall.level}: seed {recall.seed}, {recall.steps:,} steps a mutant, {recall.wall_s:,.0f} s",
    ]
    missed = [mutant for mutant in recall.tried if mutant.found is None]
    lines += ["", "Missed:" if missed else "Missed: none"]
    lines += [f"- {_line(mutant)}; verdict {mutant.verdict}" for mutant in missed]
    return "\n".join(lines)


def as_data(recall: Recall) -> dict[str, Any]:
    """The same as plain JSON types."""
    counted, found, noticed, steps = recall.row()
    share = round(found / counted, 4) if counted else None
    total = {"counted": counted, "found": found, "noticed": noticed, "recall": share, "median_steps": steps}
    return {**asdict(recall), "total": total}
