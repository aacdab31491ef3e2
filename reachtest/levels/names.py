"""Names of their own: a finding is about one solid, zone or required point, and a file may call two of them alike."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import TypeVar

from reachtest.records import Required, Solid, Zone

Named = TypeVar("Named", Solid, Zone, Required)


def distinct(named: Sequence[Named]) -> tuple[Named, ...]:
    """The same in their order, each with a name of its own: the second "box" is "box 2"."""
    given = {each.name for each in named}
    numbers: dict[str, int] = {}
    result: list[Named] = []
    for each in named:
        name, number = each.name, numbers.get(each.name, 0) + 1
        while number > 1 and (name := f"{each.name} {number}") in given:
            number += 1
        numbers[each.name] = number
        result.append(dataclasses.replace(each, name=name))
    return tuple(result)
