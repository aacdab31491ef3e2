"""The file of known bugs, `version: 1`: YAML, so that people can read and edit it; unknown keys are refused."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import date
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
import yaml
from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationError

from reachtest.baseline.place import Place
from reachtest.errors import BadInput, Problem
from reachtest.records import KINDS, Level

_REMEDY = "correct it, or write the file again with 'reachtest baseline update'"


def _no_number(value: Any) -> Any:
    """A year alone is no date, though pydantic takes numbers for seconds since 1970."""
    if isinstance(value, int | float):
        raise ValueError("write the date as 2030-12-31")
    return value


Day = Annotated[date, BeforeValidator(_no_number)]
Point = tuple[float, float, float]
Text = Annotated[str, Field(min_length=1, max_length=1000, pattern=r"\S")]


class _Spec(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class _Dumper(yaml.SafeDumper):
    """Writes a date twice rather than an alias to it."""

    def ignore_aliases(self, data: Any) -> bool:
        return True


class Entry(_Spec):
    """One known bug. Places are level coordinates [m], z up, but for `source_position`."""

    id: Text
    kind: Annotated[str, Field(json_schema_extra={"enum": list(KINDS)})]
    title: str = ""
    source_position: Point | None = Field(
        None, description="In the level file's own axes and units, for people."
    )
    position: Point
    bounds: tuple[Point, Point]
    exits: tuple[Point, ...] = ()
    reason: Text
    author: Text
    added: Day
    level_sha256: str | None = Field(None, description="Of the level that it was seen in, as in report.json.")
    expires: Day | None = Field(None, description="The last day on which it does not gate; null: for good.")

    def in_force(self, today: date) -> bool:
        """Whether it still keeps its bug from gating."""
        return self.expires is None or today <= self.expires

    @property
    def place(self) -> Place:
        """Where it is."""
        low, high = np.array(self.bounds, dtype=np.float64)
        return Place(self.id, self.kind, low, high, np.array(self.exits, dtype=np.float64).reshape(-1, 3))


class Document(_Spec):
    """The whole file."""

    version: Literal[1]
    level: Text
    entries: tuple[Entry, ...] = ()


@dataclass(frozen=True)
class Baseline:
    """A file of known bugs as it was read."""

    file: str  # as it was named, for reports
    entries: tuple[Entry, ...]


def baseline_of(level: Level) -> Baseline | None:
    """The known bugs that a level names with `gate.baseline`. Raises BadInput."""
    named = level.gate.baseline
    if named is None:
        return None
    return read_baseline(level.file.parent / named, level.name, named, f"{level.file.name}: gate.baseline")


def read_baseline(path: Path, level: str, named: str | None = None, key: str = "") -> Baseline:
    """The known bugs of the level of this name. Raises BadInput: absent, corrupt, of another level or version.

    `named` is what reports call the file, and `key` what names it, for where it cannot be read.
    """
    file = named or str(path)
    try:
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, ValueError) as error:  # ValueError: no UTF-8, or a name that no file can have
        found = getattr(error, "strerror", None) or f"is no text: {error}"
        remedy = "name a file that 'reachtest baseline update' wrote"
        told = Problem(key, f"{file!r}: {found}", remedy) if key else Problem(file, found, remedy)
        raise BadInput([told], path) from error
    document = parse(text, file)
    if document.level != level:
        found = f"holds the known bugs of level {document.level!r}, not of {level!r}"
        raise BadInput([Problem(f"{file}: level", found, "name the file of this level")], path)
    return Baseline(file, document.entries)


def parse(text: str, file: str) -> Document:
    """The document in a YAML text. Raises BadInput with every mistake."""
    try:
        content = yaml.safe_load(text)
    except (yaml.YAMLError, ValueError) as error:  # ValueError: 2030-02-31 looks like a date and is none
        mark = getattr(error, "problem_mark", None)
        place = f"line {mark.line + 1}, column {mark.column + 1}: " if mark else ""
        raise BadInput(
            [Problem(file, f"{place}{getattr(error, 'problem', None) or error}", _REMEDY)]
        ) from error
    except RecursionError as error:
        raise BadInput([Problem(file, "is nested too deep to read", _REMEDY)]) from error
    if not isinstance(content, dict):
        raise BadInput([Problem(file, "holds no mapping", _REMEDY)])
    version = content.get("version")
    if type(version) is not int or version != 1:  # true and 1.0 are equal to 1
        found = "is missing" if version is None else f"found {version!r}"
        raise BadInput([Problem(f"{file}: version", found, "this program reads version 1")])
    try:
        document = Document.model_validate(content)
    except ValidationError as error:
        raise BadInput([_problem(details, file) for details in error.errors(include_url=False)]) from error
    unknown = [entry for entry in document.entries if entry.kind not in KINDS]
    if unknown:
        valid = f"known kinds are {', '.join(KINDS)}"
        raise BadInput([Problem(f"{file}: {entry.id}", f"kind {entry.kind!r}", valid) for entry in unknown])
    return document


def _problem(details: Any, file: str) -> Problem:
    key = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in details["loc"])
    where = f"{file}: {key.removeprefix('.')}"
    if details["type"] == "extra_forbidden":
        return Problem(where, "unknown key", f"valid: {', '.join(Entry.model_fields)}")
    if details["type"] == "missing":
        return Problem(where, "is missing", "add it")
    return Problem(
        where, f"found {details['input']!r:.80}", str(details["msg"]).removeprefix("Value error, ")
    )


def dump(level: str, entries: Sequence[Entry]) -> str:
    """The whole file as YAML."""
    head = (
        "# Known bugs: shown as known, and do not fail the build until the day after 'expires'.\nversion: 1\n"
    )
    return (
        head
        + _yaml({"level": level}, flow=False)
        + "entries:"
        + ("\n" + items(entries) if entries else " []\n")
    )


def items(entries: Sequence[Entry]) -> str:
    """Entries as items of a YAML list."""
    return _yaml([entry.model_dump(mode="python") for entry in entries]) if entries else ""


def _yaml(value: Any, flow: bool | None = None) -> str:
    return yaml.dump(
        _lists(value),
        Dumper=_Dumper,
        sort_keys=False,
        allow_unicode=True,
        default_flow_style=flow,
        width=110,
    )


def _lists(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _lists(item) for key, item in value.items()}
    return [_lists(item) for item in value] if isinstance(value, list | tuple) else value
