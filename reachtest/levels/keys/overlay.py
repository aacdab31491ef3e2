"""Values put over those of a level file: by a configuration file, and over both by the command line."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from reachtest.errors import Problem
from reachtest.levels.keys.document import read_yaml
from reachtest.levels.keys.fields import nearest

COMMAND_LINE = "command line"
CONFIG_SECTIONS = (
    "explore",
    "gate",
)  # what may differ from run to run; what a level is stands in its own file


@dataclass
class Overlay:
    """Layers of values, section by section as in a level file; the later ones win."""

    layers: list[Mapping[str, Any]] = field(default_factory=list)
    sources: dict[str, str] = field(default_factory=dict)  # who says so, for every key of a layer
    problems: list[Problem] = field(default_factory=list)

    def add(self, values: Mapping[str, Any], source: str) -> None:
        """Put `values` on top."""
        self.layers.append(values)
        self.sources.update(dict.fromkeys(_leaves(values), source))

    def over(self, document: Mapping[str, Any]) -> dict[str, Any]:
        """`document` under all the layers."""
        merged = dict(document)
        for layer in self.layers:
            merged = merge(merged, layer)
        return merged


def overlay(config: Path | None, command_line: Mapping[str, Any] | None) -> Overlay:
    """What a configuration file and the command line say. Raises BadInput where the file cannot be read."""
    result = Overlay()
    if config is not None:
        said = read_yaml(
            config, "a configuration", "give it the sections explore and gate, as a level file has them"
        )
        for key in (key for key in said if key not in CONFIG_SECTIONS):
            remedy = f"{nearest(str(key), CONFIG_SECTIONS)}valid: {', '.join(CONFIG_SECTIONS)}"
            result.problems.append(
                Problem(config.name, f"unknown key {key!r}", f"{remedy}; all else stands in the level file")
            )
        result.add({key: said[key] for key in CONFIG_SECTIONS if said.get(key) is not None}, config.name)
    result.add(command_line or {}, COMMAND_LINE)
    return result


def merge(document: Mapping[str, Any], values: Mapping[str, Any]) -> dict[str, Any]:
    """`document` with `values` put over it, section by section."""
    merged = dict(document)
    for key, value in values.items():
        below = merged.get(key)
        if not isinstance(value, Mapping):
            merged[key] = value
        elif below is None or isinstance(below, Mapping):  # else the mistake below stays, to be told
            merged[key] = merge(below or {}, value)
    if "time_budget" in values or "time_budget_s" in values:
        # One budget under two names: the one on top wins.
        for name in {"time_budget", "time_budget_s"} - values.keys():
            merged.pop(name, None)
    return merged


def _leaves(tree: Mapping[str, Any], prefix: str = "") -> Iterator[str]:
    for key, value in tree.items():
        if isinstance(value, Mapping):
            yield from _leaves(value, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}"
