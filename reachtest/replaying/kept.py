"""What a run keeps for replaying, as `state/findings.npz` holds it."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import AfterValidator, BaseModel, ConfigDict, Field

from reachtest.confirm.outcome import Outcome
from reachtest.records import KINDS, Floats
from reachtest.world import SIMULATORS

STATE_FILE = Path("state") / "findings.npz"
POCKETS = frozenset({"stuck", "no_return"})  # kinds that are told by `Recording.standing`

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
    reach_m: float | None = Field(None, ge=0)
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
    return Outcome(finding.kind, finding.target, place, low, high, exit_point, standing, finding.reach_m)
