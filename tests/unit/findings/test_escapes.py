"""One bug, one finding: holes, rims, fences and roofs, on levels with floors to fall off."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from reachtest.findings import find
from reachtest.records import Exploration, Fall, Finding, Floats, Origin
from tests.levels import FLOOR, box, level
from tests.unit.findings.test_detect import Paths, exploration

KILL_Z = -50.0


def falls(footing, towards, far=8.0) -> Fall:
    """Walks or jumps from `footing`, on the nav-mesh, in a direction [2], and falls out of the world."""
    at = np.array([*footing, 0.0]) if len(footing) == 2 else np.array(footing, dtype=float)
    way = np.array(towards, dtype=float) / np.linalg.norm(towards)
    end = np.array([*(at[:2] + far * way), KILL_Z - 1])
    return Fall(Origin(-1, 0, 0, 0, 9), end, at, at)


def found(*pieces: Floats, result: Exploration) -> list[Finding]:
    return [f for f in find(level(*pieces, kill_z_m=KILL_Z), result, Paths()) if f.kind != "unreached_area"]


def floor_with_holes(*holes: tuple[float, float, float, float]) -> list[Floats]:
    """A floor of 120 x 120 m of strips along y, with rectangular holes (x, y, x, y) side by side along x."""
    pieces, x = [], -60.0
    for low_x, low_y, high_x, high_y in sorted(holes):
        pieces += [
            box([x, -60, -1], [low_x, 60, 0]),
            box([low_x, -60, -1], [high_x, low_y, 0]),
            box([low_x, high_y, -1], [high_x, 60, 0]),
        ]
        x = high_x
    return [*pieces, box([x, -60, -1], [60, 60, 0])]


def into(low_x, low_y, high_x, high_y, back=0.1) -> list[Fall]:
    """Falls into a hole from all sides, each of them `back` m before its edge."""
    sides = [
        side
        for share in (0.25, 0.5, 0.75)
        for side in (
            ([low_x - back, low_y + share * (high_y - low_y)], [1, 0]),
            ([high_x + back, low_y + share * (high_y - low_y)], [-1, 0]),
            ([low_x + share * (high_x - low_x), low_y - back], [0, 1]),
            ([low_x + share * (high_x - low_x), high_y + back], [0, -1]),
        )
    ]
    return [falls(footing, way, far=back + 1.5) for footing, way in sides]


def test_who_bounces_off_the_wall_of_a_hole_shows_the_same_hole() -> None:
    """He ends below the floor where he came from, and no void lies on the straight way there."""
    hole = (6, 3, 8, 5)
    bounced = [falls([2.0, 2.4], [1, 0.2], far=1.0), falls([9.5, 6.0], [1, 1], far=0.5)]
    every = [*into(*hole), *bounced]
    (finding,) = found(*floor_with_holes(hole), result=exploration(falls=every))
    assert finding.points == len(every)
    assert (np.abs(finding.exits[:, :2] - [7, 4]) < 1.3).all()  # at its edges


def test_the_way_of_a_fall_that_bounced_shows_its_edge() -> None:
    """Nobody else fell there, and it ends below the floor behind it."""

    class Ways(Paths):
        def flights(self, falls):
            (fall,) = falls
            return [np.array([fall.footing, [7.6, 4, -0.3], [6.5, 4, -4], [2, 4, -20], fall.position])]

    where = level(*floor_with_holes((6, 3, 8, 5)), kill_z_m=KILL_Z)
    bounced = Fall(Origin(-1, 0, 0, 0, 9), np.array([-5.0, 4.0, KILL_Z - 1]), *[np.array([5.5, 4.0, 0])] * 2)
    (finding,) = [f for f in find(where, exploration(falls=[bounced]), Ways()) if f.kind[0] == "f"]
    np.testing.assert_allclose(finding.exit_point, [6.1, 4, 0], atol=0.2)


@pytest.mark.parametrize(("height", "bugs"), [(3.0, 1), (0.6, 2)])
def test_no_fall_went_through_a_wall_on_its_straight_way(height: float, bugs: int) -> None:
    """He slid along the fence and through its gap; over a low one he jumped where nobody else did."""
    fence = [box([a, 59, 0], [b, 59.5, height]) for a, b in ((-60, 20), (23, 60))]
    gap = [falls([x, 58.5], [0, 1]) for x in (21.0, 22.0)]
    slid = Fall(Origin(-1, 0, 0, 0, 9), np.array([19.0, 62.0, KILL_Z - 1]), *[np.array([8.0, 56.0, 0])] * 2)
    assert len(found(FLOOR, *fence, result=exploration(falls=[*gap, slid]))) == bugs


def test_two_holes_six_metres_apart_are_two_findings() -> None:
    """Also for those who jump into them from the ground between."""
    one, other = (-7, -2, -3, 2), (3, -2, 7, 2)
    every = [fall for hole in (one, other) for back in (0.1, 2.0, 3.0) for fall in into(*hole, back=back)]
    two = found(*floor_with_holes(one, other), result=exploration(falls=every))
    assert [(f.kind, f.points) for f in two] == [("fell_out_of_world", 36)] * 2


def test_a_hole_too_wide_for_the_link_is_still_one() -> None:
    hole = (-8, -8, 8, 8)
    assert len(found(*floor_with_holes(hole), result=exploration(falls=into(*hole)))) == 1


def test_an_open_rim_is_one_finding_however_few_fell_off_it() -> None:
    places = np.random.default_rng(5).uniform(-59, 59, (100, 2))
    sides = np.array([[1, 0], [-1, 0], [0, 1], [0, -1]])
    off = [
        falls(np.where(side, side * 59.9, at), side)
        for at, side in zip(places, np.tile(sides, (25, 1)), strict=True)
    ]
    (rim,) = found(FLOOR, result=exploration(falls=off))
    assert rim.low[:2].min() < -59
    assert rim.high[:2].max() > 59
    assert len(rim.exits) <= 64


GAPS = [falls([x, 59.9], [0, 1]) for x in (-10.0, -9.5, 10.0, 10.5)]


def test_two_gaps_in_a_fence_are_two_findings_and_the_same_falls_without_it_are_one() -> None:
    fence = [box([a, 59, 0], [b, 59.5, 2]) for a, b in ((-60, -11), (-8, 9), (12, 60))]
    assert len(found(FLOOR, *fence, result=exploration(falls=GAPS))) == 2
    assert len(found(FLOOR, result=exploration(falls=GAPS))) == 1


def test_a_ledge_below_the_rim_is_no_void() -> None:
    ledge = box([-7, 60, -3], [7, 70, -2])
    assert len(found(FLOOR, ledge, result=exploration(falls=GAPS))) == 2


ROOF = [([x, y, 8.0], [0, 9, 0], True) for x in range(-50, 50, 4) for y in range(20, 60, 4)]


def test_one_hole_to_a_roofscape_of_100_m_is_one_finding_with_one_exit() -> None:
    (one,) = found(FLOOR, result=exploration(ROOF))
    assert one.kind == "unexpected_area"
    assert one.exit_point.tolist() == [0, 9, 0]
    assert one.exits.tolist() == [[0, 9, 0]]
    assert (one.high - one.low)[0] > 90


def test_falls_off_all_sides_of_that_roofscape_have_its_exit_too() -> None:
    ends = [([-61.0, 30, -51], [-50.0, 30, 8]), ([61.0, 30, -51], [50.0, 30, 8])]
    off = [Fall(Origin(-1, 0, 0, 0, 9), np.array(e), np.array(f), np.array([0.0, 9, 0])) for e, f in ends]
    (one,) = found(FLOOR, result=exploration(ROOF, off))
    assert (one.kind, one.exits.tolist()) == ("fell_out_of_world", [[0, 9, 0]])


def test_an_area_and_a_hole_with_exits_far_apart_are_two() -> None:
    hole = (20, -2, 24, 2)
    both = found(*floor_with_holes(hole), result=exploration(ROOF, into(*hole)))
    assert sorted(f.kind for f in both) == ["fell_out_of_world", "unexpected_area"]


class Ways(Paths):
    """Replays ways that leave the nav-mesh, a triangle south east of the diagonal, at `gates` [n, 3]."""

    def __init__(self, *gates) -> None:
        self.gates = np.array(gates, dtype=float)

    def path_to_point(self, index):
        far = np.array([40.0, 40, 0])
        return replace(
            super().path_to_point(index), positions=np.array([self.gates[index % len(self.gates)], far])
        )


# Two ways into one meadow, whose last expected places are 10 m apart.
MEADOW = [([x, 15.0, 0], [-5 if x % 4 else 5, 11, 0], True) for x in range(-20, 20, 2)]


def meadow(*gates) -> list[Finding]:
    result = exploration(MEADOW)
    return [f for f in find(level(FLOOR), result, Ways(*gates)) if f.kind != "unreached_area"]


def test_one_gap_into_a_space_is_one_finding_and_two_gaps_are_two() -> None:
    assert len(meadow([2, 1, 0])) == 1
    assert len(meadow([2, 1, 0], [8, -8, 0])) == 2


def test_spaces_that_do_not_touch_are_joined_only_where_they_have_one_exit() -> None:
    """All along the outside of a thin wall one counts as expected: behind one window lie spaces far apart."""
    apart = [([0.0, 20, 0], [0, 11, 0], True), ([40.0, 20, 0], [8, 11, 0], True)]
    assert len(find(level(FLOOR), exploration(apart), Ways([2, 1, 0], [2.5, 1, 0]))) == 1
    assert len(find(level(FLOOR), exploration(apart), Ways([2, 1, 0], [4, -1, 0]))) == 2


def test_falls_off_far_rims_of_the_land_behind_one_window_are_one_finding() -> None:
    """Nobody was cached on the last metre before the one in the east; they left the expected in two places."""

    class Window(Paths):
        def path_to_fall(self, fall):
            gate = [2.0, 1, 0] if one_window or fall.footing[0] < 0 else [8.0, -8, 0]
            return replace(super().path_to_fall(fall), positions=np.array([gate, fall.footing]))

    rims = [
        Fall(
            Origin(-1, 0, 0, 0, 9),
            np.array([1.1 * x, 0, -60]),
            np.array([x, 0, 0]),
            np.array([0.1 * x, 9, 0]),
        )
        for x in (-59.0, 59.0)
    ]
    for one_window in (True, False):
        result = find(level(FLOOR), exploration(falls=rims), Window())
        assert len([f for f in result if f.kind == "fell_out_of_world"]) == 2 - one_window


def test_two_platforms_side_by_side_have_two_rims() -> None:
    """Falls off the outer corners, from each of which one sees the other's void."""
    platforms = [box([-30, -20, -1], [-3, 20, 0]), box([3, -20, -1], [30, 20, 0])]
    off = [falls([x, 19.9], [0, 1]) for x in np.arange(-29, 30, 2.0) if abs(x) > 3]
    assert len(found(*platforms, result=exploration(falls=off))) == 2


