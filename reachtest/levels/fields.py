"""Types of single values in `level.yaml`, each with its limits and its place in the JSON schema."""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable, Sequence
from typing import Annotated, Any, ClassVar

from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    GetCoreSchemaHandler,
    GetJsonSchemaHandler,
    PlainValidator,
    WithJsonSchema,
)
from pydantic_core import CoreSchema, core_schema

from reachtest.levels.frames import UNITS

FARTHEST = 1e7  # 100 km in centimetres: beyond it a number is a mistake, not a place


class Spec(BaseModel):
    """Base of everything in `level.yaml`: unknown keys are refused, and so are NaN and infinity."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    short: ClassVar[str] = ""  # what may be written in place of its keys


def nearest(word: str, words: Iterable[str]) -> str:
    """A sentence that proposes the nearest of `words`, with its space; empty if none is near."""
    by_fold = {other.lower(): other for other in words}
    close = difflib.get_close_matches(word.lower(), list(by_fold), n=1, cutoff=0.5)
    return f"did you mean {by_fold[close[0]]!r}? " if close else ""


def dotted(loc: Sequence[int | str]) -> str:
    """`("geometry", 0, "mesh")` as `geometry[0].mesh`."""
    text = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in loc)
    return text.removeprefix(".")


def show(value: Any) -> str:
    """A value as it stands in a message: on one line, and not too long."""
    text = repr(value)
    return text if len(text) <= 80 else f"{text[:77]}..."


class OneOf:
    """Annotation of a string that must be one of `values`; its message says what is near and valid."""

    def __init__(self, values: Iterable[str]) -> None:
        self.values = list(values)

    def _check(self, value: str) -> str:
        if value not in self.values:
            raise ValueError(f"{nearest(value, self.values)}valid: {', '.join(self.values)}")
        return value

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_after_validator_function(self._check, handler(source))

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        return {"type": "string", "enum": self.values}


def _units(value: Any) -> str | float:
    if isinstance(value, str) and value in UNITS:
        return value
    if isinstance(value, (int, float)) and not isinstance(value, bool) and 1e-6 <= value <= 1e4:
        return float(value)
    raise ValueError(f"must be one of {', '.join(UNITS)} or the length of a unit in metres (1e-6 to 10000)")


_DURATION = re.compile(r"\s*(\d+(?:\.\d*)?)\s*([smh]?)\s*")
_SECONDS = {"": 1.0, "s": 1.0, "m": 60.0, "h": 3600.0}


def _duration(value: Any) -> float | None:
    """Seconds of 90, "90s", "30m" or "2h"."""
    if value is None:
        return None
    match = None if isinstance(value, bool) else _DURATION.fullmatch(str(value))
    seconds = float(match[1]) * _SECONDS[match[2]] if match else 0.0
    if not 0 < seconds <= 30 * 86_400:
        raise ValueError("must be a time above 0 and up to 30 days, such as 90, 90s, 30m or 2h")
    return seconds


Number = Annotated[float, Field(ge=-FARTHEST, le=FARTHEST)]
Length = Annotated[float, Field(gt=0, le=FARTHEST)]
Point = tuple[Number, Number, Number]
Size = tuple[Length, Length, Length]
Name = Annotated[str, Field(min_length=1, max_length=200)]
Units = Annotated[
    str | float,
    PlainValidator(_units),
    WithJsonSchema({"anyOf": [{"enum": list(UNITS)}, {"type": "number", "minimum": 1e-6, "maximum": 1e4}]}),
]
Duration = Annotated[
    float | None,
    PlainValidator(_duration),
    WithJsonSchema(
        {
            "anyOf": [
                {"type": "number", "exclusiveMinimum": 0},
                {"type": "string", "pattern": r"^\d+(\.\d*)?[smh]?$"},
            ]
        }
    ),
]


def optional_number(text: str, *, above: float | None = None, least: float | None = None, most: float) -> Any:
    """A number that may be left out, with its meaning and limits."""
    return Field(None, gt=above, ge=least, le=most, description=text)


def either(shorthand: dict[str, Any], schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
    """The JSON schema of what may also be written as `shorthand`."""
    return {"anyOf": [shorthand, handler(schema)]}
