"""When two runs saw the same bug."""

from __future__ import annotations

import numpy as np
import pytest

from reachtest.baseline import Place, match


def at(*exits, kind="fell_out_of_world", id_="", low=None, high=None) -> Place:
    points = np.array(exits, dtype=float).reshape(-1, 3)
    low = points.min(axis=0) if low is None else np.array(low, dtype=float)
    high = points.max(axis=0) if high is None else np.array(high, dtype=float)
    return Place(id_ or f"{kind}-00000000", kind, low, high, points)


def test_a_bug_is_known_again_a_few_metres_away_and_across_the_lines_of_the_id_grid() -> None:
    assert match([at([8.1, 0, 0], id_="a")], [at([7.0, 2, 0], id_="b")]) == [0]
    assert match([at([18, 0, 0])], [at([7.0, 2, 0])]) == [None]


def test_a_second_hole_beside_a_known_one_is_new() -> None:
    assert match([at([0.5, 0, 0]), at([6.5, 0, 0])], [at([0, 0, 0])]) == [0, None]
    assert match([at([6.5, 0, 0]), at([0.5, 0, 0])], [at([0, 0, 0])]) == [None, 0]


def test_two_holes_to_one_roof_are_told_apart_by_their_exits() -> None:
    roof = {"kind": "unexpected_area", "low": [0, 0, 9], "high": [100, 100, 9]}
    assert match([at([0, 50, 0], **roof), at([100, 50, 0], **roof)], [at([1, 50, 0], **roof)]) == [0, None]


def test_a_known_rim_that_chance_split_in_two_is_known_in_both_pieces() -> None:
    rim = at(*[[x, 0, 0] for x in range(0, 60, 2)])
    assert match([at([5, 1, 0], [9, 1, 0]), at([41, 1, 0])], [rim]) == [0, 0]


def test_a_hole_in_the_middle_of_a_known_rim_round_the_level_is_new() -> None:
    rim = at([0, 0, 0], [60, 0, 0], [60, 60, 0], [0, 60, 0])
    assert match([at([30, 30, 0])], [rim]) == [None]


def test_kinds_are_not_mixed_but_who_fell_there_may_only_be_seen_standing_there() -> None:
    fell, stood = at([0, 0, 0]), at([0, 0, 0], kind="unexpected_area")
    assert match([stood], [fell]) == [0]
    assert match([fell], [stood]) == [None]
    assert match([at([0, 0, 0], kind="stuck")], [fell]) == [None]


@pytest.mark.parametrize("kind", ["inside_solid", "forbidden_zone", "required_unreached"])
def test_what_has_a_name_is_known_by_it_and_not_by_its_neighbour(kind) -> None:
    one = at(kind=kind, id_=f"{kind}-1234abcd", low=[0, 0, 0], high=[9, 9, 9])
    far = at(kind=kind, id_=f"{kind}-1234abcd", low=[50, 0, 0], high=[51, 9, 9])
    beside = at(kind=kind, id_=f"{kind}-99999999", low=[1, 1, 1], high=[2, 2, 2])
    assert match([far, beside], [one]) == [0, None]


def test_without_exits_the_boxes_count() -> None:
    def area(low, high):
        return at(kind="unreached_area", low=low, high=high)

    known = [area([0, 0, 0], [10, 10, 0])]
    assert match([area([4, 4, 0], [14, 14, 0]), area([40, 0, 0], [41, 1, 0])], known) == [0, None]
    assert match([area([2, 2, 0], [4, 4, 0])], [area([-200, -200, 0], [300, 100, 0])]) == [
        None
    ]  # somewhere in it
    assert match([area([0, 0, 0], [1, 1, 1])], []) == [None]
    assert match([], known) == []


def test_of_two_known_bugs_the_nearer_one_is_meant() -> None:
    assert match([at([3, 0, 0])], [at([0, 0, 0]), at([4, 0, 0])]) == [1]
