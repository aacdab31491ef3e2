"""Traps: which of their places hold whoever gets into them."""

from __future__ import annotations

import numpy as np
import pytest

from reachtest.explore.regions import _held

BOTTOM, JAM, RIM = [0, 0, 0, 0], [1], [2]


@pytest.mark.parametrize(
    ("part", "ends", "held"),
    [
        (BOTTOM + RIM, BOTTOM, BOTTOM),  # one slides over the rim, and goes to and fro on the bottom
        (BOTTOM + RIM + JAM, JAM, BOTTOM + JAM),  # somebody was jammed down there once
        (JAM, JAM, JAM),  # a wedge, and nothing else
        (RIM + JAM, JAM, JAM),  # a wedge and the way into it
    ],
)
def test_a_pit_holds_also_where_somebody_was_jammed_in_it(
    part: list[int], ends: list[int], held: list[int]
) -> None:
    label = np.array(part)
    rows = _held(np.arange(len(label)), np.isin(label, ends), label)
    assert label[rows].tolist() == held
