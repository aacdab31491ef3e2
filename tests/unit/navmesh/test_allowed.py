"""`allowed_off_mesh`: a roof that is fine is no finding, and a way out of the world from it still is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from reachtest.explore import Explorer
from reachtest.findings import find
from reachtest.navmesh.allowed import expected_surface
from reachtest.records import Exploration, ExploreSettings, Level, Zone
from reachtest.world import MujocoSimulator
from tests.levels import box, level
from tests.unit.findings.test_detect import Paths

WALLS = [
    box([-8, -8, 0], [-7, 8, 4]),
    box([7, -8, 0], [8, 8, 4]),
    box([-8, -8, 0], [8, -7, 4]),
    box([-8, 7, 0], [-1.5, 8, 4]),
    box([1.5, 7, 0], [8, 8, 4]),
]
YARD = box([-8, -8, -1], [8, 8, 0])
NAVMESH = np.array([[[-6, -6, 0], [6, -6, 0], [6, 6, 0]], [[-6, -6, 0], [6, 6, 0], [-6, 6, 0]]], dtype=float)
TERRACE = box([-6, 8, -1], [6, 20, 0])  # through a gap in the wall, and no part of the nav-mesh
RAIL = [box([-7, 8, 0], [-6, 21, 4]), box([6, 8, 0], [7, 21, 4])]
CLOSED = box([-7, 20, 0], [7, 21, 4])
ZONE = Zone("terrace", "allowed_off_mesh", np.array([-6.0, 7.5, 0]), np.array([6.0, 20.5, 6]))


def explored(where: Level) -> Exploration:
    simulator = MujocoSimulator(where, where.explore.lanes, 2)
    return Explorer(where, simulator, expected_surface(where), seed=3).run()


def kinds(where: Level) -> list[tuple[str, float, float]]:
    """Kind, y of the finding and y of its exit."""
    found = find(where, explored(where), Paths())
    return [(f.kind, f.position[1], f.exit_point[1]) for f in found if f.kind in where.gate.fail_on]


@pytest.fixture(scope="module")
def terrace() -> Level:
    pieces = [YARD, *WALLS, TERRACE, *RAIL, CLOSED]
    return level(*pieces, navmesh=NAVMESH, explore=ExploreSettings(agents=4, steps=8_000), kill_z_m=-20)


def test_an_allowed_roof_is_no_finding(terrace) -> None:
    assert {kind for kind, *_ in kinds(terrace)} == {"unexpected_area"}
    assert kinds(replace(terrace, zones=(ZONE,))) == []


def test_a_way_out_of_the_world_from_it_is_told_at_its_edge() -> None:
    pieces = [YARD, *WALLS, TERRACE, *RAIL]
    where = level(*pieces, navmesh=NAVMESH, explore=ExploreSettings(agents=4, steps=8_000), kill_z_m=-20)
    ((kind, y, left),) = kinds(replace(where, zones=(ZONE,)))
    assert kind == "fell_out_of_world"
    assert y > 15
    assert left > 15  # not at the gap in the wall, where the way onto the terrace begins


def test_an_allowed_zone_is_expected_and_another_kind_is_not(terrace) -> None:
    here, beyond = np.array([[0, 15, -0.02], [0, 0, 0.0]]), np.array([[0, 25, 0.0], [0, 15, 7.0]])
    surface = expected_surface(replace(terrace, zones=(ZONE,)))
    assert surface.distance(here)[0] == 0
    assert np.isinf(surface.distance(beyond)).all()
    forbidden = replace(terrace, zones=(replace(ZONE, kind="forbidden"),))
    assert np.isinf(expected_surface(forbidden).distance(here)).tolist() == [True, False]
