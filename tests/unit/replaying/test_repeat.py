"""A finding is simulated again on the level as it is now: what is there still is told from what is gone."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from reachtest.confirm.confirmer import Confirmer
from reachtest.records import Level, Spawn
from reachtest.replaying.keep import write_state
from reachtest.replaying.repeat import Repeated, repeat
from reachtest.replaying.state import read_state
from reachtest.surface import SurfaceIndex
from reachtest.world import MujocoSimulator
from tests.levels import EAST, STILL, box, level
from tests.unit.confirm.test_confirm import NAV, SETTINGS, found
from tests.unit.replaying.test_state import LEVEL_TEXT

GROUND = [
    box([-6, -6, -4], [2, 6, 0]),
    box([4, -6, -4], [9, 6, 0]),
    box([2, -6, -4], [4, -1, 0]),
    box([2, 1, -4], [4, 6, 0]),
]


def pit(depth: float) -> Level:
    """A platform with a pit of 2 m by 2 m east of its spawn."""
    bottom = [box([2, -1, -4], [4, 1, -depth])]
    return level(*GROUND, *bottom, explore=SETTINGS, kill_z_m=-12.0, spawn=(0, 0, 0.02), navmesh=NAV)


@pytest.fixture(scope="module")
def state(tmp_path_factory):
    """What a run keeps of who walked into the pit, and its path."""
    folder = tmp_path_factory.mktemp("out")
    (folder / "hall.yaml").write_text(LEVEL_TEXT)
    where = replace(pit(3.0), file=folder / "hall.yaml")
    simulator = MujocoSimulator(where, where.explore.lanes, 1)
    finding = found(where, simulator, [(EAST, 12), (STILL, 8)], "stuck")
    standing = np.array([[x, y, -3.0] for x in (2.4, 3.0, 3.6) for y in (-0.6, 0.0, 0.6)])
    finding = replace(finding, standing=standing, high=np.array([3.6, 0.6, 0.0]))  # a box up to the rim
    surface = SurfaceIndex(where.navmesh.triangles, 3.0)
    confirmer = Confirmer(where, simulator, surface, 0, lambda finer, n: MujocoSimulator(finer, n, 1))
    (finding,) = confirmer.confirm([finding])
    write_state(folder, where, [finding], confirmer.judge, "mujoco")
    return read_state(folder)


def again(state, where: Level, changed: bool = True) -> Repeated:
    (result,) = repeat(where, state, state.kept.findings, changed)
    return result


def test_the_way_into_a_pit_ends_in_it(state) -> None:
    result = again(state, pit(3.0), changed=False)
    assert result.passed
    assert result.note == "bit for bit"
    assert result.positions[-1][2] < -2.5
    assert 2 < result.positions[-1][0] < 4


def test_a_pit_is_still_there_until_it_is_filled(state) -> None:
    assert again(state, pit(3.0)).passed
    gone = again(state, pit(0.0))
    assert not gone.passed
    assert gone.note == "not there any more: 0 of 33 attempts"


def test_what_leads_into_a_changed_pit_does_not_tell_whether_one_gets_out(state) -> None:
    assert "told by a run" in again(state, pit(3.0)).note
    assert "told by a run" not in again(state, pit(3.0), changed=False).note


@pytest.mark.parametrize("older", [True, False])
def test_what_has_no_path_or_no_places_is_neither_there_nor_gone(state, older) -> None:
    """Before places were kept, any footing beside a pocket showed it."""
    (recording,) = state.recordings.values()
    id_ = state.kept.findings[0].id
    without = replace(state, recordings={id_: replace(recording, standing=None)} if older else {})
    result = again(without, replace(pit(0.0), file=Path("hall.yaml")))
    assert result.passed is None
    assert result.positions is None
    assert "reachtest run hall.yaml" in result.note


def test_a_path_from_where_nobody_starts_any_more_says_so(state) -> None:
    moved = replace(pit(3.0), spawns=(Spawn("start", np.array([-2.0, 0, 0.02])),))
    assert "its start is no spawn of the level any more" in again(state, moved).note
    assert "spawn" not in again(state, pit(3.0)).note
