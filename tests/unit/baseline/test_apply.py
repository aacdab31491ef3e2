"""Known bugs do not gate, expired ones do again, and what is gone is named."""

from __future__ import annotations

from datetime import date

import numpy as np
import pytest

from reachtest.baseline import Baseline, Entry, apply_baseline
from reachtest.findings import judge
from reachtest.records import GateSettings
from tests.unit.report.make import make_exploration, make_finding

TODAY = date(2030, 5, 1)


def entry(**changes) -> Entry:
    """Knows `make_finding()`."""
    values = {
        "id": "fell_out_of_world-11112222",
        "kind": "fell_out_of_world",
        "position": (4, 3, -10),
        "bounds": ((3, 2.5, -10), (5, 3.5, -9.9)),
        "exits": ((4, 1, 0),),
        "reason": "ticket 7",
        "author": "Mia",
        "added": date(2030, 1, 1),
        "level_sha256": "of the level before",
    }
    return Entry.model_validate(values | changes)


FOUND = (make_finding(),)


def applied(*entries, today=TODAY, findings=FOUND, enough=True, sha256="of the level now", risk=0.05):
    marked, outcome = apply_baseline(Baseline("known.yaml", entries), findings, today)
    return marked, outcome.section(sha256, enough, risk)


def test_a_known_bug_is_marked_and_does_not_gate() -> None:
    (finding,), section = applied(entry())
    assert (finding.gating, finding.suppressed_by) == (
        False,
        "baseline: fell_out_of_world-11112222 (ticket 7)",
    )
    assert section["known"][0]["finding"] == finding.id
    assert section["known"][0]["author"] == "Mia"
    explored = make_exploration(goal_step=np.array([0, 1, 2]))
    assert judge(GateSettings(("fell_out_of_world",)), explored, (finding,)).name == "pass"


def test_an_entry_counts_up_to_and_including_its_last_day() -> None:
    (last,), _ = applied(entry(expires=TODAY))
    (over,), section = applied(entry(expires=date(2030, 4, 30)))
    assert (last.gating, over.gating, over.suppressed_by) == (False, True, None)
    assert [(e["finding"], e["expires"]) for e in section["expired"]] == [(over.id, "2030-04-30")]
    assert section["known"] == section["fixed"] == []


def test_a_fresh_entry_goes_before_an_expired_one_for_the_same_bug() -> None:
    (finding,), section = applied(entry(expires=date(2030, 1, 2)), entry(id="again"))
    assert not finding.gating
    assert [e["id"] for e in section["known"]] == ["again"]
    assert section["expired"] == section["fixed"] == []


def test_gone_is_fixed_only_if_the_run_could_tell() -> None:
    _, section = applied(entry(), findings=())
    assert [e["id"] for e in section["fixed"]] == [entry().id]
    assert section["not_seen"] == []


@pytest.mark.parametrize(
    ("change", "run", "doubt"),
    [
        ({}, {"sha256": "of the level before"}, "still the same"),
        ({"level_sha256": None}, {}, "which version"),
        ({}, {"enough": False}, "too short"),
        ({}, {"risk": 0.06}, "new places"),
    ],
)
def test_gone_is_not_seen_where_the_run_could_not_tell_and_why_is_said(change, run, doubt) -> None:
    _, section = applied(entry(**change), findings=(), **run)
    (absent,) = section["not_seen"]
    assert absent["id"] == entry().id
    assert doubt in absent["doubt"]
    assert section["fixed"] == []


@pytest.mark.parametrize("kind", ["required_unreached", "unreached_area"])
def test_a_place_that_was_reached_is_fixed_in_any_run_of_a_changed_level(kind) -> None:
    unsure = {"findings": (), "enough": False, "risk": 1.0}
    assert len(applied(entry(kind=kind), **unsure)[1]["fixed"]) == 1
    assert not applied(entry(kind=kind, level_sha256="same"), sha256="same", **unsure)[1]["fixed"]


def test_an_area_of_which_a_far_corner_is_still_unreached_is_not_fixed() -> None:
    wide = entry(kind="unreached_area", bounds=((0, 0, 0), (60, 60, 0)), exits=())
    corner = make_finding(
        kind="unreached_area", low=np.array([59.0, 59, 0]), high=np.array([61.0, 61, 0]), exit_point=None
    )
    _, section = applied(wide, findings=(corner,), enough=False)
    assert (len(section["fixed"]), len(section["not_seen"])) == (0, 1)


def test_a_fall_where_standing_was_known_is_worse_and_gates() -> None:
    stood = entry(id="stood", kind="unexpected_area")
    (fall,), section = applied(stood)
    assert fall.gating
    assert [(e["id"], e["finding"]) for e in section["worse"]] == [("stood", fall.id)]
    assert section["fixed"] == section["not_seen"] == []
    _, both = applied(stood, entry())  # the fall was known as well
    assert (both["worse"], len(both["fixed"])) == ([], 1)
    far = make_finding(exit_point=np.array([50.0, 0, 0]))
    assert applied(stood, findings=(far,))[1]["worse"] == []


def test_what_gates_still_comes_first() -> None:
    far = make_finding(id="far", exit_point=np.array([50.0, 0, 0]))
    marked, _ = applied(entry(), findings=(make_finding(), far))
    assert [f.id for f in marked] == ["far", make_finding().id]


def test_the_section_depends_on_the_date_it_names_and_on_nothing_else() -> None:
    assert applied(entry())[1] == applied(entry())[1]
    assert applied(entry())[1]["date"] == "2030-05-01"
