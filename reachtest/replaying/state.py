"""Reads `state/findings.npz` back, and refuses what no run wrote."""

from __future__ import annotations

import json
import struct
import zipfile
import zlib
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from reachtest.errors import BadInput, Problem
from reachtest.replaying.kept import POCKETS, STATE_FILE, Kept, KeptFinding, Recording, State

MAX_BYTES = 1 << 30  # unpacked: a file that claims more was not written by a run
MAX_ACTION = np.array([8, 1], dtype=np.int8)
_REMEDY = "give the output folder of a finished 'reachtest run', or run it again"
_ARRAYS = ("state", "actions", "positions")
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


def _bad(where: str, found: str) -> BadInput:
    return BadInput([Problem(where, found, _REMEDY)])
