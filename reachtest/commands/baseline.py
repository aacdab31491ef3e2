"""`reachtest baseline`: the file of known bugs."""

from __future__ import annotations

from datetime import UTC, date, datetime
from pathlib import Path
from typing import Annotated

import typer

from reachtest.commands.say import say

baseline = typer.Typer(help="Known bugs, which do not fail the build.", no_args_is_help=True)


@baseline.callback()
def _root() -> None:
    """Known bugs, which do not fail the build."""


@baseline.command()
def update(
    out: Annotated[Path, typer.Argument(metavar="OUT", help="Output folder of a run, or its report.json.")],
    reason: Annotated[str, typer.Option(help="Why the bugs are let be.")],
    author: Annotated[str, typer.Option(help="Who says so.")],
    file: Annotated[Path, typer.Option(help="The file of known bugs.")] = Path("baseline.yaml"),
    expires: Annotated[
        str | None, typer.Option(metavar="YYYY-MM-DD", help="Last day on which they do not fail the build.")
    ] = None,
    only: Annotated[
        list[str] | None, typer.Option(metavar="ID", help="This finding only; may be given several times.")
    ] = None,
    prune: Annotated[bool, typer.Option("--prune", help="Remove what expired or was fixed.")] = False,
) -> None:
    """Write the gating findings of a run to the file of known bugs.

    What stands there stays. A known bug that expired and is still there gets a new entry.
    """
    from reachtest.baseline.update import Note, update_baseline
    from reachtest.results import read_result

    today = datetime.now(UTC).date()
    note = Note(_said("reason", reason), _said("author", author), today, _day(expires))
    done = update_baseline(file, read_result(out), note, only or (), prune)
    for sign, entries in (("+", done.added), ("-", done.removed)):
        for entry in entries:
            say(f"{sign} {entry.id}  {entry.title}")
    changed = f"{len(done.added)} added, {len(done.removed)} removed, {done.kept} kept"
    say(f"{file}: {changed}" if done.added or done.removed else f"nothing to add ({done.kept} known)")


def _said(option: str, text: str) -> str:
    from reachtest.errors import BadInput, Problem

    if not text.strip():
        raise BadInput([Problem(f"command line: --{option}", "is empty", "say it in a few words")])
    return " ".join(text.split())


def _day(text: str | None) -> date | None:
    from reachtest.errors import BadInput, Problem

    if text is None:
        return None
    try:
        day = date.fromisoformat(text)
    except ValueError as error:
        remedy = "write a date as 2030-12-31"
        raise BadInput([Problem("command line: --expires", f"found {text!r}", remedy)]) from error
    if day < datetime.now(UTC).date():
        raise BadInput([Problem("command line: --expires", f"{text} is past", "give a day to come")])
    return day
