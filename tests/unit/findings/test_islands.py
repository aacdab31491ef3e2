"""Unreached parts of the nav-mesh: which of them are findings, how many, and what they mean for the verdict."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from reachtest.findings import find, judge
from reachtest.navmesh.survey import Survey
from reachtest.records import NavMesh
from tests.levels import FLOOR, box, level
from tests.unit.findings.test_detect import Paths, exploration
from tests.unit.navmesh.make import link, navmesh, rectangle

ROOM = rectangle((-20, -20), (20, 20))
ROOFS = [rectangle((30 + 10 * i, 0), (36 + 10 * i, 6), z=6.0) for i in range(3)]
ROOF_TOPS = [box([30 + 10 * i, 0, 5], [36 + 10 * i, 6, 6]) for i in range(3)]
GOALS = [[0, 0, 0], [15, 15, 0], [33, 3, 6], [43, 3, 6], [53, 3, 6]]


def where(mesh: NavMesh, *pieces):
    return replace(level(FLOOR, *ROOF_TOPS, *pieces), navmesh=mesh)


ROOFED = where(navmesh(ROOM, *ROOFS))
GATED = replace(ROOFED, gate=replace(ROOFED.gate, fail_on=("unreached_area",)))


def run(place, reached, points=()):
    result = exploration([(p, None, True) for p in points], goals=GOALS, reached=reached)
    tried = {"goal_attempts": np.full(5, 256), "goal_border_m": np.zeros(5)}  # enough to call them unreached
    result = replace(result, **tried)
    survey = Survey(place, result)
    findings = find(place, result, Paths(), survey)
    return findings, judge(place.gate, result, findings, survey.counts)


def test_roofs_are_one_finding_that_never_gates_and_do_not_stand_in_the_way_of_a_pass() -> None:
    (finding,), verdict = run(GATED, [9, 9, -1, -1, -1])
    assert finding.kind == "unreached_area"
    assert finding.title.startswith("3 islands of the nav-mesh (108 m2) are not connected")
    assert not finding.gating
    assert finding.points == 3
    assert finding.low.tolist() == [30, 0, 6]
    assert finding.high.tolist() == [56, 6, 6]
    assert len(finding.details) == 3
    assert verdict.name == "pass"
    assert "3 of 5 goals do not count" in verdict.reason


def test_an_unreached_part_of_the_island_of_the_spawn_gates_and_prevents_a_pass() -> None:
    findings, verdict = run(GATED, [9, -1, -1, -1, -1])
    assert [f.gating for f in findings] == [True, False]
    assert findings[0].position.tolist() == [15, 15, 0]
    assert verdict.name == "fail"
    assert verdict.goals_given_up == 0


def test_an_unreached_part_that_the_gate_does_not_ask_for_does_not_prevent_a_pass_and_is_said() -> None:
    _, verdict = run(ROOFED, [9, -1, -1, -1, -1])
    assert verdict.name == "pass"
    assert verdict.goals_given_up == 1
    assert "1 of 5 goals is known to be unreached" in verdict.reason


def test_a_link_makes_a_roof_part_of_what_has_to_be_reached() -> None:
    linked = replace(GATED, navmesh=navmesh(ROOM, *ROOFS, links=[link((15, 15, 0), (31, 3, 6))]))
    findings, verdict = run(linked, [9, 9, -1, -1, -1])
    assert [f.gating for f in findings] == [True, False]
    assert findings[0].position.tolist() == [33, 3, 6]
    assert findings[1].title.startswith("2 islands")
    assert verdict.name == "fail"
    oneway = replace(GATED, navmesh=navmesh(ROOM, *ROOFS, links=[link((31, 3, 6), (15, 15, 0))]))
    assert run(oneway, [9, 9, -1, -1, -1])[1].name == "pass"


@pytest.mark.parametrize("reached", [[9, 9, 9, -1, -1], [9, 9, -1, -1, -1]])
def test_a_roof_that_somebody_got_to_is_no_unreached_one(reached) -> None:
    findings, verdict = run(ROOFED, reached, points=[[33.0, 3, 6]])
    assert [f.title[:9] for f in findings] == ["2 islands"]
    assert verdict.name == "pass"


def test_the_finding_keeps_its_id_whatever_else_is_reached() -> None:
    (one,), _ = run(ROOFED, [9, 9, -1, -1, -1])
    (other,), _ = run(ROOFED, [9, 9, 9, -1, -1], points=[[33.0, 3, 6]])
    assert one.id == other.id


def test_a_spawn_beside_the_nav_mesh_excuses_nothing() -> None:
    lost = replace(ROOFED, spawns=(replace(ROOFED.spawns[0], position=np.array([0.0, 40.0, 0.0])),))
    findings, verdict = run(replace(lost, gate=GATED.gate), [9, 9, -1, -1, -1])
    assert [f.kind for f in findings] == ["unreached_area"] * 3
    assert verdict.name == "fail"


def test_a_spawn_on_an_island_without_goals_is_no_pass() -> None:
    closet = where(navmesh(ROOM, rectangle((-50, -50), (-49, -49))))
    closet = replace(closet, spawns=(replace(closet.spawns[0], position=np.array([-49.5, -49.5, 0.0])),))
    result = exploration(goals=GOALS[:2], reached=[-1, -1])
    verdict = judge(closet.gate, result, (), Survey(closet, result).counts)
    assert verdict.name == "inconclusive"
    assert "none of the 2" in verdict.reason
