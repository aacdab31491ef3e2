"""The command line: parse, call, print. Results go to stdout, progress and errors to stderr.

Heavy packages are imported inside the commands, so that `--help` answers at once.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Annotated

import typer

from reachtest import __version__
from reachtest.errors import EXIT_BAD_INPUT, EXIT_INTERNAL, BadInput, ReachtestError

app = typer.Typer(
    help="Fuzzing for level geometry: where can the player get to, and where should they?",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)

bench = typer.Typer(help="Measure reachtest itself.", no_args_is_help=True)
app.add_typer(bench, name="bench")

LevelFile = Annotated[Path, typer.Argument(metavar="LEVEL.yaml", help="The level file.")]


def _version(wanted: bool) -> None:
    if wanted:
        print(f"reachtest {__version__}")
        raise typer.Exit


@app.callback()
def _root(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    """Fuzzing for level geometry: where can the player get to, and where should they?"""


@app.command()
def run(
    level: LevelFile,
    out: Annotated[
        Path | None, typer.Option(help="Output folder. [default: reachtest-out/<level name>]")
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Same seed, same report.")] = 0,
    steps: Annotated[int | None, typer.Option(min=1, help="Agent steps over all agents.")] = None,
    time_budget: Annotated[str | None, typer.Option(help="Wall-clock limit: 90s, 30m, 2h.")] = None,
    agents: Annotated[int | None, typer.Option(min=1, help="Agents that explore side by side.")] = None,
    threads: Annotated[int, typer.Option(min=0, help="Simulation threads; 0 takes every core.")] = 0,
    fail_on: Annotated[str | None, typer.Option(help="Kinds of findings that fail, by commas.")] = None,
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
    gate = (
        {"fail_on": [kind.strip() for kind in fail_on.split(",") if kind.strip()]}
        if fail_on is not None
        else {}
    )
    options = pipeline.with_overrides(
        pipeline.RunOptions(level, out, seed, threads), explore=explore, gate=gate
    )
    loaded = pipeline.load(options)
    with StopOnSignal() as interrupted, progress_for(loaded.explore, quiet) as progress:
        report, folder = pipeline.run(loaded, options, [progress], interrupted)
    if as_json:
        print(json.dumps(report.document, indent=1))
    else:
        _print_summary(report, folder)
    raise typer.Exit(report.verdict.exit_code)


@app.command()
def validate(level: LevelFile) -> None:
    """Check a level file and everything it names, without running it, and say what was understood."""
    from reachtest.levels import check_level, load_level

    check = check_level(load_level(level))
    width = max(len(name) for name, _ in check.facts)
    for name, fact in check.facts:
        print(f"{name.ljust(width)}  {fact}")
    for warning in check.warnings:
        print(f"warning: {warning}")
    print(f"{level.name} is valid" + (f", {len(check.warnings)} warnings" if check.warnings else ""))


@bench.command()
def speed(
    level: LevelFile,
    steps: Annotated[int | None, typer.Option(min=1, help="Agent steps. [default: the level's own]")] = None,
    seed: Annotated[int, typer.Option(min=0)] = 0,
    as_json: Annotated[bool, typer.Option("--json", help="One JSON object on stdout.")] = False,
) -> None:
    """How fast the level is explored, beside its bare physics, measured in one run."""
    from dataclasses import asdict

    from reachtest.bench.speed import measure_speed

    figures = asdict(measure_speed(level, steps, seed))
    if as_json:
        print(json.dumps(figures))
    else:
        width = max(map(len, figures))
        for name, value in figures.items():
            print(
                f"{name.ljust(width)}  {value:>12,.{2 if value < 100 and isinstance(value, float) else 0}f}"
            )


@app.command()
def schema() -> None:
    """Print the JSON schema of level.yaml, for editors."""
    from reachtest.levels import json_schema

    print(json.dumps(json_schema(), indent=2))


def _print_summary(report: object, folder: Path) -> None:
    from rich.console import Console

    from reachtest.records import Report
    from reachtest.report import console_summary

    assert isinstance(report, Report)
    console = Console(highlight=False, soft_wrap=True)
    console.print(console_summary(report, console.width))
    console.print(f"Written to {folder}/")


def main() -> None:
    """Entry point: the one place where an error becomes a message and an exit status."""
    try:
        app()
    except BadInput as error:
        count = len(error.problems)
        print(f"{count} problem{'s' if count != 1 else ''} in the input, nothing was run:", file=sys.stderr)
        for problem in error.problems:
            print(f"  {problem.where}\n    {problem.found}\n    {problem.remedy}", file=sys.stderr)
        sys.exit(EXIT_BAD_INPUT)
    except ReachtestError as error:
        print(f"internal error: {error}", file=sys.stderr)
        sys.exit(error.exit_status)
    except Exception:
        import traceback

        traceback.print_exc()
        print("internal error: please report the lines above together with the level file", file=sys.stderr)
        sys.exit(EXIT_INTERNAL)
