"""The nav-mesh does not fit the character: one finding, with numbers and places, instead of unreached areas."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from reachtest.findings import find, judge
from reachtest.findings.audit import missed_ground
from reachtest.findings.evidence import Evidence
from reachtest.navmesh.survey import Survey
from reachtest.records import Frame, NavAgent
from tests.levels import FLOOR, box, level
from tests.unit.findings.test_detect import Paths, exploration
from tests.unit.navmesh.make import link, navmesh, rectangle

HALL = rectangle((-2, -2), (40, 2))
BEAMS = [box([x, -4, 1.5], [x + 3, 4, 1.8]) for x in (9, 20, 30)]
GOALS = [[1, 0, 0], [5, 0, 0], [10.5, 0, 0], [15, 0, 0], [25, 0, 0], [36, 0, 0]]
STOOD = [([1.0, 0, 0], None, True), ([5.0, 0, 0], None, True)]


def run(place, reached=(9, 9, -1, -1, -1, -1)):
    result = exploration(STOOD, goals=GOALS, reached=reached)
    survey = Survey(place, result)
    findings = find(place, result, Paths(), survey)
    return findings, judge(place.gate, result, findings, survey.counts)


def place(*pieces, agent=None, **changes):
    return replace(level(FLOOR, *pieces), navmesh=navmesh(HALL, agent=agent), **changes)


def test_beams_are_one_finding_and_what_lies_behind_them_no_unreached_area() -> None:
    (finding,), verdict = run(place(*BEAMS))
    assert finding.kind == "navmesh_mismatch"
    assert not finding.gating
    assert "too low at 3 places (1.50 m, it needs 1.76 m)" in finding.title
    assert finding.points == 3
    assert "not reached for that reason: 4 goals" in finding.details[-1]
    assert finding.low[0] >= 8.5
    assert finding.high[0] == 36
    assert verdict.name == "pass"
    assert "4 of 6 goals do not count" in verdict.reason


def test_without_the_beams_they_are_unreached_and_prevent_a_pass() -> None:
    findings, verdict = run(place())
    assert {f.kind for f in findings} == {"unreached_area"}
    assert verdict.name == "inconclusive"


def test_it_gates_where_that_is_asked_for() -> None:
    strict = place(*BEAMS)
    strict = replace(strict, gate=replace(strict.gate, fail_on=("navmesh_mismatch",)))
    findings, verdict = run(strict)
    assert findings[0].gating
    assert verdict.name == "fail"


def test_agents_that_differ_are_said_with_their_numbers() -> None:
    agent = NavAgent(radius_m=0.34, height_m=1.44, climb_m=0.6, slope_deg=44.0)
    (finding,), verdict = run(place(agent=agent), reached=(9,) * 6)
    assert finding.kind == "navmesh_mismatch"
    assert [line.split(":")[0] for line in finding.details] == ["height", "climb"]
    assert "1.44 m" in finding.details[0]
    assert "1.76 m" in finding.details[0]
    assert verdict.name == "pass"
    assert run(place(agent=NavAgent(height_m=2.0, radius_m=0.6)), reached=(9,) * 6)[0] == ()


def test_stairs_too_high_to_walk_up_are_said_once_with_the_height_of_the_step() -> None:
    stairs = [box([8 + i, -4, -1], [60, 4, 0.5 * (i + 1)]) for i in range(5)]
    flat, over = rectangle((-2, -2), (7, 2)), rectangle((7, -2), (12, 2), rise=2.5)
    where = replace(place(*stairs), navmesh=navmesh(flat, over, rectangle((12, -2), (40, 2), z=2.5)))
    findings, _ = run(where)
    (finding,) = [f for f in findings if f.kind == "navmesh_mismatch"]
    assert "steps of 0.50 m at 1 place (it walks up 0.45 m)" in finding.title
    treads = [rectangle((8.36 + i, -2), (8.64 + i, 2), z=0.5 * (i + 1)) for i in range(4)]
    where = replace(where, navmesh=navmesh(flat + [0.5, 0, 0], *treads))
    (finding,) = [f for f in run(where)[0] if f.kind == "navmesh_mismatch"]
    assert "cut apart by steps of 0.50 m at 1 place" in finding.title


def test_places_are_told_in_the_axes_of_the_level_file() -> None:
    y_up_cm = Frame(0.01 * np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]]), "y", "cm")
    (finding,), _ = run(place(BEAMS[0], frame=y_up_cm))
    x, y, z = (float(value) for value in finding.details[0].split("(")[1].split(")")[0].split(","))
    assert 900 <= x <= 1200
    assert (abs(y), abs(z)) <= (1, 200)


# --- audit ------------------------------------------------------------------------------------------------


def audit(points, **changes):
    where = replace(level(FLOOR), navmesh=navmesh(rectangle((-5, -5), (5, 5)), **changes))
    return missed_ground(Evidence(where, exploration(points), Paths()))


def test_audit_lists_the_ground_that_the_nav_mesh_misses_largest_first() -> None:
    one = [([6.5, y, 0.0], None, True) for y in (-2.0, 0.0, 2.0)]
    two = [([0.0, 6.9, 0.0], None, True)]
    fine = [([5.4, 4, 0], None, True), ([1, 1, 0.4], None, True), ([-6.5, 0, 0], None, False)]
    far = [([20, 20, 0], [5, 5, 0], True)]
    entries = audit(two + fine + far + one)
    assert [entry["points"] for entry in entries] == [3, 1]
    assert entries[0]["bounds"] == [[6.5, -2, 0], [6.5, 2, 0]]
    assert entries[0]["position"] == entries[0]["source_position"] == [6.5, 0, 0]


@pytest.mark.parametrize("ends_there", [True, False])
def test_the_end_of_a_link_is_no_missed_ground(ends_there: bool) -> None:
    end = (7.0, 0, 0) if ends_there else (9.0, 0, 0)
    assert len(audit([([7.0, 0, 0], None, True)], links=[link((0, 0, 0), end)])) == (0 if ends_there else 1)
