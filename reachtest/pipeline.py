"""The one flow: level -> world -> exploration -> findings -> report. The only place that wires the stages."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from reachtest import __version__
from reachtest.errors import BadInput, Problem
from reachtest.explore import HEURISTICS, Explorer, Replayer
from reachtest.findings import find, judge
from reachtest.geometry import SurfaceIndex
from reachtest.interfaces import Observer
from reachtest.levels import load_level
from reachtest.logs import McapLog
from reachtest.records import Level, Report, StopReason
from reachtest.report import build_document
from reachtest.report.write import write_reports
from reachtest.world import SIMULATORS


@dataclass(frozen=True)
class RunOptions:
    """What the command line says beside the level file."""

    level: Path
    out: Path | None = None
    seed: int = 0
    threads: int = 0  # 0: every core
    simulator: str = next(iter(SIMULATORS))
    overrides: dict[str, Any] = field(default_factory=dict)  # of `explore` and `gate`


def load(options: RunOptions) -> Level:
    """The level with the command line's overrides. Raises BadInput."""
    level = load_level(options.level, options.overrides)
    unknown = sorted(set(level.explore.heuristics) - set(HEURISTICS))
    if unknown:
        where = f"{options.level.name}: explore.heuristics"
        remedy = f"known heuristics are {', '.join(HEURISTICS)}"
        raise BadInput([Problem(where, f"'{name}' is no reset heuristic", remedy) for name in unknown])
    return level


def run(
    level: Level,
    options: RunOptions,
    observers: Sequence[Observer] = (),
    interrupted: Callable[[], StopReason | None] = lambda: None,
) -> tuple[Report, Path]:
    """Explore, find, judge and write everything; returns the report and the folder it was written to."""
    started_at = datetime.now(UTC).isoformat(timespec="seconds")
    folder = options.out or Path("reachtest-out") / level.name
    _make_folder(folder)
    simulator = SIMULATORS[options.simulator](level, level.explore.lanes, options.threads)
    surface = SurfaceIndex(level.navmesh.triangles, level.explore.expected_within_m)
    round_s = level.explore.reset_interval * simulator.step_s
    with McapLog(folder / "run.mcap", level, round_s) as log:
        explorer = Explorer(level, simulator, surface, options.seed, [*observers, log], interrupted)
        exploration = explorer.run()
        replayer = Replayer(level, simulator, exploration.points, options.seed)
        replayer.check()
        findings = find(level, exploration, replayer)
        log.finish(findings)
    verdict = judge(level.gate, exploration, findings)
    document = build_document(level, exploration, findings, verdict, __version__, started_at)
    report = Report(level, exploration, findings, verdict, __version__, started_at, document)
    write_reports(report, folder)
    return report, folder


def _make_folder(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        found = f"'{folder}' cannot be made: {error.strerror}"
        raise BadInput(
            [Problem("command line: --out", found, "name a folder that can be written")]
        ) from error


def with_overrides(options: RunOptions, **sections: dict[str, Any]) -> RunOptions:
    """Options with more overrides; None values are left out."""
    kept = {name: {k: v for k, v in values.items() if v is not None} for name, values in sections.items()}
    return dataclasses.replace(options, overrides={name: values for name, values in kept.items() if values})
