"""The command line: lists the commands, and turns what goes wrong into a message and an exit status.

Results go to stdout, progress and errors to stderr.
"""

from __future__ import annotations

import sys
from typing import Annotated

import typer

from reachtest import __version__
from reachtest.commands.baseline import baseline
from reachtest.commands.bench import bench
from reachtest.commands.check import schema, validate
from reachtest.commands.diff import diff
from reachtest.commands.navmesh import navmesh
from reachtest.commands.replay import replay
from reachtest.commands.run import run
from reachtest.errors import EXIT_BAD_INPUT, EXIT_INTERNAL, BadInput, ReachtestError

app = typer.Typer(
    help="Fuzzing for level geometry: where can the player get to, and where should they?",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)
for command in (run, validate, schema):
    app.command()(command)
app.command()(diff)
app.command()(replay)
app.add_typer(baseline, name="baseline")
app.add_typer(bench, name="bench")
app.add_typer(navmesh, name="navmesh")


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
    except OSError as error:
        print(f"cannot go on: {error.filename or 'a file'}: {error.strerror or error}", file=sys.stderr)
        sys.exit(EXIT_BAD_INPUT)
    except ReachtestError as error:
        print(f"internal error: {error}", file=sys.stderr)
        sys.exit(error.exit_status)
    except Exception:
        import traceback

        traceback.print_exc()
        print("internal error: please report the lines above together with the level file", file=sys.stderr)
        sys.exit(EXIT_INTERNAL)
