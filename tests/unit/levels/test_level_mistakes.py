"""Mistakes in `level.yaml` itself, one by one and all at once."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from tests.unit.levels.make import WriteLevel, document, only_problem, problems_of


def test_yaml_syntax_error_names_line_and_column(tmp_path: Path) -> None:
    path = tmp_path / "level.yaml"
    path.write_text("version: 1\ngeometry: [\n  {mesh: a.glb\nspawns: }\n")
    where, found, _ = only_problem(path)
    assert where == "level.yaml"
    assert "line 4, column" in found


def test_missing_level_file_proposes_the_near_one(tmp_path: Path) -> None:
    (tmp_path / "level.yaml").write_text("version: 1")
    where, found, remedy = only_problem(tmp_path / "levle.yaml")
    assert where.endswith("levle.yaml")
    assert "No such file" in found
    assert "level.yaml" in remedy


def test_key_twice(tmp_path: Path) -> None:
    path = tmp_path / "level.yaml"
    path.write_text("version: 1\nname: a\nname: b\n")
    assert "'name' stands twice" in only_problem(path)[1]


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("zones: " + "[" * 3000, "nested too deep"),
        ("? [a, b]\n: 1\n", "unhashable key"),
        ("name: 2030-02-31\n", "out of range"),
    ],
)
def test_yaml_that_cannot_be_built_is_told(tmp_path: Path, text: str, told: str) -> None:
    path = tmp_path / "level.yaml"
    path.write_text(f"version: 1\n{text}")
    where, found, _ = only_problem(path)
    assert where == "level.yaml"
    assert told in found


@pytest.mark.parametrize("text", ["", "- 1\n", "just words"])
def test_not_a_mapping(tmp_path: Path, text: str) -> None:
    path = tmp_path / "level.yaml"
    path.write_text(text)
    assert "not a mapping" in only_problem(path)[1]


# (changes, where, word in found, word in remedy)
CASES: list[tuple[dict[str, Any], str, str, str]] = [
    ({"version": 2}, "version", "2", "1"),
    ({"spawn": [[0, 0, 0]]}, "", "unknown key 'spawn'", "did you mean 'spawns'?"),
    ({"name": "a/b"}, "name", "a/b", "pattern"),
    ({"geometry": []}, "geometry", "[]", "at least 1 item"),
    ({"geometry": [{"role": "both"}]}, "geometry[0]", "both", "exactly one of mesh, box, ramp, cylinder"),
    (
        {"geometry": [{"box": {"center": [0, 0, 0], "size": [1, 0, 1]}}]},
        "geometry[0].box.size[1]",
        "0",
        "greater than 0",
    ),
    (
        {"geometry": [{"box": {"centre": [0, 0, 0], "size": [1, 1, 1]}}]},
        "geometry[0].box",
        "'centre'",
        "'center'",
    ),
    (
        {"geometry": [{"units": "cm", "box": {"center": [0, 0, 0], "size": [1, 1, 1]}}]},
        "geometry[0]",
        "cm",
        "units can only go with 'mesh'",
    ),
    ({"frame": {"up_axis": "x"}}, "frame.up_axis", "'x'", "valid: z, y"),
    ({"frame": {"units": "metres"}}, "frame.units", "'metres'", "m, cm, mm, in, ft"),
    ({"navmesh": {"mesh": "nav.obj", "scale": -1}}, "navmesh.scale", "-1", "greater than 0"),
    ({"character": "unrael"}, "character.preset", "'unrael'", "did you mean 'unreal'?"),
    ({"character": {"radius_m": 0.3}}, "character", "0.3", "height_m, walk_speed_mps"),
    ({"character": {"preset": "unreal", "height_m": 0.5}}, "character", "0.5", "twice its radius_m"),
    (
        {"character": {"preset": "unreal", "slope_limit_deg": 95}},
        "character.slope_limit_deg",
        "95",
        "less than or equal to 89",
    ),
    ({"spawns": [[0, 0]]}, "spawns[0].position[2]", "missing", "feet"),
    ({"spawns": [[0, 0, float("nan")]]}, "spawns[0].position[2]", "nan", "finite number"),
    ({"spawns": []}, "spawns", "[]", "at least 1 item"),
    ({"bounds_m": {"low": [0, 0, 0], "high": [1, -1, 1]}}, "bounds_m", "-1", "low must be below high"),
    (
        {"zones": [{"name": "z", "kind": "forbiden", "box": {"center": [0, 0, 0], "size": [1, 1, 1]}}]},
        "zones[0].kind",
        "'forbiden'",
        "did you mean 'forbidden'?",
    ),
    ({"explore": {"heuristics": {"visits": 0}}}, "explore.heuristics", "0", "not all of them 0"),
    ({"explore": {"heuristics": {"visits": -1}}}, "explore.heuristics", "-1", "between 0 and"),
    ({"explore": {"steps": 0}}, "explore.steps", "0", "greater than or equal to 1"),
    ({"explore": {"step": 9}}, "explore", "unknown key 'step'", "did you mean 'steps'?"),
    ({"explore": {"time_budget": "soon"}}, "explore.time_budget", "'soon'", "30m"),
    ({"explore": {"reset_interval": 40_000}}, "explore.reset_interval", "40000", "32767"),
    ({"gate": {"fail_on": ["unexpected"]}}, "gate.fail_on[0]", "'unexpected'", "unexpected_area"),
    ({"gate": {"min_goals_reached": 2}}, "gate.min_goals_reached", "2", "less than or equal to 1"),
]


@pytest.mark.parametrize(("changes", "where", "found", "remedy"), CASES, ids=lambda value: str(value)[:40])
def test_schema_mistake(
    write_level: WriteLevel, changes: dict[str, Any], where: str, found: str, remedy: str
) -> None:
    problem = only_problem(write_level(**changes))
    assert problem[0] == f"level.yaml: {where}".removesuffix(": ")
    assert found in problem[1]
    assert remedy in problem[2]


@pytest.mark.parametrize("key", ["version", "geometry", "navmesh", "character", "spawns"])
def test_missing_key_says_what_it_is_for(tmp_path: Path, key: str) -> None:
    import yaml

    path = tmp_path / "level.yaml"
    (tmp_path / "nav.obj").write_text("")
    path.write_text(yaml.safe_dump({name: value for name, value in document().items() if name != key}))
    where, found, remedy = only_problem(path)
    assert (where, found) == (f"level.yaml: {key}", "is missing")
    assert len(remedy) > 10


def test_bad_option_is_laid_to_the_command_line(write_level: WriteLevel) -> None:
    where, found, _ = only_problem(write_level(), {"explore": {"steps": -5}})
    assert where == "command line: explore.steps"
    assert "-5" in found


def test_all_mistakes_come_at_once(write_level: WriteLevel) -> None:
    path = write_level(
        geometry=[{"mesh": "geometry/level.glb", "rol": "both"}, {"mesh": "level.fbx"}],
        navmesh={"mesh": "nov.obj"},
        character="unrael",
        explore={"agents": 0},
    )
    problems = problems_of(path)
    assert {where for where, _, _ in problems} == {
        "level.yaml: geometry[0]",
        "level.yaml: geometry[0].mesh",
        "level.yaml: geometry[1].mesh",
        "level.yaml: navmesh.mesh",
        "level.yaml: character.preset",
        "level.yaml: explore.agents",
    }
    assert any("nav.obj" in remedy for _, _, remedy in problems)


def test_geometry_mistakes_come_at_once_too(write_level: WriteLevel) -> None:
    floor = document()["geometry"][0]
    path = write_level(
        geometry=[floor, {"mesh": "gone.stl", "role": "solid"}, {"mesh": "nav.obj", "role": "solid"}],
        navmesh={"mesh": "gone.glb"},
        spawns=[[0, 0, 30], [500, 0, 0]],
    )
    wheres = [where for where, _, _ in problems_of(path)]
    assert wheres == [
        "level.yaml: geometry[1].mesh",
        "level.yaml: geometry[2]",
        "level.yaml: navmesh.mesh",
        "level.yaml: spawns[0]",
        "level.yaml: spawns[1]",
    ]
