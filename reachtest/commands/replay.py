"""`reachtest replay`: a run's findings once more."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from reachtest.commands.say import say

if TYPE_CHECKING:
    from reachtest.replaying.kept import KeptFinding, State


def replay(
    out: Annotated[Path, typer.Argument(metavar="OUT", help="The output folder of a run.")],
    finding: Annotated[
        str | None, typer.Argument(metavar="[FINDING]", help="Its id, or how it begins. [default: all]")
    ] = None,
    level: Annotated[
        Path | None, typer.Option(metavar="FILE", help="The level file. [default: the run's]")
    ] = None,
    path: Annotated[
        Path | None, typer.Option(metavar="FILE.pts", help="Write the way: one 'x y z' a line.")
    ] = None,
    mcap: Annotated[
        Path | None, typer.Option(metavar="FILE.mcap", help="Write the way for Foxglove, Lichtblick, Rerun.")
    ] = None,
    video: Annotated[
        Path | None, typer.Option(metavar="FILE.mp4", help="Film the way: .mp4 (with ffmpeg) or .gif.")
    ] = None,
) -> None:
    """Simulate what a run found again, on the level as it is now, and say pass or fail for each finding.

    0 all that has a path came about again, 1 some did not, 2 bad input, 4 nothing has a path: only a run can tell.
    Files are written of FINDING, or of the first one.
    """
    opengl = os.environ.pop("MUJOCO_GL", None)  # a broken one is no reason not to simulate
    from reachtest.replaying import repeat, show
    from reachtest.replaying.state import read_state
    from reachtest.replaying.video import check_video, write_video

    targets = [target for target in (path, mcap, video) if target]
    show.check_places(targets)
    state = read_state(out)
    chosen = _chosen(state, finding)
    now = repeat.load(repeat.find_level(out, state, level), state)
    if video:
        check_video(video, now, opengl)
    changed = repeat.changes(now, state)
    for change in changed:
        say(f"changed since the run: {change}")
    now = repeat.at_its_step(now, state)
    results = repeat.repeat(now, state, chosen, bool(changed))
    for result in results:
        say(show.line(now, result))
    say(show.summary(results))
    shown = show.first_way(results) if targets else None
    if path and shown:
        show.write_points(path, now, shown)
    if mcap and shown:
        show.write_mcap(mcap, now, shown)
    if video and shown:
        write_video(video, now, shown, opengl)
    for target in targets:
        say(f"{target}: {shown.finding.id if shown else ''}")
    raise typer.Exit(_status([result.passed for result in results]))


def _status(passed: list[bool | None]) -> int:
    from reachtest.errors import EXIT_FAIL, EXIT_INCONCLUSIVE, EXIT_PASS

    if False in passed:
        return EXIT_FAIL
    return EXIT_PASS if True in passed or not passed else EXIT_INCONCLUSIVE


def _chosen(state: State, name: str | None) -> list[KeptFinding]:
    """The findings that `name` is the id of or the beginning of; all for None. Raises BadInput."""
    from reachtest.errors import BadInput, Problem

    everything = list(state.kept.findings)
    if name is None:
        return everything
    exact = [finding for finding in everything if finding.id == name]
    some = exact or [finding for finding in everything if finding.id.startswith(name)]
    if len(some) == 1:
        return some
    found = f"'{name}' is {'no finding' if not some else 'the beginning of several findings'} of this run"
    known = ", ".join(finding.id for finding in some or everything) or "none"
    raise BadInput([Problem("command line: FINDING", found, f"its findings are: {known}")])
