"""What changed in a level is said by the names a designer gave it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from reachtest.records import Level, NavMesh, Part, Solid, Spawn, Zone
from reachtest.replaying.sections import MOST, differences, digests_of, values_of
from tests.levels import FLOOR, box, level

CRATE = Part("crate", np.array([2.0, 2, 0]), np.array([3.0, 3, 1]))
BASE = replace(
    level(FLOOR, box([2, 2, 0], [3, 3, 1])),
    parts=(CRATE,),
    solids=(Solid("pillar", box([5, 5, 0], [6, 6, 3])),),
    spawns=(Spawn("start", np.array([0.0, 0, 0.02])),),
    zones=(Zone("vault", "forbidden", np.zeros(3), np.ones(3)),),
)
LIFTED = BASE.collision + np.array([0, 0, 0.1])
NAV = NavMesh("nav.obj", BASE.navmesh.vertices + 0.1, BASE.navmesh.faces)


def told(now: Level, before: Level = BASE) -> list[str]:
    return differences(now, values_of(before), digests_of(before))


@pytest.mark.parametrize(
    ("changed", "lines"),
    [
        ({}, []),
        ({"character": replace(BASE.character, radius_m=0.5)}, ["character.radius_m is 0.5, it was 0.34"]),
        (
            {"explore": replace(BASE.explore, expected_within_m=2.0, threshold_m=2.0, steps=9)},
            ["explore.expected_within_m is 2.0, it was 3.0"],
        ),
        ({"kill_z_m": -9.0}, ["kill_z_m is -9.0, it was -50.0"]),
        ({"spawns": (Spawn("start", np.array([1.0, 0, 0.02])),)}, ["spawn 'start' has changed"]),
        ({"spawns": (*BASE.spawns, Spawn("b", np.zeros(3)))}, ["spawn 'b' is new"]),
        ({"collision": LIFTED}, ["the collision geometry has changed"]),
        (
            {"collision": LIFTED, "parts": (replace(CRATE, high=np.ones(3)),)},
            ["geometry 'crate' has changed"],
        ),
        ({"parts": (CRATE, CRATE)}, ["geometry 'crate' has changed"]),
        ({"solids": ()}, ["solid 'pillar' is gone"]),
        ({"zones": (replace(BASE.zones[0], kind="allowed_off_mesh"),)}, ["zone 'vault' has changed"]),
        ({"navmesh": NAV}, ["the nav-mesh has changed"]),
        ({"navmesh": replace(BASE.navmesh, areas=np.ones(2, dtype=np.int64))}, ["the nav-mesh has changed"]),
    ],
)
def test_each_thing_that_changed_is_named(changed, lines) -> None:
    assert told(replace(BASE, **changed)) == lines


def test_one_more_than_a_screen_is_counted() -> None:
    many = tuple(replace(CRATE, name=f"crate {i}") for i in range(40))
    lines = told(replace(BASE, parts=many))
    assert len(lines) == MOST + 1
    assert lines[-1] == f"and {41 - MOST} more"  # and that 'crate' is gone


def test_names_that_json_cannot_hold_are_no_change() -> None:
    odd = replace(BASE, parts=(replace(CRATE, name="half \ud800"),))
    assert told(odd, odd) == []
    assert all(name.encode() for name in digests_of(odd))
