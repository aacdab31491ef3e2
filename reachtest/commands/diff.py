"""`reachtest diff`: two runs of one level."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from reachtest.commands.say import say


class Format(StrEnum):
    """How to print a comparison."""

    text = "text"
    markdown = "markdown"
    json = "json"


Run = Annotated[Path, typer.Argument(help="Output folder of a run, or its report.json.")]


def diff(
    old: Run,
    new: Run,
    as_: Annotated[Format, typer.Option("--format", help="What to print.")] = Format.text,
) -> None:
    """Compare two runs of a level: findings, coverage, and what became reachable or unreachable.

    0: NEW has no new gating finding, 1: it has, 2: bad input, such as runs of different levels.
    """
    from reachtest.diffing import RENDERERS, compare
    from reachtest.results import read_result

    difference = compare(read_result(old), read_result(new))
    say(RENDERERS[as_.value](difference), end="")
    raise typer.Exit(difference.exit_code)
