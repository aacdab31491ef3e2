"""What every character does in the gym (maps/gym), as the README's Markdown table: `python ci/gym.py`.

`--all` prints every number beside its limits instead; words choose exercises that have them in their names.
"""

from __future__ import annotations

import argparse
import sys
from math import isfinite
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from tests.gym import CHARACTERS, EXERCISES, perform


def number(value: float) -> str:
    """Two decimals, no minus before a zero."""
    return f"{round(value, 2) + 0.0:.2f}"


def limits(check: Any) -> str:
    """The limits of a check in words."""
    low, high = check.at_least, check.at_most
    if isfinite(low) and isfinite(high):
        return f"{number(low)} to {number(high)}"
    return f"at least {number(low)}" if isfinite(low) else f"at most {number(high)}"


def row(name: str) -> str:
    """The first number of an exercise for every character; bold where any of its limits is not kept."""
    cells, what = [], ""
    for character in CHARACTERS.values():
        exercise = EXERCISES[name](character)
        if exercise is None:
            cells.append("-")
            continue
        track = perform(exercise, character)
        check = exercise.checks[0]
        what = check.what
        text = f"{number(check.value(track))} ({limits(check)})"
        cells.append(text if all(check.holds(track) for check in exercise.checks) else f"**{text}**")
    return f"| {name} | {what} | " + " | ".join(cells) + " |"


def everything(name: str) -> None:
    """Every number of an exercise."""
    for who, character in CHARACTERS.items():
        exercise = EXERCISES[name](character)
        track = exercise and perform(exercise, character)
        for check in exercise.checks if exercise else ():
            verdict = "kept" if check.holds(track) else "**broken**"
            print(
                f"| {name} | {who} | {check.what} | {number(check.value(track))} | {limits(check)} | {verdict} |"
            )


def main() -> None:
    """Do the exercises and print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("words", nargs="*")
    parser.add_argument("--all", action="store_true")
    options = parser.parse_args()
    names = [name for name in EXERCISES if all(word in name for word in options.words)]
    heads = ("exercise", "character", "number", "is", "asked", "") if options.all else None
    heads = heads or ("exercise", "number (asked)", *CHARACTERS)
    print("| " + " | ".join(heads) + " |\n" + "|---" * len(heads) + "|")
    for name in names:
        if options.all:
            everything(name)
        else:
            print(row(name), flush=True)


if __name__ == "__main__":
    main()
