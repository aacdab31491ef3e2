"""Values put over those of a level file: by a configuration file, and over both by the command line."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from reachtest.errors import Problem
from reachtest.levels.fields import nearest, show
from reachtest.levels.keys.document import read_yaml

COMMAND_LINE = "command line"
CONFIG_SECTIONS = (
    "explore",
    "gate",
)  # what may differ from run to run; what a level is stands in its own file
LEVELS_OWN = {
    (
        "explore",
        "expected_within_m",
    ): "it says what the level's nav-mesh promises: put it into the level file",
    ("gate", "baseline"): "known bugs are one level's: put it into the level file, or give --baseline",
}
_BUDGETS = {"time_budget", "time_budget_s"}

KeyPath = tuple[str, ...]  # section, key, ...


@dataclass
class Overlay:
    """Layers of values, section by section as in a level file; the later ones win."""

    layers: list[tuple[Mapping[str, Any], int]] = field(default_factory=list)  # with their depth
    sources: dict[KeyPath, str] = field(default_factory=dict)  # who says so, for every key of a layer
    problems: list[Problem] = field(default_factory=list)

    def add(self, values: Mapping[str, Any], source: str, depth: int) -> None:
        """Put `values` on top, key by key down to `depth` (1: in sections); what is deeper is replaced."""
        self.layers.append((values, depth))
        self.sources.update(dict.fromkeys(_keys(values, depth), source))

    def over(self, document: Mapping[str, Any]) -> dict[str, Any]:
        """`document` under all the layers."""
        merged = dict(document)
        for layer, depth in self.layers:
            merged |= {
                section: _over(merged.get(section), values, depth) for section, values in layer.items()
            }
        return merged


def overlay(config: Path | None, command_line: Mapping[str, Any] | None) -> Overlay:
    """What a configuration file and the command line say. Raises BadInput where the file cannot be read."""
    result = Overlay()
    if config is not None:
        remedy = "give it the sections explore and gate, as a level file has them"
        said = read_yaml(config, "a configuration", remedy)
        result.problems = list(_out_of_place(said, config.name))
        given = {key: _allowed(key, said[key]) for key in CONFIG_SECTIONS if said.get(key) is not None}
        result.add(given, config.name, depth=1)
    result.add(command_line or {}, COMMAND_LINE, depth=2)
    return result


def _out_of_place(said: Mapping[str, Any], file: str) -> Iterator[Problem]:
    """What a configuration says that only a level file may."""
    for key in (key for key in said if key not in CONFIG_SECTIONS):
        remedy = f"{nearest(str(key), CONFIG_SECTIONS)}valid: {', '.join(CONFIG_SECTIONS)}"
        yield Problem(file, f"unknown key {key!r}", f"{remedy}; all else stands in the level file")
    for (section, key), why in LEVELS_OWN.items():
        values = said.get(section)
        if isinstance(values, Mapping) and key in values:
            yield Problem(f"{file}: {section}.{key}", f"found {show(values[key])}", why)


def _allowed(section: str, values: Any) -> Any:
    if not isinstance(values, Mapping):
        return values
    return {key: value for key, value in values.items() if (section, key) not in LEVELS_OWN}


def _over(below: Any, values: Any, depth: int) -> Any:
    """What is `below` with `values` over it; a mistake below stays, to be told."""
    if not depth or not isinstance(values, Mapping):
        return values
    if below is not None and not isinstance(below, Mapping):
        return below
    merged = dict(below or {})
    if given := _BUDGETS & values.keys():  # one budget under two names: the one on top wins
        merged = {key: value for key, value in merged.items() if key not in _BUDGETS - given}
    return merged | {key: _over(merged.get(key), value, depth - 1) for key, value in values.items()}


def _keys(values: Mapping[str, Any], depth: int, above: KeyPath = ()) -> Iterator[KeyPath]:
    for key, value in values.items():
        if depth and isinstance(value, Mapping):
            yield from _keys(value, depth - 1, (*above, key))
        else:
            yield (*above, key)
