"""A repeated path as files: for a level editor (.pts) and for Foxglove, Lichtblick and Rerun (.mcap)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from errno import EISDIR
from os import strerror
from pathlib import Path
from tempfile import TemporaryFile

import numpy as np

from reachtest.errors import BadInput, Problem
from reachtest.files import write_whole
from reachtest.logs import McapLog
from reachtest.records import Finding, Floats, Level, ReplayPath, RoundRecord
from reachtest.replaying.repeat import Repeated

_STEPS_A_RECORD = 8  # the log shows every step of rounds this short


def line(level: Level, repeated: Repeated) -> str:
    """What became of a finding, for people."""
    finding = repeated.finding
    if repeated.positions is None:
        return f"-     {finding.id}: {repeated.note}; {finding.title}"
    seconds = len(repeated.positions) * level.explore.action_repeat / level.explore.physics_hz
    verdict = "pass" if repeated.passed else "FAIL"
    return f"{verdict}  {finding.id}: {repeated.note}, {seconds:.1f} s; {finding.title}"


def summary(results: Sequence[Repeated]) -> str:
    """All of them in a line."""
    if not results:
        return "the run found nothing, so there is nothing to repeat"
    passed = [result.passed for result in results]
    untold = passed.count(None)
    again = f"{passed.count(True)} of {len(passed)} came about again"
    return f"{again}, {untold} cannot be told without a run" if untold else again


def write_points(path: Path, level: Level, repeated: Repeated) -> None:
    """One "x y z" a line in the level's own axes and units: the leak file of the Quake compilers. Raises BadInput."""
    places = level.frame.to_source(way_of(repeated)) + 0.0  # + 0.0: no "-0"
    text = "".join(f"{x:.6f} {y:.6f} {z:.6f}\n" for x, y, z in places.tolist())
    with_place(path, lambda part: part.write_text(text, encoding="ascii"))


def write_mcap(path: Path, level: Level, repeated: Repeated) -> None:
    """The level, its nav-mesh, the character on its way and the finding. Raises BadInput."""
    step_s = level.explore.action_repeat / level.explore.physics_hz
    way = way_of(repeated)
    parts = [way[begin : begin + _STEPS_A_RECORD] for begin in range(0, len(way), _STEPS_A_RECORD)]
    try:
        with McapLog(path, level, 0.0) as log:
            done = 0
            for number, positions in enumerate(parts):
                begin, done = done, done + len(positions)
                log.on_round(_record(number, positions, begin * step_s, done))
            log.finish((_finding(repeated, len(way) * step_s),))
    except OSError as error:
        raise _unwritable(path, error) from error


def way_of(repeated: Repeated) -> Floats:
    """Where the character was [N + 1, 3]: at the start and after every agent step."""
    assert repeated.start is not None
    assert repeated.positions is not None
    return np.concatenate([repeated.start[None], repeated.positions])


def first_way(results: Sequence[Repeated]) -> Repeated:
    """The first finding with a path. Raises BadInput where there is none."""
    for result in results:
        if result.positions is not None:
            return result
    found = "none of these findings has a path to write"
    raise BadInput([Problem("command line", found, "choose a finding that somebody walked to")])


def with_place(path: Path, write: Callable[[Path], object]) -> None:
    """Call `write` with a temporary name beside `path` and give it the right one. Raises BadInput."""
    try:
        write_whole(path, write)
    except OSError as error:
        raise _unwritable(path, error) from error


def check_places(paths: Sequence[Path]) -> None:
    """Raises BadInput where files cannot be written, before anything is simulated for them."""
    problems: list[Problem] = []
    for path in paths:
        try:
            if path.is_dir():
                raise IsADirectoryError(EISDIR, strerror(EISDIR))
            folder = next(folder for folder in path.absolute().parents if folder.exists())
            with TemporaryFile(dir=folder):
                pass
        except OSError as error:
            problems += _unwritable(path, error).problems
    if problems:
        raise BadInput(problems)


def _unwritable(path: Path, error: OSError) -> BadInput:
    found = f"'{path}' cannot be written: {error.strerror or error}"
    return BadInput([Problem("command line", found, "name a file in a folder that can be written")])


def _record(number: int, positions: Floats, time_s: float, steps: int) -> RoundRecord:
    return RoundRecord(
        round=number,
        agent_steps=steps,
        sim_time_s=time_s,
        trajectories=positions[:, None],
        new_points=np.empty((0, 3)),
        new_expected=np.empty(0, dtype=np.bool_),
        points=0,
        goals_reached=0,
        goals_total=0,
        falls=0,
    )


def _finding(repeated: Repeated, duration_s: float) -> Finding:
    kept = repeated.finding
    assert repeated.start is not None
    assert repeated.positions is not None
    return Finding(
        id=kept.id,
        kind=kept.kind,
        severity=kept.severity,
        gating=kept.gating,
        title=kept.title,
        position=np.array(kept.position),
        low=np.array(kept.low),
        high=np.array(kept.high),
        points=kept.points,
        exit_point=None if kept.exit_point is None else np.array(kept.exit_point),
        nearest_named=kept.nearest_named,
        first_seen_step=None,
        path=ReplayPath(repeated.start, (), repeated.positions, duration_s, 1, int(bool(repeated.passed))),
        suppressed_by=None,
    )
