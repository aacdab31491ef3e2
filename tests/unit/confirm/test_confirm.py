"""Confirmed, or not reported as a bug: what half the time step cannot show does not gate; ways get shorter."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from reachtest.confirm import retries
from reachtest.confirm.confirmer import Confirmer
from reachtest.confirm.shorten import pursuits
from reachtest.confirm.trials import Lane, run_lanes
from reachtest.confirm.variation import vary
from reachtest.records import ExploreSettings, Fall, Finding, Floats, Level, Origin, ReplayPath
from reachtest.surface import SurfaceIndex
from reachtest.world import MujocoSimulator
from tests.levels import EAST, NORTH, NORTH_EAST, STILL, UNREAL, WEST, box, level

PLATFORM = box([-6, -6, -1], [6, 6, 0])
NAV = np.array([[[-5, -5, 0], [2, -5, 0], [2, 5, 0]], [[-5, -5, 0], [2, 5, 0], [-5, 5, 0]]], dtype=float)
SETTINGS = ExploreSettings(agents=4, episodes_at_once=8)
FAST = replace(UNREAL, walk_speed_mps=18.0, acceleration_mps2=400.0, ground_friction=40.0)


def found(where: Level, simulator: MujocoSimulator, script: list[tuple[int, ...]], kind: str) -> Finding:
    """What a character finds that does as `script` says: (stick, for how many steps), and 1 to jump."""
    actions = np.array(
        [[stick, any(jump)] for stick, steps, *jump in script for _ in range(steps)], dtype=np.int8
    )
    state = simulator.place(where.spawns[0].position[None])[0]
    (trial,) = run_lanes(simulator, [Lane(state, actions, len(actions))])
    stood = trial.stood[np.isfinite(trial.stood[:, 0])]
    path = ReplayPath(
        start=state[:3],
        episodes=(),
        positions=trial.positions,
        duration_s=len(trial) * simulator.step_s,
        attempts=1,
        succeeded=1,
        state=state,
        actions=trial.actions,
        states=trial.states,
        stood=trial.stood,
    )
    return Finding(
        id="it",
        kind=kind,
        severity="error",
        gating=True,
        title="It",
        position=stood[-1],
        low=stood[-1],
        high=stood[-1],
        points=1,
        exit_point=None,
        nearest_named=None,
        first_seen_step=None,
        path=path,
        suppressed_by=None,
    )


def confirmed(where: Level, script: list[tuple[int, ...]], kind: str) -> tuple[Finding, Finding]:
    """The finding as it was found, and as it was confirmed."""
    simulator = MujocoSimulator(where, where.explore.lanes, 1)
    surface = SurfaceIndex(where.navmesh.triangles, where.explore.expected_within_m)
    finding = found(where, simulator, script, kind)
    confirmer = Confirmer(where, simulator, surface, 0, lambda finer, n: MujocoSimulator(finer, n, 1))
    (again,) = confirmer.confirm([finding])
    return finding, again


def platform(
    *more: Floats, character: object = UNREAL, spawn: tuple[float, float, float] = (0, 0, 0.02)
) -> Level:
    return level(
        PLATFORM, *more, character=character, explore=SETTINGS, kill_z_m=-12.0, spawn=spawn, navmesh=NAV
    )


def test_an_open_edge_is_confirmed_in_every_way() -> None:
    _, again = confirmed(platform(), [(EAST, 40)], "fell_out_of_world")
    assert again.confirmation is not None
    assert again.confirmation.exact == (2, 2)
    for attempts, succeeded in (again.confirmation.half_step, again.confirmation.nearby):
        assert attempts >= 16
        assert succeeded > attempts / 2
    assert again.gating
    assert not again.fragile


@pytest.fixture
def short_searches(monkeypatch) -> None:
    """In vain they are as long as they may be."""
    monkeypatch.setattr(retries, "LEAST_SEARCHED", 12_000)


@pytest.mark.usefixtures("short_searches")
@pytest.mark.parametrize("walled", [True, False])
def test_a_wall_that_only_the_coarse_step_passes_is_fragile(walled) -> None:
    """18 m/s is 0.6 m a tick at 30 Hz, nearly as much as a thin wall and the capsule measure together."""
    hall = [box([-20, -6, -1], [20, 6, 0]), box([-20, -7, 0], [20, -6, 9]), box([-20, 6, 0], [20, 7, 9])]
    hall += [box([3.0, -6, 0], [3.01, 6, 9])] if walled else []
    for x in np.arange(-1.0, 0.0, 0.05):
        where = level(*hall, character=FAST, explore=SETTINGS, spawn=(x, 0.0, 0.02), navmesh=NAV)
        simulator = MujocoSimulator(where, 1, 1)
        finding = found(where, simulator, [(EAST, 5), (STILL, 6)], "unexpected_area")
        if finding.position[0] > 6:
            break
    assert finding.position[0] > 6, "no start passes the wall"
    _, again = confirmed(where, [(EAST, 5), (STILL, 6)], "unexpected_area")
    assert again.confirmation is not None
    assert again.confirmation.exact == (2, 2)
    assert again.confirmation.half_step[0] >= 33
    assert (again.confirmation.half_step[1] == 0) == walled
    assert again.fragile == walled
    assert again.gating == (not walled)


@pytest.mark.usefixtures("short_searches")
@pytest.mark.parametrize("open_west", [True, False])
def test_what_half_the_step_shows_over_another_part_of_the_edge_is_not_fragile(open_west) -> None:
    """East of the wall only the coarse step gets; what one falls off in the west is an edge for everybody."""
    hall = [box([-20, -6, -1], [5, 6, 0]), box([3.0, -6, 0], [3.01, 6, 9])]
    hall += [box([-20, y - 1, 0], [5, y, 9]) for y in (-6, 7)]
    hall += [] if open_west else [box([-21, -7, -1], [-20, 7, 9])]
    east, west = [(EAST, 30)], [(WEST, 30)]
    for x in np.arange(-1.0, 0.0, 0.05):
        where = level(
            *hall, character=FAST, explore=SETTINGS, kill_z_m=-12.0, spawn=(x, 0.0, 0.02), navmesh=NAV
        )
        simulator = MujocoSimulator(where, where.explore.lanes, 1)
        finding = found(where, simulator, east, "fell_out_of_world")
        if finding.position[0] > 3.5:
            break
    assert finding.position[0] > 3.5, "no start passes the wall"
    other = found(where, simulator, west, "fell_out_of_world")
    assert other.path is not None
    left = np.array([-7.0, 0.0, 0.0])  # the last place near the nav-mesh
    fall = Fall(Origin(-1, 0, 0, 0, 30), other.path.positions[-1], other.position, left)
    surface = SurfaceIndex(where.navmesh.triangles, where.explore.expected_within_m)
    finer = partial(MujocoSimulator, threads=1)
    confirmer = Confirmer(where, simulator, surface, 0, finer, path_to=lambda fall: other.path)
    (again,) = confirmer.confirm([replace(finding, others=(fall,))])
    assert again.fragile != open_west
    assert again.gating == open_west
    assert np.allclose(again.position, other.position if open_west else finding.position)
    assert again.confirmation is not None
    assert again.confirmation.exact[0] == again.confirmation.exact[1]
    assert (
        again.confirmation.half_step[0] > 132
    ) != open_west  # its own edge in all ways; or the other's attempts


def test_a_leap_that_turned_as_it_took_off_is_no_doing_of_the_time_step() -> None:
    """Half the step turns half as far in the tick of the jump, and falls short from there, but not with a run-up."""
    script = [(NORTH_EAST, 8), (EAST, 1, 1), (EAST, 12)]
    for gap in np.arange(6.0, 2.0, -0.15):
        here, there = box([-6, -6, -1], [2.3, 6, 0]), box([2.3 + gap, -6, -1], [30, 40, 0])
        where = level(here, there, explore=SETTINGS, kill_z_m=-12.0, spawn=(-2, -5, 0.02), navmesh=NAV)
        simulator = MujocoSimulator(where, 1, 1)
        finding = found(where, simulator, script, "unexpected_area")
        if finding.position[0] > 2.3 + gap:
            break
    assert finding.position[0] > 2.3 + gap, "no gap is crossed"
    _, again = confirmed(where, script, "unexpected_area")
    assert again.confirmation.half_step[0] > 33  # not from the take-off
    assert again.confirmation.half_step[1] > 0
    assert not again.fragile


def test_a_row_of_pillars_that_takes_every_jump_right_is_no_doing_of_the_time_step() -> None:
    """Whoever has to begin at the first of them falls in between, at half the step: one has to go on from each."""
    script: list[tuple[int, ...]] = [(EAST, 6)]
    script += [(direction, 7, 1) for direction in (NORTH_EAST, EAST) * 2]
    first, around = box([-6, -6, -1], [2.3, 6, 0]), [0.3, 0.3, 0.0]
    everywhere = level(box([-6, -6, -1], [60, 60, 0]), explore=SETTINGS, spawn=(-3, 0, 0.02), navmesh=NAV)
    trial = found(everywhere, MujocoSimulator(everywhere, 1, 1), script, "unexpected_area").path
    assert trial is not None
    assert trial.stood is not None
    landed = trial.stood[np.isfinite(trial.stood[:, 0]) & (trial.stood[:, 0] > 2.3)] * [1, 1, 0]
    pillars = [box(place - around - [0, 0, 8], place + around) for place in landed]
    where = level(first, *pillars, explore=SETTINGS, kill_z_m=-12.0, spawn=(-3, 0, 0.02), navmesh=NAV)
    finding, again = confirmed(where, script, "unexpected_area")
    assert finding.position[0] > 15.0, "the last pillar is not reached"
    attempts, succeeded = again.confirmation.half_step  # around the way that half the step found
    assert 33 <= attempts <= 34
    assert succeeded >= 4
    assert not again.fragile


def test_a_long_way_round_gets_shorter_and_still_falls_bit_for_bit() -> None:
    script = [(EAST, 4), (WEST, 4), (NORTH, 4), (WEST, 5), (EAST, 5), (STILL, 10), (EAST, 30)]
    where = platform()
    finding, again = confirmed(where, script, "fell_out_of_world")
    assert finding.path is not None
    assert again.path is not None
    assert again.path.found_s == pytest.approx(finding.path.duration_s)
    assert again.path.duration_s < 0.65 * finding.path.duration_s
    simulator = MujocoSimulator(where, 1, 1)
    (trial,) = run_lanes(simulator, [Lane(again.path.state, again.path.actions, len(again.path.actions))])
    np.testing.assert_array_equal(trial.positions, again.path.positions)
    assert trial.fell


def test_the_same_seed_confirms_the_same_way() -> None:
    script = [(EAST, 4), (WEST, 4), (EAST, 40)]
    one, other = (confirmed(platform(), script, "fell_out_of_world")[1] for _ in range(2))
    assert one.confirmation == other.confirmation
    np.testing.assert_array_equal(one.path.actions, other.path.actions)


def test_a_path_that_does_not_come_out_is_no_bug() -> None:
    where = platform()
    simulator = MujocoSimulator(where, where.explore.lanes, 1)
    surface = SurfaceIndex(where.navmesh.triangles, 3.0)
    finding = found(where, simulator, [(EAST, 40)], "fell_out_of_world")
    finding = replace(finding, path=replace(finding.path, succeeded=0))
    confirmer = Confirmer(where, simulator, surface, 0, lambda finer, n: MujocoSimulator(finer, n, 1))
    (again,) = confirmer.confirm([finding])
    assert again.fragile
    assert not again.gating


def test_what_has_no_path_stays_as_it_is_and_gating_ones_come_first() -> None:
    where = platform()
    simulator = MujocoSimulator(where, where.explore.lanes, 1)
    surface = SurfaceIndex(where.navmesh.triangles, 3.0)
    walked = found(where, simulator, [(EAST, 40)], "fell_out_of_world")
    pathless = replace(walked, id="other", path=None, gating=False)
    confirmer = Confirmer(where, simulator, surface, 0, lambda finer, n: MujocoSimulator(finer, n, 1))
    first, second = confirmer.confirm([pathless, walked])
    assert (first.id, second.id) == ("it", "other")
    assert second is pathless
    assert confirmer.confirm([pathless]) == (pathless,)


def test_once_interrupted_what_is_not_confirmed_yet_stays_as_it_was_found(monkeypatch) -> None:
    monkeypatch.setattr("reachtest.confirm.confirmer.AT_ONCE", 1)
    where, told = platform(), []
    simulator = MujocoSimulator(where, where.explore.lanes, 1)
    surface = SurfaceIndex(where.navmesh.triangles, 3.0)
    long = found(where, simulator, [(WEST, 4), (EAST, 44)], "fell_out_of_world")
    short = replace(found(where, simulator, [(EAST, 40)], "fell_out_of_world"), id="short")
    confirmer = Confirmer(
        where,
        simulator,
        surface,
        0,
        lambda finer, n: MujocoSimulator(finer, n, 1),
        lambda: told[-1][1] == 2,
        lambda *what: told.append(what),
    )
    first, second = confirmer.confirm([long, short])
    assert told[0] == ("confirming findings", 1, 2)
    assert told[-1] == ("confirming findings", 2, 2)
    assert second.confirmation is not None
    assert first is long
    assert len(simulator.save()) == simulator.agents  # and all of them are in use again


@pytest.mark.parametrize("agents", [2, 5, 32])
def test_what_becomes_of_a_lane_does_not_depend_on_how_many_run_beside_it(agents) -> None:
    where = platform()
    rng = np.random.default_rng(1)
    one, many = MujocoSimulator(where, 1, 1), MujocoSimulator(where, agents, 1)
    state = one.place(where.spawns[0].position[None])[0]
    way = run_lanes(one, [Lane(state, np.tile(np.array([[EAST, 0]], dtype=np.int8), (40, 1)), 40)])[0]
    lanes = [Lane(state, plan, 15 + 4 * i) for i, plan in enumerate(pursuits(way, 6, 40, rng))]
    lanes += [Lane(state, vary(way.actions, 60, rng), 60 - 7 * i) for i in range(6)]
    for alone, beside in zip(run_lanes(one, lanes), run_lanes(many, lanes), strict=True):
        np.testing.assert_array_equal(alone.states, beside.states)
        np.testing.assert_array_equal(alone.actions, beside.actions)
        assert alone.fell == beside.fell
