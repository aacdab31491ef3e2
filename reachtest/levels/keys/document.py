"""Reads YAML files, and `level.yaml` into its models."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import yaml
from pydantic import ValidationError

from reachtest.errors import BadInput, Problem
from reachtest.levels.fields import nearest, show
from reachtest.levels.keys.complaints import complaints
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


def read_yaml(path: Path, what: str = "a level", start: str = "start with 'version: 1'") -> dict[str, Any]:
    """The mapping in a YAML file, which is `what`. Raises BadInput naming line and column.

    `start` is the remedy where it holds something else.
    """
    try:
        data = path.read_bytes()
    except OSError as error:
        siblings = [other.name for other in path.parent.glob("*.y*ml")] if path.parent.is_dir() else []
        remedy = f"{nearest(path.name, siblings)}give the path of {what}'s YAML file that can be read"
        raise BadInput([Problem(str(path), f"{error.strerror or error}", remedy)], path) from error
    try:
        document = yaml.load(data.decode("utf-8-sig"), Loader=_Loader)
    except (yaml.YAMLError, ValueError) as error:  # ValueError: no UTF-8, or 2030-02-31 for a date
        mark = getattr(error, "problem_mark", None)
        place = f"line {mark.line + 1}, column {mark.column + 1}: " if mark else ""
        found = f"{place}{getattr(error, 'problem', None) or error}"
        raise BadInput([Problem(path.name, found, "correct the YAML syntax there")], path) from error
    except RecursionError as error:
        remedy = f"take out brackets or indentation: no key of {what} goes as deep"
        raise BadInput([Problem(path.name, "is nested too deep to read", remedy)], path) from error
    if not isinstance(document, dict):
        found = f"holds {show(document)}, not a mapping"
        raise BadInput([Problem(path.name, found, start)], path)
    return document


def parse(
    document: Mapping[str, Any], file: str, sources: Mapping[tuple[str, ...], str]
) -> tuple[LevelSpec | None, list[Problem]]:
    """The models of a document, or all its problems; `sources` tells of keys that others than `file` say."""
    try:
        return LevelSpec.model_validate(document), []
    except ValidationError as error:
        return None, complaints(error, file, sources)
