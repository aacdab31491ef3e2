"""`reachtest bench`: measures reachtest itself."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Annotated

import typer

from reachtest.commands.arguments import LevelFile
from reachtest.commands.say import say

bench = typer.Typer(help="Measure reachtest itself.", no_args_is_help=True)


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
        say(json.dumps(figures))
    else:
        width = max(map(len, figures))
        for name, value in figures.items():
            say(f"{name.ljust(width)}  {value:>12,.{2 if value < 100 and isinstance(value, float) else 0}f}")


@bench.command()
def stability(
    levels: Annotated[list[Path], typer.Argument(metavar="LEVEL.yaml...", help="The level files.")],
    seeds: Annotated[int, typer.Option(min=1, help="Seeds 0 to N - 1.")] = 20,
    steps: Annotated[int | None, typer.Option(min=1, help="Agent steps. [default: the level's own]")] = None,
    jobs: Annotated[int, typer.Option(min=1, help="Seeds at a time, each on one core.")] = 1,
    as_json: Annotated[bool, typer.Option("--json", help="One JSON object on stdout.")] = False,
) -> None:
    """Whether seeds agree on the verdict and on the findings; status 1 where verdicts differ."""
    from reachtest.bench.stability import as_data, as_markdown, measure_stability

    results = [
        measure_stability(level, seeds, steps, jobs, lambda line: print(line, file=sys.stderr))
        for level in levels
    ]
    say(json.dumps({"levels": as_data(results)}) if as_json else as_markdown(results))
    raise typer.Exit(0 if all(result.agreed for result in results) else 1)


@bench.command()
def mutants(
    level: LevelFile,
    count: Annotated[int, typer.Option(min=1, help="Bugs that are planted, one at a time.")] = 25,
    seed: Annotated[int, typer.Option(min=0, help="Of the places and of the runs.")] = 0,
    steps: Annotated[
        int | None, typer.Option(min=1, help="Agent steps a mutant. [default: the level's own]")
    ] = None,
    kinds: Annotated[
        str | None, typer.Option(help="Kinds of bugs, by commas: hole, missing wall, ... [default: all]")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="One JSON object on stdout.")] = False,
) -> None:
    """How good the tester is on a level: plants bugs in it, one at a time, and counts which are found."""
    from reachtest.bench.mutants import as_data, as_markdown, chosen_kinds, measure_recall

    recall = measure_recall(level, count, seed, steps, chosen_kinds(kinds))
    say(json.dumps(as_data(recall)) if as_json else as_markdown(recall))
