"""Spawns, nav-mesh and sizes that cannot be meant."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from reachtest.errors import BadInput
from reachtest.levels import check_level, load_level
from tests.unit.levels.make import WriteLevel, only_problem, problems_of

FLOOR = {"name": "floor", "box": {"center": [0, 0, -0.5], "size": [20, 20, 1]}}
WALL = {"name": "wall", "box": {"center": [1.0, 0, 1.5], "size": [0.2, 8, 3]}}  # its face at x = 0.9


@pytest.mark.parametrize(
    ("spawn", "word"),
    [
        ([0, 0, 5], "is in the air: the next floor is 5.00 m below the feet"),
        ([0, 0, -0.7], "has a surface going through it, 0.70 m above the feet"),
        ([15, 0, 0], "is in the air: there is no floor below it at all"),
        ([300, 0, 0], "outside of the level's bounds"),
        ([0, 0, -30], "is below kill_z"),
    ],
)
def test_spawn_that_stands_nowhere(write_level: WriteLevel, spawn: list[float], word: str) -> None:
    problems = problems_of(write_level(spawns=[{"name": "gate", "position": spawn}]))
    assert all(where == "level.yaml: spawns[0]" for where, _, _ in problems)
    assert "'gate'" in problems[0][1]
    assert word in problems[0][1]


def test_remedy_gives_the_position_in_the_files_own_axes(write_level: WriteLevel) -> None:
    box = {"center": [0, -50, 0], "size": [2000, 100, 2000]}
    nav = {"mesh": "nav.obj", "up_axis": "z", "units": "m"}
    path = write_level(
        frame={"up_axis": "y", "units": "cm"}, geometry=[{"box": box}], navmesh=nav, spawns=[[100, 400, 200]]
    )
    _, found, remedy = only_problem(path)
    assert "(100, 400, 200)" in found
    assert "position: [100, 0, 200]" in remedy


@pytest.mark.parametrize(
    ("x", "deep"), [(0.5, False), (0.58, False), (0.7, True), (0.9, True), (1.42, False)]
)
def test_spawn_in_a_wall(write_level: WriteLevel, x: float, deep: bool) -> None:
    path = write_level(geometry=[FLOOR, WALL], spawns=[[x, 0, 0]])
    if not deep:
        load_level(path)
        return
    where, found, _ = only_problem(path)
    assert where == "level.yaml: spawns[0]"
    assert "deep in a wall" in found


def test_spawn_under_a_ceiling_that_is_too_low(write_level: WriteLevel) -> None:
    def under(height: float) -> Path:
        ceiling = {"box": {"center": [0, 0, height + 0.5], "size": [4, 4, 1]}}
        return write_level(geometry=[FLOOR, ceiling])

    load_level(under(1.8))
    assert "surface going through it, 1.50 m above" in only_problem(under(1.5))[1]


def test_spawn_on_the_steepest_slope_or_beside_a_step_is_fine(write_level: WriteLevel) -> None:
    ramp = {"ramp": {"from": [3, 0, 0], "to": [6, 0, 2.9], "width": 4}}
    step = {"box": {"center": [-5, 0, 0.2], "size": [2, 2, 0.4]}}
    spawns = [[4.5, 0, 1.45], [-3.9, 0, 0]]
    load_level(write_level(geometry=[FLOOR, ramp, step], spawns=spawns))


def test_spawn_inside_of_a_solid(write_level: WriteLevel) -> None:
    rock = {"name": "rock", "box": {"center": [0, 0, 1], "size": [6, 6, 4]}, "role": "solid"}
    assert "inside of the solid 'rock'" in only_problem(write_level(geometry=[FLOOR, rock]))[1]


def nav_level(write_level: WriteLevel, transform: Any, **keys: Any) -> Path:
    """The small level, its floor made unlike its own mirror image, with a nav-mesh moved by `transform`."""
    floors = [
        {"box": {"center": [6, 2, -0.5], "size": [12, 8, 1]}},
        {"box": {"center": [3, 9, 1], "size": [6, 6, 1]}},
    ]
    path = write_level(geometry=floors, spawns=[[6, 2, 0]], navmesh={"mesh": "moved.obj", **keys})
    corners = [
        (0, -2, 0),
        (12, -2, 0),
        (12, 6, 0),
        (0, 6, 0),
        (0, 6, 1.5),
        (6, 6, 1.5),
        (6, 12, 1.5),
        (0, 12, 1.5),
    ]
    lines = ["v {:.9g} {:.9g} {:.9g}".format(*transform(*corner)) for corner in corners]
    faces = ["f 1 2 3", "f 1 3 4", "f 5 6 7", "f 5 7 8"]
    (path.parent / "moved.obj").write_text("\n".join(lines + faces))
    return path


def test_navmesh_in_place(write_level: WriteLevel) -> None:
    check = check_level(load_level(nav_level(write_level, lambda x, y, z: (x, y, z))))
    assert dict(check.facts)["nav-mesh with a floor within 1 m"] == "100%"


@pytest.mark.parametrize(
    ("transform", "keys", "words"),
    [
        (lambda x, y, z: (100 * x, 100 * y, 100 * z), {}, ["centimetres (scale 0.01)", "navmesh.units: cm"]),
        (lambda x, y, z: (x, y, z), {"units": "cm"}, ["metres (scale 100)", "navmesh.units: m"]),
        (
            lambda x, y, z: (x / 0.0254, y / 0.0254, z / 0.0254),
            {},
            ["inches (scale 0.0254)", "navmesh.units: in"],
        ),
        (lambda x, y, z: (x, y, z), {"scale": 100}, ["metres", "navmesh.units: m", "navmesh.scale: 1"]),
        (lambda x, y, z: (x, z, -y), {}, ["y up", "navmesh.up_axis: y"]),
        (lambda x, y, z: (x, y, z), {"up_axis": "y"}, ["z up", "navmesh.up_axis: z"]),
        (lambda x, y, z: (-x, y, z), {}, ["mirrored x", "navmesh.flip_x: true"]),
        (
            lambda x, y, z: (-100 * x, 100 * z, -100 * y),
            {},
            ["navmesh.units: cm", "navmesh.up_axis: y", "navmesh.flip_x: true"],
        ),
    ],
    ids=["cm", "not cm", "inches", "scale", "y up", "z up", "mirrored", "all three"],
)
def test_navmesh_elsewhere_names_the_slip(
    write_level: WriteLevel, transform: Any, keys: dict[str, Any], words: list[str]
) -> None:
    where, found, remedy = only_problem(nav_level(write_level, transform, **keys))
    assert where == "level.yaml: navmesh"
    assert "moved.obj lies elsewhere than the geometry" in found or "moved.obj spans only" in found
    for word in words:
        assert word in remedy
    assert remedy.count("navmesh.") == sum("navmesh." in word for word in words)


def test_following_the_remedy_helps(write_level: WriteLevel) -> None:
    keys = {"units": "cm", "up_axis": "y", "flip_x": True}
    load_level(nav_level(write_level, lambda x, y, z: (-100 * x, 100 * z, -100 * y), **keys))


def test_navmesh_of_another_place_blames_no_unit(write_level: WriteLevel) -> None:
    _, found, remedy = only_problem(nav_level(write_level, lambda x, y, z: (x + 400, y, z)))
    assert "do not touch" in found
    assert "no slip of units or axes" in remedy
    assert "moved by about (-400, 0, 0) m" in remedy


def test_navmesh_of_another_level_is_not_said_to_be_moved(write_level: WriteLevel) -> None:
    _, _, remedy = only_problem(nav_level(write_level, lambda x, y, z: (x + 400, y, 4 * z + x + y)))
    assert "no slip of units or axes" in remedy
    assert "moved" not in remedy


@pytest.mark.parametrize("up_axis", ["y", "z"])
def test_y_and_z_exchanged_without_a_sign(write_level: WriteLevel, up_axis: str) -> None:
    path = nav_level(write_level, lambda x, y, z: (x, z, y), up_axis=up_axis)
    assert "y and z exchanged without a change of sign: export (x, y, z) as" in only_problem(path)[2]
    path = nav_level(write_level, lambda x, y, z: (100 * x, 100 * z, 100 * y), up_axis=up_axis)
    remedy = only_problem(path)[2]
    assert "exchanged" in remedy
    assert "navmesh.units: cm" in remedy


def test_navmesh_partly_off_the_geometry_is_a_warning(write_level: WriteLevel) -> None:
    check = check_level(load_level(nav_level(write_level, lambda x, y, z: (x + 3, y, z))))
    assert check.problems == ()
    assert "of its area has no floor" in check.warnings[0].found


@pytest.mark.parametrize(("x", "words"), [(300, "(300, 0, 0)"), (9e6, "(9e+06, 0, 0)"), (60, None)])
def test_a_thin_triangle_that_leads_far_away_is_named(
    write_level: WriteLevel, x: float, words: str | None
) -> None:
    path = nav_level(write_level, lambda x, y, z: (x, y, z))
    moved = path.parent / "moved.obj"
    moved.write_text(f"{moved.read_text()}\nv 1 0 0\nv {x} 0 0\nv 1 0.000003 0\nf 9 10 11\n")
    if x > 50_000:
        found = only_problem(path)[1]
    else:
        check = check_level(load_level(path))
        found = " ".join(warning.found for warning in check.warnings)
    if words is None:
        assert found == ""
    else:
        assert "1 of 5 triangles lie outside of the geometry's box" in found
        assert words in found


def test_tiny_level_proposes_its_unit(write_level: WriteLevel) -> None:
    small = {"box": {"center": [0, 0, -0.5], "size": [40, 30, 1]}}
    who = {"preset": "unreal", "radius_m": 0.05, "height_m": 0.1, "walk_speed_mps": 1, "jump_speed_mps": 1}
    path = write_level(
        frame={"units": "cm"},
        geometry=[small],
        navmesh={"mesh": "nav.obj"},
        character=who,
        spawns=[[0, 0, 0]],
    )
    warning = check_level(load_level(path)).warnings[0]
    assert "spans 0.4 x 0.3 x 0.01 m" in warning.found
    assert "units: m" in warning.remedy


def test_huge_level_proposes_its_unit(write_level: WriteLevel) -> None:
    path = write_level(
        geometry=[{"box": {"center": [0, 0, -500], "size": [60_000, 60_000, 1000]}}],
        navmesh={"mesh": "nav.obj", "units": 1000},
    )
    warning = check_level(load_level(path)).warnings[0]
    assert "60 m" in warning.remedy or "600 m" in warning.remedy


def test_character_as_tall_as_the_level(write_level: WriteLevel) -> None:
    path = write_level(character={"preset": "unreal", "height_m": 15})
    assert "the character is 15 m tall" in check_level(load_level(path)).warnings[0].found


def test_required_place_out_of_bounds_is_a_warning(write_level: WriteLevel) -> None:
    path = write_level(required=[{"name": "flag", "position": [0, 0, 900]}])
    assert [warning.where for warning in check_level(load_level(path)).warnings] == [
        "level.yaml: required[0]"
    ]


@pytest.mark.parametrize(
    "item", [{**FLOOR, "role": "solid"}, {"box": {"center": [0, 0, 0], "size": [1e-9, 1e-9, 1e-9]}}]
)
def test_level_without_collision(write_level: WriteLevel, item: dict[str, Any]) -> None:
    where, found, _ = only_problem(write_level(geometry=[item]))
    assert (where, found) == ("level.yaml: geometry", "has no collision surface")


def test_a_character_too_fast_for_the_physics_is_refused_with_the_rate_it_needs(
    write_level: WriteLevel,
) -> None:
    path = write_level(character={"preset": "unreal", "walk_speed_mps": 20})
    with pytest.raises(BadInput, match="at least 59") as caught:
        load_level(path)
    assert caught.value.problems[0].where == "level.yaml: explore.physics_hz"
    path = write_level(character={"preset": "unreal", "walk_speed_mps": 20}, explore={"physics_hz": 60})
    assert load_level(path).character.walk_speed_mps == 20


def test_a_spawn_in_a_forbidden_zone_fails_every_run(write_level: WriteLevel) -> None:
    zone = {"name": "vault", "kind": "forbidden", "box": {"center": [0, 0, 1], "size": [4, 4, 2]}}
    _, found, _ = only_problem(write_level(geometry=[FLOOR], spawns=[[0, 0, 0]], zones=[zone]))
    assert "is in the forbidden zone 'vault', so that every run fails" in found
    load_level(write_level(geometry=[FLOOR], spawns=[[0, 0, 0]], zones=[zone | {"kind": "allowed_off_mesh"}]))


def test_a_required_point_in_a_solid_is_doubtful(write_level: WriteLevel) -> None:
    crate = {"name": "crate", "role": "both", "box": {"center": [4, 0, 1], "size": [2, 2, 2]}}
    flag = {"name": "flag", "position": [4, 0, 0.2]}
    path = write_level(geometry=[FLOOR, crate], spawns=[[0, 0, 0]], required=[flag])
    warnings = [str(warning) for warning in check_level(load_level(path)).warnings]
    assert any("required[0]" in w and "'flag' lies inside of solid 'crate'" in w for w in warnings)
