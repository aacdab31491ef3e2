"""Bugs are the same over seeds by their place, and planted ones are those of truth.yaml."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from reachtest.bench.stability import Stability, as_data, as_markdown, same_bugs
from reachtest.bench.truth import planted_bugs
from reachtest.records import Finding, Frame

Z_UP = Frame(np.eye(3), "z", "m")
Y_UP = Frame(np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]]), "y", "m")
TRUTH = """# The planted bugs of level.yaml, in its own axes and units.
version: 1
bugs:
- name: ramp
  kind: unexpected_area
  also: [fell_out_of_world]
  position: [9, 4, 49]
  bounds: {low: [0, 0, 44], high: [20, 6, 50]}
  radius_m: 2
"""


def finding(at: tuple[float, float, float], kind: str = "fell_out_of_world") -> Finding:
    place = np.array(at, dtype=float)
    return Finding(
        id=f"{kind}-{abs(hash(at))}", kind=kind, severity="error", gating=True, title="It falls",
        position=place, low=place, high=place, points=1, exit_point=place, nearest_named=None,
        first_seen_step=1, path=None, suppressed_by=None,
    )  # fmt: skip


def test_findings_of_different_seeds_at_one_place_are_one_bug() -> None:
    here, near, far = finding((0, 0, 0)), finding((1.5, 0, 0)), finding((40, 0, 0))
    bugs = same_bugs([[here], [far, near], [here]], Z_UP.to_source)
    assert [(bug.position, bug.seeds) for bug in bugs] == [((0, 0, 0), (0, 1, 2)), ((40, 0, 0), (1,))]


def test_different_kinds_at_one_place_are_two_bugs() -> None:
    bugs = same_bugs([[finding((0, 0, 0)), finding((0, 0, 0), "stuck")]], Z_UP.to_source)
    assert {bug.kind for bug in bugs} == {"stuck", "fell_out_of_world"}


def test_a_bug_split_in_two_counts_its_seed_once() -> None:
    whole = same_bugs([[finding((0, 0, 0))], [finding((1, 0, 0)), finding((-1, 0, 0))]], Z_UP.to_source)
    assert [bug.seeds for bug in whole] == [(0, 1)]


def test_seeds_that_fell_off_one_rim_at_different_places_agree_once_one_shows_that_it_is_one() -> None:
    left, right = finding((0, 0, 0)), finding((12, 0, 0))
    rim = dataclasses.replace(left, exits=np.array([[1.0, 0, 0], [6, 0, 0], [11, 0, 0]]))
    for seeds in ([left], [right], [rim]), ([rim], [left], [right]), ([left], [rim], [right]):
        assert [bug.seeds for bug in same_bugs(seeds, Z_UP.to_source)] == [(0, 1, 2)]
    assert len(same_bugs([[left], [right]], Z_UP.to_source)) == 2


def test_truth_is_read_in_the_levels_own_axes_and_for_its_own_file(tmp_path: Path) -> None:
    (tmp_path / "truth.yaml").write_text(TRUTH)
    (bug,) = planted_bugs(tmp_path / "level.yaml", Y_UP)
    at = Y_UP.to_level(np.array([10.0, 1.0, 46.0]))
    assert bug.is_told_by(finding(tuple(at)))
    assert bug.is_told_by(finding(tuple(at), "unexpected_area"))
    assert not bug.is_told_by(finding(tuple(at), "stuck"))
    assert not bug.is_told_by(finding(tuple(Y_UP.to_level(np.array([10.0, 1.0, 30.0])))))
    assert planted_bugs(tmp_path / "level-fixed.yaml", Y_UP) == ()
    assert planted_bugs(tmp_path / "nowhere" / "level.yaml", Y_UP) == ()


@pytest.mark.parametrize(("verdicts", "agreed"), [(("fail", "fail"), True), (("fail", "pass"), False)])
def test_the_table_says_how_many_seeds_agree(verdicts: tuple[str, ...], agreed: bool) -> None:
    bugs = same_bugs(
        [[finding((0, 0, 0)), finding((9, 9, 0), "stuck")], [finding((0, 0, 0))]], Z_UP.to_source
    )
    result = Stability("yard", 2, 1000, verdicts, bugs, {"ramp": (1,)}, 3.0)
    assert result.agreed == agreed == as_data([result])[0]["agreed"]
    row = as_markdown([result]).splitlines()[2]
    assert ("fail 2 of 2" if agreed else "fail 1 of 2, pass 1 of 2") in row
    assert "stuck 1" in row
    assert "| 1 of 2 |" in row
