"""`state/findings.npz`: all that is needed to repeat a run's findings without the run.

One file, written whole or not at all: the actions, states and places of each finding's path as arrays, and a
description in JSON as the array `meta`. It says what it was made from, so that replaying can say what changed since.
"""

from __future__ import annotations

import hashlib
import io
import json
import os
import struct
import zipfile
import zlib
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import AfterValidator, BaseModel, ConfigDict, Field, ValidationError

from reachtest import __version__
from reachtest.confirm.outcome import Judge, Outcome
from reachtest.errors import BadInput, Problem
from reachtest.files import write_whole
from reachtest.levels import named_files
from reachtest.records import KINDS, Finding, Floats, Level
from reachtest.replaying.sections import digests_of, printable, values_of
from reachtest.world import SIMULATORS

STATE_FILE = Path("state") / "findings.npz"
MAX_BYTES = 1 << 30  # unpacked: a file that claims more was not written by a run
MAX_ACTION = np.array([8, 1], dtype=np.int8)
_REMEDY = "give the output folder of a finished 'reachtest run', or run it again"
_ARRAYS = ("state", "actions", "positions")
POCKETS = frozenset({"stuck", "no_return"})  # kinds that are told by `Recording.standing`
# What zipfile, zlib and numpy raise for files that are cut off, damaged or something else.
_UNREADABLE = (
    OSError,
    zipfile.BadZipFile,
    zlib.error,
    struct.error,
    EOFError,
    KeyError,
    ValueError,
    RuntimeError,
    OverflowError,
    MemoryError,
)

Point = tuple[float, float, float]


def _one_of(names: Collection[str]) -> AfterValidator:
    def check(name: str) -> str:
        if name not in names:
            raise ValueError(f"this version knows {', '.join(names)}")
        return name

    return AfterValidator(check)


class _Part(BaseModel):
    # Later versions may add keys.
    model_config = ConfigDict(extra="ignore", frozen=True, allow_inf_nan=False)


class KeptLevel(_Part):
    """Which level it was."""

    name: str
    file: str  # as it was given to the run
    beside: str  # from the output folder
    sha256: str
    files: dict[str, str]  # sha256 of each file that it names
    # What was in them, for `sections.differences`; older versions kept none.
    values: dict[str, str] | None = None
    sections: dict[str, str] | None = None


class KeptFinding(_Part):
    """One finding, without its arrays."""

    id: str
    kind: Annotated[str, _one_of(KINDS)]
    severity: str
    gating: bool
    fragile: bool
    title: str
    target: str | None
    position: Point
    low: Point
    high: Point
    exit_point: Point | None
    nearest_named: str | None
    points: int
    arrays: int | None = Field(ge=0)  # their number; None: it has no path


class Kept(_Part):
    """The description."""

    format: Literal[1]
    tool_version: str
    simulator: Annotated[str, _one_of(SIMULATORS)]
    mujoco: str
    physics_hz: float = Field(ge=10, le=10_000)  # as a level file may have it
    action_repeat: int = Field(ge=1, le=1000)
    level: KeptLevel
    findings: tuple[KeptFinding, ...]


@dataclass(frozen=True)
class Recording:
    """The path of a finding as it was recorded."""

    state: Floats  # [S] where it starts
    actions: NDArray[np.int8]  # [N, 2]
    positions: Floats  # [N, 3]
    standing: Floats | None  # [k, 3] of a pocket: where somebody stood in it; older runs kept none


@dataclass(frozen=True)
class State:
    """What a run left for replaying."""

    kept: Kept
    recordings: dict[str, Recording]  # by the finding's id


def outcome_of(finding: KeptFinding, recording: Recording) -> Outcome:
    """What would show the finding again."""
    exit_point = None if finding.exit_point is None else np.array(finding.exit_point)
    low, high = np.array(finding.low), np.array(finding.high)
    place, standing = np.array(finding.position), recording.standing
    return Outcome(finding.kind, finding.target, place, low, high, exit_point, standing)


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


