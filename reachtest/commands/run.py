"""`reachtest run`: the main job."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from reachtest.commands.arguments import ConfigFile, LevelFile
from reachtest.commands.say import say
from reachtest.errors import BadInput, Problem


def run(
    level: LevelFile,
    config: ConfigFile = None,
    out: Annotated[
        Path | None, typer.Option(help="Output folder. [default: reachtest-out/<level name>]")
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Same seed, same report.")] = 0,
    steps: Annotated[int | None, typer.Option(min=1, help="Agent steps over all agents.")] = None,
    time_budget: Annotated[str | None, typer.Option(help="Wall-clock limit: 90s, 30m, 2h.")] = None,
    agents: Annotated[int | None, typer.Option(min=1, help="Agents that explore side by side.")] = None,
    threads: Annotated[int, typer.Option(min=0, help="Simulation threads; 0 takes every core.")] = 0,
    fail_on: Annotated[
        str | None, typer.Option(help="Kinds of findings that fail, or error, warning; by commas; or none.")
    ] = None,
    baseline: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Known bugs, which do not fail. [default: the level's]"),
    ] = None,
    audit: Annotated[
        bool, typer.Option("--audit", help="List ground that is walked on and the nav-mesh misses.")
    ] = False,
    quiet: Annotated[bool, typer.Option("--quiet", help="No progress.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="report.json on stdout, nothing else.")] = False,
) -> None:
    """Explore a level, report what is wrong with it, and say so in the exit status.

    0 pass, 1 fail, 2 bad input, 3 internal error, 4 inconclusive, 130/143 interrupted.
    """
    from reachtest import pipeline
    from reachtest.progress import progress_for
    from reachtest.signals import StopOnSignal

    explore = {"steps": steps, "time_budget": time_budget, "agents": agents}
    gate = {} if fail_on is None else {"fail_on": _kinds(fail_on)}
    options = pipeline.with_overrides(
        pipeline.RunOptions(level, out, seed, threads, config=config, baseline=baseline, audit=audit),
        explore=explore,
        gate=gate,
    )
    loaded = pipeline.load(options)
    with StopOnSignal() as interrupted, progress_for(loaded.explore, quiet) as progress:
        report, folder = pipeline.run(loaded, options, [progress], interrupted, progress.tell)
    if as_json:
        say(json.dumps(report.document, indent=1))
    else:
        _print_summary(report, folder)
    raise typer.Exit(report.verdict.exit_code)


def _kinds(fail_on: str) -> list[str]:
    kinds = [kind.strip() for kind in fail_on.split(",") if kind.strip()]
    if not kinds:  # a variable that is not set must not open the gate
        raise BadInput(
            [Problem("--fail-on", "is empty", "give kinds of findings, error or warning, or none")]
        )
    return [] if kinds == ["none"] else kinds


def _print_summary(report: object, folder: Path) -> None:
    from rich.console import Console

    from reachtest.records import Report
    from reachtest.report import console_summary

    assert isinstance(report, Report)
    console = Console(highlight=False, soft_wrap=True)
    with console.capture() as printed:
        console.print(console_summary(report, console.width))
        console.print(f"Written to {folder}/")
    say(printed.get(), end="")
