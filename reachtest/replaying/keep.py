"""Writes `state/findings.npz`: all that is needed to repeat a run's findings without the run.

One file, written whole or not at all: the actions, states and places of each finding's path as arrays, and a
description in JSON as the array `meta`. It says what it was made from, so that replaying can say what changed since.
"""

from __future__ import annotations

import hashlib
import io
import os
from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from reachtest import __version__
from reachtest.confirm.outcome import Judge, Outcome
from reachtest.files import write_whole
from reachtest.levels import named_files
from reachtest.records import Finding, Floats, Level
from reachtest.replaying.kept import STATE_FILE, Kept, KeptFinding, KeptLevel, Point
from reachtest.replaying.sections import digests_of, printable, values_of


def write_state(
    folder: Path, level: Level, findings: Sequence[Finding], judge: Judge, simulator: str
) -> Path:
    """Write the state of a run with `simulator` into its output folder. Raises OSError."""
    arrays: dict[str, NDArray[np.generic]] = {}
    kept: list[KeptFinding] = []
    for finding in findings:
        path, number = finding.path, None
        if path is not None and path.state is not None and path.actions is not None:
            number = sum(earlier.arrays is not None for earlier in kept)
            arrays[f"state{number}"] = path.state
            arrays[f"actions{number}"] = path.actions
            arrays[f"positions{number}"] = path.positions
            if finding.standing is not None:
                arrays[f"standing{number}"] = finding.standing
        kept.append(_kept_finding(finding, judge.outcome_of(finding), number))
    document = Kept(
        format=1,
        tool_version=__version__,
        simulator=simulator,
        mujoco=version("mujoco"),
        physics_hz=level.explore.physics_hz,
        action_repeat=level.explore.action_repeat,
        level=_kept_level(folder, level),
        findings=tuple(kept),
    )
    arrays["meta"] = np.frombuffer(document.model_dump_json().encode(), dtype=np.uint8)
    stream = io.BytesIO()
    np.savez_compressed(stream, allow_pickle=False, **arrays)
    return write_whole(folder / STATE_FILE, lambda part: part.write_bytes(stream.getvalue()))


def digests(files: dict[str, Path]) -> dict[str, str]:
    """The sha256 of each file, by its name; "missing" where it cannot be read."""
    result = {}
    for name, path in files.items():
        try:
            result[name] = hashlib.sha256(path.read_bytes()).hexdigest()
        except OSError:
            result[name] = "missing"
    return result


def _kept_level(folder: Path, level: Level) -> KeptLevel:
    try:
        beside = os.path.relpath(level.file, folder)
    except ValueError:  # on another drive
        beside = str(level.file)
    return KeptLevel(
        name=printable(level.name),
        file=level.file.as_posix(),
        beside=Path(beside).as_posix(),
        sha256=level.sha256,
        files=digests(named_files(level.file)),
        values=values_of(level),
        sections=digests_of(level),
    )


def _kept_finding(finding: Finding, outcome: Outcome, arrays: int | None) -> KeptFinding:
    return KeptFinding(
        id=printable(finding.id),
        kind=finding.kind,
        severity=finding.severity,
        gating=finding.gating,
        fragile=finding.fragile,
        title=printable(finding.title),
        target=outcome.target and printable(outcome.target),
        position=_point(finding.position),
        low=_point(finding.low),
        high=_point(finding.high),
        exit_point=None if finding.exit_point is None else _point(finding.exit_point),
        nearest_named=finding.nearest_named and printable(finding.nearest_named),
        points=finding.points,
        reach_m=finding.reach_m,
        arrays=arrays,
    )


def _point(place: Floats) -> Point:
    x, y, z = place.tolist()
    return (x, y, z)
