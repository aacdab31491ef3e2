"""Places in the words of a finding's details: the level file's own axes and units, as a designer pastes them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from reachtest.records import Floats, Level

_MOST = 4  # of the places that one line names


def say_place(level: Level, position: Floats) -> str:
    """ "(1.25, 0, -3.5)" of a position [3] [m]: to a centimetre, or to the unit where that is smaller."""
    digits = max(0, int(np.ceil(np.log10(level.frame.unit_m / 0.01) - 1e-9)))
    values = level.frame.to_source(position).round(digits) + 0.0  # + 0.0: no "-0"
    return "(" + ", ".join(np.format_float_positional(value, trim="-") for value in values.tolist()) + ")"


def say_places(level: Level, positions: Sequence[Floats]) -> str:
    """The first few of `positions`, and how many there are beside them."""
    told = ", ".join(say_place(level, position) for position in positions[:_MOST])
    more = len(positions) - _MOST
    return f"at {told}" + (f" and {more:,} more" if more > 0 else "")


def plural(count: int, noun: str) -> str:
    """ "1 place", "1,200 places"."""
    return f"{count:,} {noun}{'' if count == 1 else 's'}"
