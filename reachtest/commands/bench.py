"""`reachtest bench`: measures reachtest itself."""

from __future__ import annotations

import json
from typing import Annotated

import typer

from reachtest.commands.arguments import LevelFile

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
        print(json.dumps(figures))
    else:
        width = max(map(len, figures))
        for name, value in figures.items():
            print(
                f"{name.ljust(width)}  {value:>12,.{2 if value < 100 and isinstance(value, float) else 0}f}"
            )
