"""What shows a pocket again: to stand, or to be wedged, where somebody was held; not its rim, and not for a moment."""

from __future__ import annotations

import numpy as np
import pytest

from reachtest.confirm.outcome import Judge, Outcome
from reachtest.confirm.trials import Trial
from reachtest.surface import SurfaceIndex
from tests.levels import FLOOR, level

NAV = np.array([[[-9, -9, 0], [9, -9, 0], [9, 9, 0]]], dtype=float)
JUDGE = Judge(level(FLOOR, navmesh=NAV), SurfaceIndex(NAV, 3.0))
BOTTOM = np.array([[2.0, 0, -3], [2.8, 0, -3]])
PIT = Outcome("stuck", None, BOTTOM[0], BOTTOM.min(axis=0), np.array([2.8, 0, 0]), None, BOTTOM)
WEDGE = Outcome("stuck", None, BOTTOM[0], BOTTOM[0], BOTTOM[0], None, BOTTOM[:1], reach_m=0.05)
RIM, FLIGHT, INSIDE = (0.9, 0, 0, True), (2, 0, -2.9, False), (2.3, 0, -3.1, True)


def trial(*steps: tuple[float, float, float, bool]) -> Trial:
    """(x, y, z, whether it stood there) after every step, from the rim."""
    positions = np.array([step[:3] for step in steps], dtype=float)
    stood = np.where([[step[3]] for step in steps], positions, np.nan)
    return Trial(np.array(RIM[:3]), np.zeros((len(steps), 2), dtype=np.int8), positions, stood, False)


@pytest.mark.parametrize(
    ("steps", "shown"),
    [
        ([RIM, FLIGHT, INSIDE], 2),
        ([RIM, RIM], None),  # within a metre of the box
        ([RIM, FLIGHT], None),
        ([RIM, FLIGHT, INSIDE, FLIGHT, RIM], None),  # that one got out
        ([RIM, FLIGHT, INSIDE, FLIGHT, RIM, FLIGHT, INSIDE], 2),
        ([FLIGHT, FLIGHT, FLIGHT], 2),  # wedged: it does not move, and has no footing
        ([(2, 0, -1.5, True)], None),  # half filled: another pit, if any
    ],
)
def test_a_pit_is_shown_by_being_in_it_to_the_end(steps, shown) -> None:
    assert JUDGE.step(PIT, trial(*steps)) == shown
    later = JUDGE.step(PIT, trial(*steps), 1)
    assert later == shown


@pytest.mark.parametrize(
    ("steps", "shown"),
    [
        ([FLIGHT, (2.1, 0, -3.0, False), (2.1, 0, -3.0, False), (2.1, 0, -3.0, False)], 3),
        ([RIM, (2.3, 0.2, -2.9, True)], None),  # beside it, where one stands and walks on
    ],
)
def test_who_passes_a_wedge_by_is_not_held_in_it(steps, shown) -> None:
    assert JUDGE.step(WEDGE, trial(*steps)) == shown
