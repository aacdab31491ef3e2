"""What one finding says: its name, its place, its way; and the order they come in."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from reachtest.findings import find, judge
from reachtest.findings.places import say_place
from reachtest.records import (
    Exploration,
    Frame,
    GateSettings,
    Part,
    ReplayPath,
    Required,
    Solid,
    StopReason,
    Zone,
)
from tests.levels import FLOOR, box, level
from tests.unit.findings.test_detect import Paths, exploration, fall

PARTS = (
    Part("floor", np.array([-60.0, -60, -1]), np.array([60.0, 60, 0])),
    Part("tower", np.array([18.0, 18, 0]), np.array([22.0, 22, 9])),
)
LEVEL = replace(level(FLOOR), parts=PARTS)


class Asked(Paths):
    """Remembers which points it was asked the way to."""

    def __init__(self) -> None:
        self.points: list[int] = []

    def path_to_point(self, index: int) -> ReplayPath:
        self.points.append(index)
        return super().path_to_point(index)


def grown(result: Exploration, **columns: list[int]) -> Exploration:
    """With other columns of its points."""
    points = result.points
    changed = {name: np.array(values, dtype=getattr(points, name).dtype) for name, values in columns.items()}
    return replace(result, points=replace(points, **changed))


# --- ids ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("shift", [[0.3, 0.2, 0.1], [-0.3, 0.4, 0.0], [0.0, -0.5, 0.2]])
def test_id_survives_a_small_shift_but_at_the_lines_of_its_grid(shift) -> None:
    """Two seeds never leave the nav-mesh at exactly the same place. A shift of half a metre crosses a line of an
    8 m grid in one place of ten; who must know a bug again for sure compares places, not ids."""
    changed = []
    for x in np.arange(-30, 30, 2.5):
        here = np.array([x, 11.0, 0.0])
        ids = {
            find(LEVEL, exploration([((place + [0, 9, 0]).tolist(), place.tolist(), True)]), Paths())[0].id
            for place in (here, here + shift)
        }
        if len(ids) > 1:
            changed.append(x)
    assert len(changed) <= 3  # of 24


def test_id_of_a_solid_does_not_depend_on_where_it_was_entered() -> None:
    """There is one finding for each solid: its name is the id."""
    where = replace(LEVEL, solids=(Solid("monolith", box([5, 5, 0], [25, 25, 4])),))
    ids = {
        find(where, exploration([(entry, [1.5 * x - 7.5 for x in entry[:2]] + [0.0], True)]), Paths())[0].id
        for entry in ([6.0, 6, 0], [24.0, 24, 0], [20.0, 6, 2], [6.0, 24, 0])
    }
    assert len(ids) == 1


def test_id_of_a_forbidden_zone_does_not_depend_on_where_it_was_entered() -> None:
    where = replace(
        LEVEL, zones=(Zone("vault", "forbidden", np.array([5.0, 5, -1]), np.array([25.0, 25, 4])),)
    )
    ids = {
        find(where, exploration([(entry, [1.5 * x - 7.5 for x in entry[:2]] + [0.0], True)]), Paths())[0].id
        for entry in ([6.0, 6, 0], [24.0, 24, 0], [20.0, 6, 2], [6.0, 24, 0])
    }
    assert len(ids) == 1


def test_ids_do_not_depend_on_the_order_of_discovery() -> None:
    found = [([x, 30.0, 0], [x, 9.0, 0], True) for x in (-40.0, -20.0, 0.0, 20.0, 40.0)]
    one = find(LEVEL, exploration(found), Paths())
    other = find(LEVEL, exploration(found[::-1]), Paths())
    assert len({f.id for f in one}) == 5
    assert {(f.id, *f.position) for f in one} == {(f.id, *f.position) for f in other}


# --- what is shown --------------------------------------------------------------------------------


def test_the_shortest_way_to_somewhere_to_stand_is_shown() -> None:
    """0 is the only one reached directly, but nobody stands there; 1 is far; 2 is the way; 3 hangs on 1."""
    spots = [([9.0 + i, 20.0, 0], [9.0, 9.0, 0], i > 0) for i in range(4)]
    result = grown(exploration(spots), step=[1, 90, 40, 50], start=[0, 0, 0, 0], parent=[-1, -1, -1, 1])
    asked = Asked()
    (finding,) = find(LEVEL, result, asked)
    assert asked.points == [2]
    assert finding.position.tolist() == [11, 20, 0]
    assert finding.exit_point.tolist() == [9, 9, 0]
    assert finding.path.attempts == finding.path.succeeded == 1


def test_first_seen_is_the_agent_step_of_the_whole_run() -> None:
    """16 agents with 8 episodes of 32 steps: 4096 a round; within a step, lane after lane."""
    spots = [([9.0 + i, 20.0, 0], [9.0, 9.0, 0], True) for i in range(3)]
    result = grown(exploration(spots), round=[7, 2, 2], step=[3, 5, 5], agent=[0, 9, 4])
    (finding,) = find(LEVEL, result, Paths())
    assert finding.first_seen_step == 2 * 4_096 + 4 * 128 + 4 + 1


def test_bounds_enclose_everywhere_somebody_stood() -> None:
    spots = [
        ([9.0, 20.0, 0], [9, 9, 0], True),
        ([30.0, 25.0, 3], [9, 9, 0], True),
        ([3.0, 2, -9], [9, 9, 0], False),
    ]
    (finding,) = find(LEVEL, exploration(spots, [fall([9.5, 18.0, 0.0], [9, 9, 0])]), Paths())
    assert finding.low.tolist() == [9, 18, 0]
    assert finding.high.tolist() == [30, 25, 3]


def test_a_place_is_named_after_the_part_it_belongs_to() -> None:
    def named(exit_point: list[float]) -> str | None:
        return find(LEVEL, exploration([([40.0, 40, 0], exit_point, True)]), Paths())[0].nearest_named

    assert named([20.0, 20.0, 9.0]) == "tower"
    assert named([-40.0, 20.0, 0.0]) == "floor"
    nameless = replace(LEVEL, parts=())
    assert find(nameless, exploration([([40.0, 40, 0], [9, 9, 0], True)]), Paths())[0].nearest_named is None


def test_a_spawn_off_the_navmesh_has_no_exit_and_is_still_a_finding() -> None:
    result = exploration([([20.0, 20, 0], [1.0, 1, 0], True)])
    result = replace(result, points=replace(result.points, exit_point=np.full((1, 3), np.nan)))
    (finding,) = find(LEVEL, result, Paths())
    assert finding.kind == "unexpected_area"
    assert finding.exit_point is None
    assert finding.position.tolist() == [20, 20, 0]


# --- which kind -----------------------------------------------------------------------------------


def test_a_forbidden_zone_is_forbidden_on_the_navmesh_too() -> None:
    where = replace(
        LEVEL, zones=(Zone("vault", "forbidden", np.array([-1.0, -1, -1]), np.array([1.0, 1, 1])),)
    )
    assert [f.kind for f in find(where, exploration([([0, 0, 0], None, True)]), Paths())] == [
        "forbidden_zone"
    ]


def test_one_place_is_one_kind_of_bug() -> None:
    """In a solid and off the nav-mesh; in a forbidden zone and off the nav-mesh."""
    low, high = np.array([29.0, 29, -1]), np.array([31.0, 31, 1])
    where = replace(
        LEVEL,
        solids=(Solid("rock", box([19, 19, 0], [22, 22, 4])),),
        zones=(Zone("vault", "forbidden", low, high),),
    )
    spots = [([20.5, 20.5, 0], [9, 9, 0], True), ([30, 30, 0], [9, 9, 0], True)]
    kinds = [f.kind for f in find(where, exploration(spots), Paths())]
    assert kinds == ["forbidden_zone", "inside_solid"]


def test_a_fall_is_no_less_a_fall_in_an_allowed_zone() -> None:
    zone = Zone("roof", "allowed_off_mesh", np.array([5.0, 5, -1]), np.array([60.0, 60, 9]))
    found = find(replace(LEVEL, zones=(zone,)), exploration((), [fall([20, 20, 0], [9, 9, 0])]), Paths())
    assert [f.kind for f in found] == ["fell_out_of_world"]


def test_reached_goals_and_required_points_are_no_findings() -> None:
    where = replace(LEVEL, required=(Required("flag", np.array([1.0, 1, 0]), 1.0),))
    assert find(where, exploration(goals=[[0, 0, 0]], reached=[7], required=[9]), Paths()) == ()


# --- order and verdict ----------------------------------------------------------------------------


def test_gating_findings_come_first_and_large_ones_before_small_ones() -> None:
    small = [([-40.0, -40, 0], [-9, -9, 0], True)]
    large = [([40.0, 40.0 + i, 0], [9, 9, 0], True) for i in range(5)]
    goals = [[0.0, 50, 0]]
    where = replace(
        LEVEL, gate=GateSettings(("unexpected_area",)), required=(Required("flag", np.zeros(3), 1.0),)
    )
    result = exploration(small + large, [fall([50, 0, 0], [40, 0, 0])], goals, [-1], [-1])
    found = find(where, result, Paths())
    assert [(f.kind, f.gating, f.points) for f in found] == [
        ("unexpected_area", True, 5),
        ("unexpected_area", True, 1),
        ("fell_out_of_world", False, 1),
        ("required_unreached", False, 1),
        ("unreached_area", False, 1),
    ]
    assert [f.severity for f in found] == ["error"] * 4 + ["warning"]


def test_what_is_suppressed_or_does_not_gate_fails_nothing() -> None:
    result = exploration([([20, 20, 0], [9, 9, 0], True)], goals=[[0, 0, 0]], reached=[1])
    (finding,) = find(LEVEL, result, Paths())
    assert judge(LEVEL.gate, result, [finding]).exit_code == 1
    assert judge(LEVEL.gate, result, [replace(finding, suppressed_by="baseline.json")]).exit_code == 0
    quiet = GateSettings(())
    assert judge(quiet, result, find(replace(LEVEL, gate=quiet), result, Paths())).name == "pass"


def test_a_verdict_says_what_is_missing() -> None:
    result = exploration(goals=[[0, 0, 0], [9, 9, 0]], reached=[1, -1])
    gate = GateSettings((), min_goals_reached=0.9, max_discovery_probability=0.01)
    reason = judge(gate, result, ()).reason
    for fact in ("1 of 2", "90%", "min_goals_reached", "5%", "1%", "max_discovery_probability"):
        assert fact in reason
    assert judge(gate, replace(result, stop_reason=StopReason.TERMINATED), ()).exit_code == 143


def test_an_exploration_that_found_nothing_at_all() -> None:
    assert find(LEVEL, exploration(), Paths()) == ()


def test_places_in_details_are_told_to_the_unit_however_far_off() -> None:
    frame = Frame(np.array([[0.01, 0, 0], [0, 0, -0.01], [0, 0.01, 0]]), "y", "cm")
    where = replace(level(FLOOR), frame=frame)
    assert say_place(where, np.array([12345.678, -4000.5, 10.0])) == "(1234568, 1000, 400050)"
    assert say_place(level(FLOOR), np.array([1.25, 0.0, -3.5])) == "(1.25, 0, -3.5)"