def test_two_rims_that_face_each_other_over_a_gap_are_two() -> None:
    platforms = [box([-30, -20, -1], [-2.25, 20, 0]), box([2.25, -20, -1], [30, 20, 0])]
    off = [falls([side * 2.3, side * y], [-side, 0], far=2) for side in (-1, 1) for y in (2.0, 4.0, 6.0)]
    assert len(found(*platforms, result=exploration(falls=off))) == 2


def test_who_jumps_off_a_tower_and_over_the_rim_fell_off_the_rim() -> None:
    tower = box([44, -3, 0], [48, 3, 12])
    off = [falls([47.9, y, 12], [1, 0.1 * y], far=20.0) for y in (-1.0, 0.0, 1.0)]
    off += [falls([59.9, y], [1, 0]) for y in (-30.0, -20.0, 20.0)]
    (rim,) = found(FLOOR, tower, result=exploration(falls=off))
    assert rim.exits[:, 0].min() > 59
    assert np.abs(rim.exits[:, 2]).max() < 0.1


def test_a_rim_goes_on_over_a_plateau_that_was_jumped_from() -> None:
    plateau = box([52, 0, 0], [60, 60, 6])
    low = [falls([59.9, y], [1, 0]) for y in (-9.0, -5.0, -3.0)]
    high = [falls([59.9, y, 6], [1, 0]) for y in (1.0, 5.0)]
    jump = [falls([58.5, 0.2, 6], [1, -1])]  # over the corner: past the plateau, off the ground
    assert len(found(FLOOR, plateau, result=exploration(falls=low + high))) == 2
    assert len(found(FLOOR, plateau, result=exploration(falls=low + high + jump))) == 1


