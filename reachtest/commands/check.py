"""`reachtest validate` and `reachtest schema`: level files, without running them."""

from __future__ import annotations

import json

from reachtest.commands.arguments import ConfigFile, LevelFile
from reachtest.commands.say import say


def validate(level: LevelFile, config: ConfigFile = None) -> None:
    """Check a level file and everything it names, without running it, and say what was understood."""
    from reachtest.baseline import baseline_of
    from reachtest.explore import check_heuristics
    from reachtest.levels import check_level, load_level

    loaded = load_level(level, config=config)
    check_heuristics(loaded, config)
    baseline_of(loaded)
    check = check_level(loaded)
    width = max(len(name) for name, _ in check.facts)
    for name, fact in check.facts:
        say(f"{name.ljust(width)}  {fact}")
    for warning in check.warnings:
        say(f"warning: {warning}")
    say(f"{level.name} is valid" + (f", {len(check.warnings)} warnings" if check.warnings else ""))


def schema() -> None:
    """Print the JSON schema of level.yaml, for editors."""
    from reachtest.levels import json_schema

    say(json.dumps(json_schema(), indent=2))
