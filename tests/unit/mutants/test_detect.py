"""A run found a mutant if it says something about it that the run without the mutant does not say."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from reachtest.mutants.boxes import Box
from reachtest.mutants.decide import Change
from reachtest.mutants.detect import found_by, unreached_in
from reachtest.mutants.records import Mutant
from reachtest.records import Finding

HOLE = Mutant("hole", Box(np.zeros(3), np.array([0.8, 0.8, 0.3])), ("fell_out_of_world", "unexpected_area"))
FELL = Change(("fell",), np.zeros((1, 3)))
DOOR = Mutant("blocked door", Box(np.zeros(3), np.array([0.4, 1.0, 2.0])), ("unreached_area",))
LOST = Change(("lost",), np.array([[x, 0.0, 0.0] for x in range(2, 30)]))


def finding(
    kind: str, at: tuple[float, float, float], exit_at: tuple[float, float, float] | None = None
) -> Finding:
    place = np.array(at, dtype=float)
    return Finding(
        id=f"{kind}-00000000", kind=kind, severity="error", gating=True, title=kind, position=place, low=place,
        high=place, points=1, exit_point=None if exit_at is None else np.array(exit_at, dtype=float),
        nearest_named=None, first_seen_step=1, path=None, suppressed_by=None,
    )  # fmt: skip


def test_a_new_finding_of_a_telling_kind_at_the_place_counts() -> None:
    told = finding("fell_out_of_world", (3, 0, -20), exit_at=(2, 0, 0))
    assert found_by(HOLE, FELL, [told], []) is told


@pytest.mark.parametrize(
    ("found", "without"),
    [
        ([finding("stuck", (1, 0, 0))], []),  # says something else
        ([finding("fell_out_of_world", (1, 0, -20), (30, 0, 0))], []),  # through another hole
        (
            [finding("fell_out_of_world", (1, 0, -20), (2, 0, 0))],
            [finding("fell_out_of_world", (1, 0, -20), (1, 0, 0))],
        ),
        ([], []),
    ],
)
def test_other_findings_do_not(found: list[Finding], without: list[Finding]) -> None:
    assert found_by(HOLE, FELL, found, without) is None


def test_what_gates_is_new_where_a_remark_was_before() -> None:
    """Islands that nothing connects are told of by a box around them all, and no build fails because of them."""
    cut_off = dataclasses.replace(finding("unreached_area", (8, 0, 0)), low=np.array([2.0, -3, 0]))
    remark = dataclasses.replace(cut_off, gating=False)
    assert found_by(DOOR, LOST, [remark, cut_off], [remark]) is cut_off
    assert found_by(DOOR, LOST, [cut_off], [cut_off]) is None
    assert found_by(DOOR, LOST, [remark], [remark]) is None
    assert found_by(DOOR, LOST, [remark], [cut_off]) is None


def test_of_several_the_worst_is_named() -> None:
    found = [
        finding("unexpected_area", (1, 0, -4), (1, 0, 0)),
        finding("fell_out_of_world", (1, 0, -20), (1, 0, 0)),
    ]
    told = found_by(HOLE, FELL, found, [])
    assert told is not None
    assert told.kind == "fell_out_of_world"


def test_an_unreached_area_counts_where_the_door_cut_off() -> None:
    assert found_by(DOOR, LOST, [finding("unreached_area", (25, 1, 0))], []) is not None
    assert found_by(DOOR, LOST, [finding("unreached_area", (-25, 1, 0))], []) is None


def test_a_blocked_room_is_new_though_islands_all_over_the_level_were_known() -> None:
    low, high = np.array([-90.0, -60, -9]), np.array([90.0, 60, 20])
    islands = finding("unreached_area", (0, 60, 9))
    islands = dataclasses.replace(islands, id="unreached_area-11111111", low=low, high=high)
    room = finding("unreached_area", (5, 1, 0))  # near the middle of the islands' bounds
    assert found_by(DOOR, LOST, [islands, room], [islands]) is room
    assert found_by(DOOR, LOST, [islands], [islands]) is None


def test_goals_behind_a_door_are_counted_as_unreached() -> None:
    goals = np.array([[5.0, 0, 0], [9.0, 0, 0], [-5.0, 0, 0]])
    assert unreached_in(LOST, goals, np.array([False, True, False])) == 1
    assert unreached_in(FELL, goals, np.array([False, False, False])) == 0
