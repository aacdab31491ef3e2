"""`explore.stop_when_done`: an early end has to say at which risk."""

from __future__ import annotations

import pytest

from reachtest.errors import BadInput
from reachtest.levels import load_level
from tests.unit.levels.make import WriteLevel


def test_a_run_may_stop_early_at_a_stated_risk(write_level: WriteLevel) -> None:
    path = write_level(explore={"stop_when_done": True}, gate={"max_discovery_probability": 0.05})
    level = load_level(path)
    assert level.explore.stop_when_done
    assert level.gate.max_discovery_probability == 0.05


@pytest.mark.parametrize(
    ("gate", "found"),
    [
        ({}, "is not given"),
        ({"gate": {"min_goals_reached": 0.9}}, "found {'min_goals_reached': 0.9}"),
    ],
)
def test_without_a_risk_to_stop_at_it_is_refused(
    write_level: WriteLevel, gate: dict[str, object], found: str
) -> None:
    with pytest.raises(BadInput) as caught:
        load_level(write_level(explore={"stop_when_done": True}, **gate))
    [problem] = caught.value.problems
    assert (problem.where, problem.found) == ("level.yaml: gate", found)
    assert "max_discovery_probability" in str(problem)


def test_a_mistake_in_explore_is_told_once(write_level: WriteLevel) -> None:
    with pytest.raises(BadInput) as caught:
        load_level(write_level(explore={"stop_when_done": True, "agents": 0}))
    assert [problem.where for problem in caught.value.problems] == ["level.yaml: explore.agents"]
