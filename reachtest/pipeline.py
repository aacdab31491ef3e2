"""The one flow: level -> world -> exploration -> findings -> report. The only place that wires the stages."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from datetime import UTC, date, datetime
from pathlib import Path
from typing import Any

from reachtest import __version__
from reachtest.baseline import Baseline, apply_baseline, baseline_of, read_baseline
from reachtest.confirm import Confirmer
from reachtest.errors import BadInput, Problem
from reachtest.explore import Explorer, Replayer, check_heuristics
from reachtest.findings import find, judge
from reachtest.findings.audit import missed_ground
from reachtest.findings.evidence import Evidence
from reachtest.interfaces import Observer, Simulator, Teller
from reachtest.levels import load_level
from reachtest.logs import McapLog
from reachtest.navmesh.allowed import expected_surface
from reachtest.navmesh.islands import Islands
from reachtest.navmesh.survey import Survey
from reachtest.records import Level, Report, StopReason
from reachtest.replaying.keep import write_state
from reachtest.report import build_document
from reachtest.report.write import write_coverage, write_reports
from reachtest.world import SIMULATORS


@dataclass(frozen=True)
class RunOptions:
    """What the command line says beside the level file."""

    level: Path
    out: Path | None = None
    seed: int = 0
    threads: int = 0  # 0: every core
    simulator: str = next(iter(SIMULATORS))
    config: Path | None = None  # sections `explore` and `gate`, over the level's
    overrides: dict[str, Any] = field(default_factory=dict)  # of the same, over both
    baseline: Path | None = None  # known bugs; wins over the level's `gate.baseline`
    audit: bool = False  # also list ground that the nav-mesh misses
    today: date = field(default_factory=lambda: datetime.now(UTC).date())  # for known bugs that expire


def load(options: RunOptions) -> Level:
    """The level under the configuration and the command line's overrides. Raises BadInput."""
    level = load_level(options.level, options.overrides, options.config)
    check_heuristics(level, options.config)
    return level


def run(
    level: Level,
    options: RunOptions,
    observers: Sequence[Observer] = (),
    interrupted: Callable[[], StopReason | None] = lambda: None,
    tell: Teller = lambda what, number, total: None,
) -> tuple[Report, Path]:
    """Explore, find, judge and write everything; returns the report and the folder it was written to.

    Once `interrupted`, what was found by then is judged and written, unconfirmed where that was not done yet.
    """
    started_at = datetime.now(UTC).isoformat(timespec="seconds")
    known = _baseline(level, options)
    folder = options.out or Path("reachtest-out") / level.name
    _make_folder(folder)
    simulator = SIMULATORS[options.simulator](level, level.explore.lanes, options.threads)
    surface, islands = expected_surface(level), Islands(level.navmesh)
    round_s = level.explore.reset_interval * simulator.step_s
    with McapLog(folder / "run.mcap", level, round_s) as log:
        observed = [*observers, log]
        explorer = Explorer(level, simulator, surface, options.seed, observed, interrupted, islands, tell)
        exploration = explorer.run()
        replayer = Replayer(level, simulator, exploration.points, options.seed, exploration.headings)
        replayer.check()
        survey = Survey(level, exploration, islands)
        stop = (lambda: interrupted() is not None, tell)
        tools = (_simulate(options), *stop, replayer.path_to_fall)
        confirmer = Confirmer(level, simulator, surface, options.seed, *tools)
        findings = confirmer.confirm(find(level, exploration, replayer, survey, tell))
        exploration = dataclasses.replace(exploration, stop_reason=interrupted() or exploration.stop_reason)
        log.finish(findings)
    enough = judge(level.gate, exploration, (), survey.counts).name == "pass"
    beside: dict[str, Any] = {}
    if known is not None:
        findings, outcome = apply_baseline(known, findings, options.today)
        beside["baseline"] = outcome.section(level.sha256, enough, exploration.risk)
    if options.audit:
        beside["audit"] = missed_ground(Evidence(level, exploration, replayer, survey))
    verdict = judge(level.gate, exploration, findings, survey.counts)
    document = build_document(level, exploration, findings, verdict, __version__, started_at, survey) | beside
    document["coverage"]["sufficient"] = enough
    report = Report(level, exploration, findings, verdict, __version__, started_at, document)
    write_reports(report, folder)
    write_coverage(report, folder)
    write_state(folder, level, findings, confirmer.judge, options.simulator)
    return report, folder


def _simulate(options: RunOptions) -> Callable[[Level, int], Simulator]:
    return lambda level, agents: SIMULATORS[options.simulator](level, agents, options.threads)


def _baseline(level: Level, options: RunOptions) -> Baseline | None:
    """The known bugs that the command line or the level names. Raises BadInput."""
    if options.baseline is not None:
        return read_baseline(options.baseline, level.name)
    return baseline_of(level)


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
