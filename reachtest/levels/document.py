"""Reads `level.yaml` into its models, and turns every complaint into a `Problem` a designer can act on."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, get_args

import yaml
from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from reachtest.errors import BadInput, Problem
from reachtest.levels.fields import nearest
from reachtest.levels.schema import LevelSpec


class _Loader(yaml.SafeLoader):
    """Refuses a key that stands twice in one mapping: YAML's last-one-wins hides mistakes."""

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        seen = set()
        for key, _ in node.value:
            if key.value in seen and isinstance(key, yaml.ScalarNode):
                message = f"the key {key.value!r} stands twice in one mapping"
                raise yaml.constructor.ConstructorError(None, None, message, key.start_mark)
            seen.add(key.value if isinstance(key, yaml.ScalarNode) else None)
        return super().construct_mapping(node, deep)


def read_yaml(path: Path) -> tuple[dict[str, Any], bytes]:
    """The mapping in a YAML file, and the file's bytes. Raises BadInput naming line and column."""
    try:
        data = path.read_bytes()
    except OSError as error:
        siblings = [other.name for other in path.parent.glob("*.y*ml")] if path.parent.is_dir() else []
        remedy = f"{nearest(path.name, siblings)}give the path of a level.yaml that can be read"
        raise BadInput([Problem(str(path), f"{error.strerror or error}", remedy)], path) from error
    try:
        document = yaml.load(data.decode("utf-8-sig"), Loader=_Loader)
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        mark = getattr(error, "problem_mark", None)
        place = f"line {mark.line + 1}, column {mark.column + 1}: " if mark else ""
        found = f"{place}{getattr(error, 'problem', None) or error}"
        raise BadInput([Problem(path.name, found, "correct the YAML syntax there")], path) from error
    if not isinstance(document, dict):
        found = f"holds {_show(document)}, not a mapping"
        raise BadInput([Problem(path.name, found, "start with 'version: 1'")], path)
    return document, data


def merge(document: Mapping[str, Any], overrides: Mapping[str, Any]) -> dict[str, Any]:
    """`document` with the values of `overrides` put over it, section by section."""
    merged = dict(document)
    for key, value in overrides.items():
        below = merged.get(key)
        merged[key] = (
            merge(below or {}, value) if isinstance(value, Mapping) and _is_section(below) else value
        )
    explore, over = merged.get("explore"), overrides.get("explore") or {}
    if isinstance(explore, dict) and over.keys() & {"time_budget", "time_budget_s"}:
        # One budget under two names: the one from the command line wins.
        for name in {"time_budget", "time_budget_s"} - over.keys():
            explore.pop(name, None)
    return merged


def _is_section(value: Any) -> bool:
    return value is None or isinstance(value, Mapping)


def parse(
    document: Mapping[str, Any], file: str, overrides: Mapping[str, Any]
) -> tuple[LevelSpec | None, list[Problem]]:
    """The models of a document, or all its problems; those of overridden values are the command line's."""
    try:
        return LevelSpec.model_validate(document), []
    except ValidationError as error:
        given = tuple(_leaves(overrides))
        return None, [_problem(details, file, given) for details in error.errors(include_url=False)]


def _leaves(tree: Mapping[str, Any], prefix: str = "") -> Iterator[str]:
    for key, value in tree.items():
        if isinstance(value, Mapping):
            yield from _leaves(value, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}"


def _problem(details: ErrorDetails, file: str, overridden: Sequence[str]) -> Problem:
    loc = tuple(part for part in details["loc"] if part != "[key]")
    key = dotted(loc)
    source = "command line" if any(key.startswith(name) for name in overridden) else file
    where = f"{source}: {key}" if key else source
    if details["type"] == "extra_forbidden":
        keys = _keys(_model_at(loc[:-1]))
        where = f"{source}: {dotted(loc[:-1])}".removesuffix(": ")
        return Problem(
            where, f"unknown key {loc[-1]!r}", f"{nearest(str(loc[-1]), keys)}valid: {', '.join(keys)}"
        )
    if details["type"] == "missing":
        return Problem(where, "is missing", _meaning(loc) or "add it")
    return Problem(where, f"found {_show(details['input'])}", _remedy(details, loc))


def _remedy(details: ErrorDetails, loc: Sequence[int | str]) -> str:
    message = details["msg"].removeprefix("Value error, ").removeprefix("Input ").replace("should", "must", 1)
    meaning = _meaning(loc)
    return f"{message} ({meaning})" if meaning and details["type"] != "value_error" else message


def dotted(loc: Sequence[int | str]) -> str:
    """`("geometry", 0, "mesh")` as `geometry[0].mesh`."""
    text = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in loc)
    return text.removeprefix(".")


def _show(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 80 else f"{text[:77]}..."


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
