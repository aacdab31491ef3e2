"""What an earlier run left in its output folder, read back and checked: only what later commands ask for."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, TypeVar

import numpy as np
from pydantic import AfterValidator, BaseModel, ConfigDict, Field, ValidationError
from pydantic_core import ErrorDetails

from reachtest.baseline.gone import Look
from reachtest.baseline.place import Place, is_remark
from reachtest.errors import BadInput, Problem
from reachtest.records import KINDS, SATURATED_RISK

Number = Annotated[float, Field(ge=-1e12, le=1e12)]  # beyond any level, in any units
Point = tuple[Number, Number, Number]
Step = Annotated[int, Field(ge=-1, le=2**62)]
_REMEDY = "give the output folder of a finished 'reachtest run', or its report.json"


class _Part(BaseModel):
    model_config = ConfigDict(extra="ignore", frozen=True, allow_inf_nan=False)  # later versions may add keys


def _known_kind(kind: str) -> str:
    if kind not in KINDS:
        raise ValueError(f"known kinds are {', '.join(KINDS)}")
    return kind


class FoundBefore(_Part):
    """A finding of report.json."""

    id: str = Field(min_length=1, max_length=1000)
    kind: Annotated[str, AfterValidator(_known_kind)]
    severity: str
    gating: bool
    title: str
    position: Point
    source_position: Point
    bounds: tuple[Point, Point]
    exit_point: Point | None
    exits: tuple[Point, ...] | None = None
    nearest_named: str | None
    suppressed_by: str | None

    @property
    def known_exits(self) -> tuple[Point, ...]:
        """Where paths left the nav-mesh on the way to it."""
        return self.exits or (() if self.exit_point is None else (self.exit_point,))

    @property
    def place(self) -> Place:
        """Where it is."""
        low, high = np.array(self.bounds, dtype=np.float64)
        exits = np.array(self.known_exits, dtype=np.float64).reshape(-1, 3)
        return Place(self.id, self.kind, low, high, exits, is_remark(self))


class _Level(_Part):
    name: str
    sha256: str


class _Goals(_Part):
    goals_total: int
    goals_reached: int
    sufficient: bool | None = None


class _Explore(_Part):
    goal_spacing_m: float


def _invertible(matrix: tuple[Point, Point, Point]) -> tuple[Point, Point, Point]:
    if np.linalg.matrix_rank(np.array(matrix)) < 3:
        raise ValueError("three axes that are independent are needed, as the run wrote them")
    return matrix


class _Frame(_Part):
    matrix: Annotated[tuple[Point, Point, Point], AfterValidator(_invertible)]


class _Config(_Part):
    explore: _Explore
    frame: _Frame


class _Run(_Part):
    agent_steps: int


class _Recent(_Part):
    share: float


class _Risk(_Part):
    discovery_probability: float | None
    recent: _Recent | None = None

    @property
    def highest(self) -> float | None:
        """The bound, or what the latest episodes did find where that is more; None without an episode."""
        if self.discovery_probability is None or self.recent is None:
            return self.discovery_probability
        return max(self.discovery_probability, self.recent.share)


class ReportBefore(_Part):
    """report.json."""

    verdict: str
    verdict_reason: str = ""
    level: _Level
    config: _Config
    seed: int
    run: _Run
    coverage: _Goals
    risk: _Risk
    findings: tuple[FoundBefore, ...]

    @property
    def explored_enough(self) -> bool:
        """Whether the run could have passed but for its findings."""
        return self.verdict == "pass" if self.coverage.sufficient is None else self.coverage.sufficient

    @property
    def saturated(self) -> bool:
        """Whether a longer run would hardly have reached more."""
        risk = self.risk.highest
        return risk is not None and risk <= SATURATED_RISK

    def look(self, found: tuple[Place, ...], new: tuple[Place, ...]) -> Look:
        """What the run can tell of bugs that are not among its findings: places of all, and of those unknown so far."""
        return Look(self.level.sha256, self.explored_enough, self.risk.highest, found, new)


class CoverageBefore(_Part):
    """coverage.json: goals (x, y, z, agent step at which it was reached or -1), and one standing place a cell
    (x, y, z, 1 if expected)."""

    cell_m: float = Field(ge=0.01, le=1e6)
    goals: tuple[tuple[Number, Number, Number, Step], ...]
    stood: tuple[tuple[Number, Number, Number, Step], ...]


@dataclass(frozen=True)
class Result:
    """An output folder."""

    name: str  # as it was given
    report: ReportBefore
    coverage: CoverageBefore | None  # None: the folder has none, or a report.json alone was given


Model = TypeVar("Model", bound=_Part)


def read_result(path: Path) -> Result:
    """The run in an output folder or report.json. Raises BadInput: absent, corrupt or of another version."""
    file = path / "report.json" if path.is_dir() else path
    beside = file.with_name("coverage.json")
    report = _read(file, ReportBefore)
    return Result(str(path), report, _read(beside, CoverageBefore) if beside.is_file() else None)


def _read(file: Path, model: type[Model]) -> Model:
    try:
        content: Any = json.loads(file.read_text(encoding="utf-8"))
    except OSError as error:
        raise BadInput([Problem(str(file), error.strerror or str(error), _REMEDY)]) from error
    except ValueError as error:  # neither JSON nor UTF-8
        raise BadInput([Problem(str(file), f"is cut off or damaged: {error}", _REMEDY)]) from error
    except RecursionError as error:
        raise BadInput([Problem(str(file), "is damaged: nested too deep to read", _REMEDY)]) from error
    version = content.get("schema_version") if isinstance(content, dict) else None
    if type(version) is not int or version != 1:  # true and 1.0 are equal to 1
        raise BadInput(
            [Problem(str(file), f"has schema_version {version!r}", f"this program reads 1; {_REMEDY}")]
        )
    try:
        return model.model_validate(content)
    except ValidationError as error:
        raise BadInput([_problem(details, file) for details in error.errors(include_url=False)]) from error


def _problem(details: ErrorDetails, file: Path) -> Problem:
    where = f"{file}: {'.'.join(map(str, details['loc']))}"
    right = details["msg"].removeprefix("Value error, ")
    missing = details["type"] == "missing"
    return Problem(where, right if missing else f"found {details['input']!r:.80}: {right}", _REMEDY)
