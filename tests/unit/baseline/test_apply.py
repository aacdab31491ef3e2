"""Known bugs do not gate, expired ones do again, and what is gone is named."""

from __future__ import annotations

from datetime import date

import numpy as np

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
    }
    return Entry.model_validate(values | changes)


FOUND = (make_finding(),)


def applied(*entries, today=TODAY, findings=FOUND, enough=True):
    marked, outcome = apply_baseline(Baseline("known.yaml", entries), findings, today)
    return marked, outcome.section(enough)


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
    _, sure = applied(entry(), findings=())
    _, unsure = applied(entry(), findings=(), enough=False)
    assert [e["id"] for e in sure["fixed"]] == [e["id"] for e in unsure["not_seen"]] == [entry().id]
    assert sure["not_seen"] == unsure["fixed"] == []


def test_a_place_that_was_reached_is_fixed_in_any_run() -> None:
    _, section = applied(entry(kind="required_unreached"), findings=(), enough=False)
    assert len(section["fixed"]) == 1


def test_what_gates_still_comes_first() -> None:
    far = make_finding(id="far", exit_point=np.array([50.0, 0, 0]))
    marked, _ = applied(entry(), findings=(make_finding(), far))
    assert [f.id for f in marked] == ["far", make_finding().id]


def test_the_section_depends_on_the_date_it_names_and_on_nothing_else() -> None:
    assert applied(entry())[1] == applied(entry())[1]
    assert applied(entry())[1]["date"] == "2030-05-01"
