"""Reads `level.yaml` into its models, with the command line's values over it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import yaml
from pydantic import ValidationError

from reachtest.errors import BadInput, Problem
from reachtest.levels.keys.complaints import complaints
from reachtest.levels.keys.fields import nearest, show
from reachtest.levels.keys.level import LevelSpec


class _Loader(yaml.SafeLoader):
    """Refuses a key that stands twice in one mapping: YAML's last-one-wins hides mistakes."""

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        seen = set()
        for key, _ in node.value:
            if not isinstance(key, yaml.ScalarNode):
                continue
            if key.value in seen:
                message = f"the key {key.value!r} stands twice in one mapping"
                raise yaml.constructor.ConstructorError(None, None, message, key.start_mark)
            seen.add(key.value)
        return super().construct_mapping(node, deep)


def read_yaml(path: Path) -> dict[str, Any]:
    """The mapping in a YAML file. Raises BadInput naming line and column."""
    try:
        data = path.read_bytes()
    except OSError as error:
        siblings = [other.name for other in path.parent.glob("*.y*ml")] if path.parent.is_dir() else []
        remedy = f"{nearest(path.name, siblings)}give the path of a level.yaml that can be read"
        raise BadInput([Problem(str(path), f"{error.strerror or error}", remedy)], path) from error
    try:
        document = yaml.load(data.decode("utf-8-sig"), Loader=_Loader)
    except (yaml.YAMLError, ValueError) as error:  # ValueError: no UTF-8, or 2030-02-31 for a date
        mark = getattr(error, "problem_mark", None)
        place = f"line {mark.line + 1}, column {mark.column + 1}: " if mark else ""
        found = f"{place}{getattr(error, 'problem', None) or error}"
        raise BadInput([Problem(path.name, found, "correct the YAML syntax there")], path) from error
    except RecursionError as error:
        remedy = "take out brackets or indentation: no key of a level goes as deep"
        raise BadInput([Problem(path.name, "is nested too deep to read", remedy)], path) from error
    if not isinstance(document, dict):
        found = f"holds {show(document)}, not a mapping"
        raise BadInput([Problem(path.name, found, "start with 'version: 1'")], path)
    return document


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
        return None, complaints(error, file, given)


def _leaves(tree: Mapping[str, Any], prefix: str = "") -> Iterator[str]:
    for key, value in tree.items():
        if isinstance(value, Mapping):
            yield from _leaves(value, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}"