def over_the_alley(exit_x, footing_x) -> Fall:
    """By a running jump from a roof to a wall top beyond an alley, and off it."""
    end, footing = np.array([footing_x, 60.0, KILL_Z - 1]), np.array([footing_x, 52.9, 4.0])
    return Fall(Origin(-1, 0, 0, 0, 9), end, footing, np.array([exit_x, 47.4, 4.0]))


ALLEY = [box([-60, 40, 3], [60, 50, 4]), box([-60, 52, 0], [60, 53, 4])]
STREET = box([-60, -60, -1], [60, 53, 0])


def test_falls_off_a_ledge_beside_an_open_edge_are_one_however_few() -> None:
    few = [over_the_alley(x, x + 3) for x in (-20.0, -8.0, 2.0, 14.0)]
    past = falls([8.0, 49.0, 4.0], [0.1, 1], far=12)  # over the wall without touching it
    assert len(found(STREET, *ALLEY, result=exploration(falls=[*few, past]))) == 1


def test_two_gaps_to_one_ledge_are_two_also_where_they_lead_to_the_same_edge() -> None:
    fence = [box([a, 49, 4], [b, 49.5, 6]) for a, b in ((-60, -9), (-7, 7), (9, 60))]
    both = [over_the_alley(x, x / 8) for x in (-8.2, -8.0, 8.0, 8.2)]
    assert len(found(STREET, *ALLEY, *fence, result=exploration(falls=both))) == 2
