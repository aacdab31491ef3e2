"""A configuration: how to explore and what fails a run, for any level."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import yaml

from reachtest.errors import BadInput
from reachtest.levels import load_level
from tests.unit.levels.make import WriteLevel, problems_of

CONFIGS = sorted((Path(__file__).resolve().parents[3] / "configs").glob("*.yaml"))


def config(folder: Path, content: Any) -> Path:
    file = folder / "nightly.yaml"
    file.write_text(yaml.safe_dump(content))
    return file


def mistakes(level: Path, file: Path, overrides: dict[str, Any] | None = None) -> list[tuple[str, str, str]]:
    with pytest.raises(BadInput) as raised:
        load_level(level, overrides, file)
    assert raised.value.exit_status == 2
    return [(problem.where, problem.found, problem.remedy) for problem in raised.value.problems]


def test_it_wins_over_the_level_and_the_command_line_over_both(
    write_level: WriteLevel, tmp_path: Path
) -> None:
    path = write_level(explore={"steps": 5, "agents": 3, "time_budget": "2h"}, gate={"fail_on": ["stuck"]})
    file = config(tmp_path, {"explore": {"steps": 7, "time_budget_s": 60}, "gate": None})
    level = load_level(path, {"explore": {"steps": 9}}, file)
    assert (level.explore.steps, level.explore.agents, level.explore.time_budget_s) == (9, 3, 60)
    assert level.gate.fail_on == ("stuck",)
    assert load_level(path, None, file).explore.steps == 7
    assert level.sha256 == load_level(path).sha256  # the level is the same: known bugs and replays hold


@pytest.mark.parametrize("file", CONFIGS, ids=lambda file: str(file.stem))
def test_the_ones_that_come_with_the_program_fit(write_level: WriteLevel, file: Path) -> None:
    level = load_level(write_level(explore={"steps": 5}, gate={"fail_on": ["stuck"]}), config=file)
    assert level.explore.steps == {"merge-gate": 200_000, "nightly": 3_000_000}[file.stem]
    assert set(level.gate.fail_on) & {"fell_out_of_world", "error"}


def test_there_are_some() -> None:
    assert len(CONFIGS) >= 2


def test_every_mistake_is_named_with_the_file_it_is_in(write_level: WriteLevel, tmp_path: Path) -> None:
    path = write_level(kill_z_m="low", explore={"agents": 0})
    file = config(tmp_path, {"geometry": [], "gat": {}, "explore": {"stepz": 5, "physics_hz": 3, "steps": 0}})
    found = mistakes(path, file, {"explore": {"steps": -1}})
    assert {where: what for where, what, _ in found[:4]} == {
        "level.yaml: kill_z_m": "found 'low'",
        "level.yaml: explore.agents": "found 0",
        "command line: explore.steps": "found -1",
        "nightly.yaml: explore.physics_hz": "found 3",
    }
    where, what, remedy = found[4]
    assert (where, what) == ("nightly.yaml: explore", "unknown key 'stepz'")
    assert remedy.startswith("did you mean 'steps'?")
    assert [each[:2] for each in found[5:]] == [
        ("nightly.yaml", "unknown key 'gat'"),
        ("nightly.yaml", "unknown key 'geometry'"),
    ]
    assert "did you mean 'gate'?" in found[5][2]
    assert "stands in the level file" in found[6][2]


@pytest.mark.parametrize("overrides", [None, {"explore": {"steps": 5}}])
def test_a_section_without_keys_is_not_hidden_by_what_comes_over_it(
    write_level: WriteLevel, tmp_path: Path, overrides: dict[str, Any] | None
) -> None:
    file = config(tmp_path, {"explore": 5})
    assert mistakes(write_level(), file, overrides)[0][:2] == ("nightly.yaml: explore", "found 5")
    assert problems_of(write_level(explore=5), overrides)[0][:2] == ("level.yaml: explore", "found 5")


def test_a_value_of_another_type_than_the_levels_is_judged(write_level: WriteLevel, tmp_path: Path) -> None:
    path = write_level(explore={"steps": 5}, gate={"fail_on": ["stuck"]})
    file = config(tmp_path, {"gate": {"fail_on": {"error": None}}, "explore": {"steps": {"a": 1}}})
    assert {where for where, _, _ in mistakes(path, file)} == {
        "nightly.yaml: explore.steps",
        "nightly.yaml: gate.fail_on",
    }


def test_who_says_what_goes_by_whole_keys(write_level: WriteLevel, tmp_path: Path) -> None:
    file = config(tmp_path, {"explore": {"steps": 7, "heuristics": {"visits": -1}, "effort": 3}})
    where = [each for each, _, _ in mistakes(write_level(explore={"steps_max": 5, "effort_x": 1}), file)]
    assert where == ["nightly.yaml: explore.heuristics", "level.yaml: explore", "level.yaml: explore"]
    both = config(tmp_path, {"explore": {"time_budget": 7, "time_budget_s": 7}})
    ((where_both, _, _),) = mistakes(write_level(), both)
    assert where_both == "level.yaml and nightly.yaml: explore"


def test_one_reset_heuristic_or_another_and_not_both(write_level: WriteLevel, tmp_path: Path) -> None:
    file = config(tmp_path, {"explore": {"heuristics": {"goals": 1.0}}})
    for explore in ({}, {"heuristics": {"visits": 1.0}}):
        assert load_level(write_level(explore=explore), config=file).explore.heuristics == {"goals": 1.0}


def test_the_command_line_goes_over_single_numbers_of_a_build(write_level: WriteLevel) -> None:
    path = write_level(navmesh={"build": {"cell_m": "wide", "climb_m": -1}})
    found = problems_of(path, {"navmesh": {"build": {"climb_m": -2}}})
    assert [each[:2] for each in found] == [
        ("level.yaml: navmesh.build.cell_m", "found 'wide'"),
        ("command line: navmesh.build.climb_m", "found -2"),
    ]
    ((where, what, _),) = problems_of(write_level(navmesh={"build": 5}), {"navmesh": {"build": {}}})
    assert (where, what) == ("level.yaml: navmesh.build", "found 5")


def test_what_belongs_to_one_level_is_refused(write_level: WriteLevel, tmp_path: Path) -> None:
    """A replay reads no configuration, and known bugs are one level's."""
    file = config(tmp_path, {"explore": {"expected_within_m": 1}, "gate": {"baseline": "known.yaml"}})
    assert [each[:2] for each in mistakes(write_level(), file)] == [
        ("nightly.yaml: explore.expected_within_m", "found 1"),
        ("nightly.yaml: gate.baseline", "found 'known.yaml'"),
    ]


@pytest.mark.parametrize(
    ("text", "found"),
    [("- 3\n", "not a mapping"), ("explore: [\n", "line 2"), ("gate: {}\ngate: {}\n", "twice")],
)
def test_a_file_that_is_no_configuration(
    write_level: WriteLevel, tmp_path: Path, text: str, found: str
) -> None:
    file = tmp_path / "nightly.yaml"
    file.write_text(text)
    ((where, what, _),) = mistakes(write_level(), file)
    assert where == "nightly.yaml"
    assert found in what
    ((_, _, remedy),) = mistakes(write_level(), tmp_path / "nihgtly.yaml")
    assert (
        remedy == "did you mean 'nightly.yaml'? give the path of a configuration's YAML file that can be read"
    )
