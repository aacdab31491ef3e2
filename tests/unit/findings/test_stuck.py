"""Pockets of the exploration as findings: what is said of them, and what is left out."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from reachtest.findings import find
from reachtest.records import Fall, GateSettings, Origin, Pocket
from tests.levels import FLOOR, level
from tests.unit.findings.test_detect import Paths, exploration

LEVEL = replace(level(FLOOR), gate=GateSettings(("stuck",)))
ARRIVAL = Fall(Origin(-1, 3, 0, 0, 9), np.array([2.0, 2, -3]), np.array([2.1, 2, -3]), np.full(3, np.nan))
PIT = Pocket(
    cells=np.array([[2.0, 2, -3], [3.0, 2, -3]]),
    points=np.array([1]),
    arrival=ARRIVAL,
    stuck=True,
    attempts=300,
    sim_time_s=300 * 4.0,
    volume_m3=8.0,
    reach_m=2.25,
)
POINTS = [([0, 0, 0], None, True), ([2, 2, -3], None, True)]


def test_a_pocket_is_one_finding_with_its_evidence() -> None:
    (finding,) = find(LEVEL, exploration(POINTS, pockets=(PIT,)), Paths())
    assert (finding.kind, finding.severity, finding.gating) == ("stuck", "error", True)
    assert finding.position.tolist() == [2, 2, -3]
    assert finding.points == 2
    assert finding.path is not None
    assert finding.standing.tolist() == [[2, 2, -3], [3, 2, -3], [2, 2, -3]]  # its cells and its cached point
    text = " ".join(finding.details)
    for fact in ("300 directed attempts", "20 min 0 s", "2.2 m", "8 m3"):
        assert fact in text


def test_no_way_back_is_a_warning_and_does_not_gate_by_default() -> None:
    region = replace(PIT, stuck=False)
    (finding,) = find(LEVEL, exploration(POINTS, pockets=(region,)), Paths())
    assert (finding.kind, finding.severity, finding.gating) == ("no_return", "warning", False)


def test_the_way_in_is_shown_where_no_point_was_cached() -> None:
    bare = replace(PIT, points=np.empty(0, dtype=np.int64))
    (finding,) = find(LEVEL, exploration(POINTS, pockets=(bare,)), Paths())
    assert finding.position.tolist() == [2.1, 2, -3]
    assert finding.path is not None


def test_a_region_off_the_navmesh_is_an_unexpected_area_and_not_said_twice() -> None:
    outside = [POINTS[0], ([30, 30, 0], [9, 9, 0], True)]
    found = find(LEVEL, exploration(outside, pockets=(replace(PIT, stuck=False),)), Paths())
    assert [f.kind for f in found] == ["unexpected_area"]