def read_state(folder: Path) -> State:
    """What a run left in its output folder. Raises BadInput where that is missing, cut off or something else."""
    path = folder / STATE_FILE
    if not path.is_file():
        what = "does not exist" if not folder.is_dir() else f"has no {STATE_FILE.as_posix()}"
        raise _bad(str(folder), what)
    try:
        arrays = _unpack(path)
        kept = Kept.model_validate_json(arrays["meta"].tobytes())
    except ValidationError as error:
        raise _bad(str(path), f"is not of this version's format ({_first(error)})") from error
    except _UNREADABLE as error:
        raise _bad(str(path), f"cannot be read, it is cut off or no replay state ({error})") from error
    recordings = {}
    for finding in kept.findings:
        if finding.arrays is not None:
            recordings[finding.id] = _recording(path, arrays, finding)
    _same_run(folder, kept)
    return State(kept, recordings)


def digests(files: dict[str, Path]) -> dict[str, str]:
    """The sha256 of each file, by its name; "missing" where it cannot be read."""
    result = {}
    for name, path in files.items():
        try:
            result[name] = hashlib.sha256(path.read_bytes()).hexdigest()
        except OSError:
            result[name] = "missing"
    return result


def _unpack(path: Path) -> dict[str, NDArray[np.generic]]:
    with zipfile.ZipFile(path) as archive:
        size = sum(item.file_size for item in archive.infolist())
    if size > MAX_BYTES:
        raise ValueError(f"it claims to unpack to {size:,} bytes")
    with np.load(path, allow_pickle=False) as stored:
        return {name: stored[name] for name in stored.files}


def _first(error: ValidationError) -> str:
    """Key, value and limit of the first mistake."""
    first = error.errors()[0]
    value = "" if first["type"] == "missing" else f" is {str(first['input'])[:40]!r}"
    return f"{'.'.join(map(str, first['loc']))}{value}: {first['msg'].removeprefix('Value error, ')}"


def _recording(path: Path, arrays: dict[str, NDArray[np.generic]], finding: KeptFinding) -> Recording:
    state, actions, positions = (arrays.get(f"{name}{finding.arrays}") for name in _ARRAYS)
    if state is None or actions is None or positions is None:
        raise _bad(str(path), f"the path of {finding.id} is missing")
    n = len(actions) if actions.ndim else 0
    shapes = state.ndim == 1 and len(state) >= 3 and actions.shape == (n, 2) and positions.shape == (n, 3)
    types = state.dtype == np.float64 and actions.dtype == np.int8 and positions.dtype == np.float64
    if not (n and shapes and types and np.isfinite(state).all()):
        raise _bad(str(path), f"the path of {finding.id} is no path")
    standing = arrays.get(f"standing{finding.arrays}") if finding.kind in POCKETS else None
    if standing is not None and not _places(standing):
        raise _bad(str(path), f"the places of {finding.id} are no places")
    recording = Recording(
        state.astype(np.float64),
        actions.astype(np.int8),
        positions.astype(np.float64),
        None if standing is None else standing.astype(np.float64),
    )
    if (recording.actions < 0).any() or (recording.actions > MAX_ACTION).any():
        raise _bad(str(path), f"the path of {finding.id} has actions that do not exist")
    return recording


def _places(array: NDArray[np.generic]) -> bool:
    shape = array.ndim == 2 and len(array) > 0 and array.shape[1] == 3
    return shape and array.dtype == np.float64 and bool(np.isfinite(array.astype(np.float64)).all())


def _same_run(folder: Path, kept: Kept) -> None:
    """Refuse a folder that two builds of a level were mixed in."""
    try:
        level = json.loads((folder / "report.json").read_text(encoding="utf-8"))["level"]
        name, sha256 = level["name"], level["sha256"]
    except (OSError, ValueError, KeyError, TypeError):
        return  # the report is not needed to replay
    if sha256 != kept.level.sha256:
        found = (
            f"belongs to another build of the level than report.json beside it: '{kept.level.name}'"
            f" {kept.level.sha256[:12]}, the report is about '{name}' {str(sha256)[:12]}"
        )
        raise _bad(str(folder / STATE_FILE), found)


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
        arrays=arrays,
    )


def _point(place: Floats) -> Point:
    x, y, z = place.tolist()
    return (x, y, z)


def _bad(where: str, found: str) -> BadInput:
    return BadInput([Problem(where, found, _REMEDY)])
