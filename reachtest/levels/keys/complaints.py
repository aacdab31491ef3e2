"""Turns pydantic's errors into problems that a designer can act on: where, what was found, what is valid."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, get_args

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from reachtest.errors import Problem
from reachtest.levels.fields import dotted, nearest, show
from reachtest.levels.keys.level import LevelSpec


def complaints(error: ValidationError, file: str, sources: Mapping[tuple[str, ...], str]) -> list[Problem]:
    """One problem for every mistake; `sources` tells of keys that others than `file` say."""
    errors = error.errors(include_url=False)
    return [_problem(details, file, sources) for details in errors if not _follows(details, errors)]


def _follows(details: ErrorDetails, errors: Sequence[ErrorDetails]) -> bool:
    """Whether an error only follows from another: a list cut short by a bad item, a key missed by a typo."""
    loc = details["loc"]
    if details["type"] == "too_short":
        return any(other["loc"][: len(loc)] == loc != other["loc"] for other in errors)
    if details["type"] != "missing":
        return False
    beside = [other for other in errors if other["loc"][:-1] == loc[:-1]]
    unknown = [str(other["loc"][-1]) for other in beside if other["type"] == "extra_forbidden"]
    keys = _keys(_model_at(loc[:-1]))
    return any(repr(loc[-1]) in nearest(word, keys) for word in unknown)


def _problem(details: ErrorDetails, file: str, sources: Mapping[tuple[str, ...], str]) -> Problem:
    loc = tuple(part for part in details["loc"] if part != "[key]")
    key = dotted(loc)
    path = tuple(part for part in loc if isinstance(part, str))
    source = _source(path, file, sources, bool(path) and details["type"] == "value_error")
    where = f"{source}: {key}" if key else source
    if details["type"] == "extra_forbidden":
        keys = _keys(_model_at(loc[:-1]))
        where = f"{source}: {dotted(loc[:-1])}".removesuffix(": ")
        return Problem(
            where, f"unknown key {loc[-1]!r}", f"{nearest(str(loc[-1]), keys)}valid: {', '.join(keys)}"
        )
    if details["type"] == "missing":
        return Problem(where, "is missing", f"add it: {_meaning(loc)}".removesuffix(": "))
    return Problem(where, _found(details["input"]), _remedy(details, loc))


def _source(path: tuple[str, ...], file: str, sources: Mapping[tuple[str, ...], str], together: bool) -> str:
    """Who says what stands at `path`; all who say something of it, where that is wrong `together`."""
    for length in range(len(path), 0, -1):
        if path[:length] in sources:
            return sources[path[:length]]
    others = {source: None for key, source in sources.items() if together and key[: len(path)] == path}
    return " and ".join([file, *others])


def _found(value: Any) -> str:
    """What stands in the file; a default that does not fit stands there as nothing."""
    if isinstance(value, BaseModel):
        value = value.model_dump(exclude_unset=True, by_alias=True)
        return f"found {show(value)}" if value else "is not given"
    return f"found {show(value)}"


def _remedy(details: ErrorDetails, loc: Sequence[int | str]) -> str:
    message = details["msg"].removeprefix("Value error, ").removeprefix("Input ").removeprefix("Tuple ")
    message = message.replace("should", "must", 1).removesuffix(" after validation, not 0")
    if details["type"] == "model_type":
        short = getattr(_model_at(loc), "short", "")
        message = "must have keys of its own" + (f", or be {short}" if short else "")
    meaning = _meaning(loc)
    return f"{message} ({meaning})" if meaning and details["type"] != "value_error" else message


def _keys(model: type[BaseModel]) -> list[str]:
    return [field.alias or name for name, field in model.model_fields.items()]


def _field(model: type[BaseModel], key: str) -> Any:
    return next((field for name, field in model.model_fields.items() if key in (name, field.alias)), None)


def _model_in(annotation: Any) -> type[BaseModel] | None:
    """The first model inside an annotation such as `tuple[Model, ...]` or `Model | None`."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    return next((model for inner in get_args(annotation) if (model := _model_in(inner))), None)


def _model_at(loc: Sequence[int | str]) -> type[BaseModel]:
    """The model whose keys stand at `loc`."""
    model: type[BaseModel] = LevelSpec
    for part in loc:
        if isinstance(part, str):
            field = _field(model, part)
            model = (_model_in(field.annotation) if field else None) or model
    return model


def _meaning(loc: Sequence[int | str]) -> str:
    """The description of the key at `loc`, or of the innermost key around it."""
    names = [part for part in loc if isinstance(part, str)]
    field = _field(_model_at(names[:-1]), names[-1]) if names else None
    return str(field.description).rstrip(".") if field and field.description else ""
