"""A correct level: what comes out of `load_level`."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest
import trimesh

from reachtest.levels import PRESETS, check_level, json_schema, load_level
from reachtest.records import ExploreSettings
from tests.unit.levels.make import WriteLevel


def test_small_level_has_everything_in_place(write_level: WriteLevel) -> None:
    level = load_level(write_level())
    assert level.name == "small"
    assert level.collision.shape == (12, 3, 3)
    assert level.solids == ()
    assert [part.name for part in level.parts] == ["floor"]
    assert level.navmesh.triangles.shape == (2, 3, 3)
    assert level.character == PRESETS["unreal"]
    assert level.spawns[0].name == "spawn 0"
    assert level.explore == ExploreSettings()
    assert level.gate.fail_on == (
        "unexpected_area",
        "fell_out_of_world",
        "inside_solid",
        "forbidden_zone",
        "stuck",
        "required_unreached",
        "unreached_area",
    )


def test_default_limits_follow_the_geometry(write_level: WriteLevel) -> None:
    level = load_level(write_level())
    assert level.kill_z_m == pytest.approx(-11)
    np.testing.assert_allclose(level.bounds, [[-60, -60, -11], [60, 60, 50]])


def test_stated_limits_are_level_axes_in_metres_whatever_the_frame(write_level: WriteLevel) -> None:
    box = {"center": [0, -50, 0], "size": [2000, 100, 2000]}
    path = write_level(
        frame={"up_axis": "y", "units": "cm"},
        geometry=[{"box": box}],
        navmesh={"mesh": "nav.obj", "up_axis": "z", "units": "m"},
        kill_z_m=-5,
        bounds_m={"low": [-20, -20, -5], "high": [20, 20, 9]},
        zones=[{"name": "z", "kind": "forbidden", "box": {"center": [0, 100, 300], "size": [20, 40, 60]}}],
        required=[{"name": "r", "position": [100, 0, 200]}],
    )
    level = load_level(path)
    assert level.kill_z_m == -5
    np.testing.assert_allclose(level.bounds, [[-20, -20, -5], [20, 20, 9]])
    np.testing.assert_allclose(level.collision.min(axis=(0, 1)), [-10, -10, -1])
    np.testing.assert_allclose(
        [level.zones[0].low, level.zones[0].high], [[-0.1, -3.3, 0.8], [0.1, -2.7, 1.2]]
    )
    np.testing.assert_allclose(level.required[0].position, [1, -2, 0])
    assert level.required[0].within_m == 1.0
    np.testing.assert_allclose(level.frame.to_source(level.required[0].position), [100, 0, 200])


def test_command_line_wins_over_the_file(write_level: WriteLevel) -> None:
    path = write_level(explore={"steps": 5, "agents": 3, "time_budget": "2h"}, gate={"fail_on": ["stuck"]})
    overrides = {"explore": {"steps": 1000, "time_budget_s": 7.5}, "gate": {"fail_on": ["unexpected_area"]}}
    level = load_level(path, overrides)
    assert (level.explore.steps, level.explore.agents, level.explore.time_budget_s) == (1000, 3, 7.5)
    assert level.gate.fail_on == ("unexpected_area",)


@pytest.mark.parametrize(("text", "seconds"), [(90, 90), ("90", 90), ("90s", 90), ("1.5m", 90), ("2h", 7200)])
def test_time_budget_units(write_level: WriteLevel, text: object, seconds: float) -> None:
    assert load_level(write_level(explore={"time_budget": text})).explore.time_budget_s == seconds


def test_character_numbers_go_over_the_preset(write_level: WriteLevel) -> None:
    level = load_level(write_level(character={"preset": "godot", "walk_speed_mps": 9.5}))
    assert level.character == dataclasses.replace(PRESETS["godot"], walk_speed_mps=9.5)


def test_presets_jump_as_high_as_their_engines_say() -> None:
    apex = {name: who.jump_speed_mps**2 / (2 * who.gravity_mps2) for name, who in PRESETS.items()}
    assert apex["unreal"] == pytest.approx(0.90, abs=0.005)
    assert apex["unity"] == pytest.approx(1.2)
    assert apex["godot"] == pytest.approx(1.03, abs=0.01)
    assert apex["quake3"] == pytest.approx(270**2 / 1600 * 0.0254, abs=0.01)


def test_digest_follows_the_level_and_every_file_it_names(write_level: WriteLevel, tmp_path: Path) -> None:
    path = write_level()
    first = load_level(path).sha256
    assert load_level(path).sha256 == first
    nav = tmp_path / "small" / "nav.obj"
    nav.write_text(nav.read_text() + "# again\n")
    second = load_level(path).sha256
    assert len({first, second, load_level(write_level(kill_z_m=-77)).sha256}) == 3


def test_the_level_is_the_same_whatever_fails_a_build_and_however_long_it_is_explored(
    write_level: WriteLevel,
) -> None:
    path = write_level()
    first = load_level(path).sha256
    path.write_text("# a remark\n" + path.read_text())
    assert load_level(path, {"explore": {"steps": 77}}).sha256 == first
    changed = write_level(gate={"fail_on": ["stuck"]}, explore={"steps": 55})
    assert load_level(changed).sha256 == first


def test_solids_are_apart_from_collision(write_level: WriteLevel) -> None:
    def box(x: float) -> dict[str, list[float]]:
        return {"center": [x, 5, 1], "size": [1, 1, 2]}

    geometry = [
        {"name": "floor", "box": {"center": [0, 0, -0.5], "size": [20, 20, 1]}},
        {"name": "ghost", "box": box(0), "role": "solid"},
        {"name": "crate", "box": box(4), "role": "both"},
    ]
    level = load_level(write_level(geometry=geometry))
    assert len(level.collision) == 24
    assert [solid.name for solid in level.solids] == ["ghost", "crate"]
    assert [part.name for part in level.parts] == ["floor", "ghost", "crate"]


def test_a_solid_from_a_file_is_called_what_the_level_calls_it(write_level: WriteLevel, tmp_path) -> None:
    """Not after the node in the file, which an export names anew."""
    path = write_level()
    trimesh.creation.box([1, 1, 1]).export(path.parent / "well.glb")
    floor = {"name": "floor", "box": {"center": [0, 0, -0.5], "size": [20, 20, 1]}}
    level = load_level(write_level(geometry=[floor, {"name": "ring", "mesh": "well.glb", "role": "solid"}]))
    assert [solid.name for solid in level.solids] == ["ring"]
    assert [part.name for part in level.parts] == ["floor", "ring"]


def test_facts_say_how_the_level_was_understood(write_level: WriteLevel) -> None:
    check = check_level(load_level(write_level()))
    facts = dict(check.facts)
    assert (check.problems, check.warnings) == ((), ())
    assert facts["collision"] == "12 triangles"
    assert facts["extents"].startswith("20 x 20 x 1 m")
    assert facts["nav-mesh"] == "2 triangles, 324 m2"
    assert facts["axes and units"] == "z up, m"
    assert "(0, 0, 0)" in facts["spawns"]


def test_json_schema_describes_every_key() -> None:
    schema = json_schema()
    models = [schema, *schema["$defs"].values()]
    objects = [
        inner for model in models for inner in [model, *model.get("anyOf", [])] if "properties" in inner
    ]
    assert len(objects) >= 12
    for model in objects:
        for key, value in model["properties"].items():
            model_text = schema["$defs"].get(value.get("$ref", "").rsplit("/", 1)[-1], {})
            assert value.get("description") or model_text.get("description"), key
    kinds = str(schema)
    for word in ("unreal", "unexpected_area", "cylinder", "additionalProperties"):
        assert word in kinds


def test_capsule_that_fits_the_defaults() -> None:
    for who in PRESETS.values():
        assert who.height_m >= 2 * who.radius_m
        assert math.isfinite(who.terminal_speed_mps)


@pytest.mark.parametrize(
    ("explore", "lanes"),
    [
        ({"steps": 999_999}, 128),
        ({"steps": 1_000_000}, 256),
        ({"steps": 1_000_000, "episodes_at_once": 3}, 48),
    ],
)
def test_long_runs_simulate_more_episodes_side_by_side(
    write_level: WriteLevel, explore: dict[str, int], lanes: int
) -> None:
    assert load_level(write_level(explore=explore)).explore.lanes == lanes
