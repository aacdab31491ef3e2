"""Trying every wall: where the border is, whose turn it is, and what counts as a push."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from reachtest.explore.actions import LEAPS, LEAPS_AIMED, action_stream
from reachtest.explore.aimed import HEADINGS
from reachtest.explore.cache import PositionCache
from reachtest.explore.directed.borders import BESIDE_M, NEAR_M, TURNS, Borders
from reachtest.explore.directed.footholds import Footholds
from reachtest.explore.directed.gaps import ONTO_FLOOR, Gaps, places_to_push
from reachtest.explore.directed.places import NOWHERE, SPACING_M, Places, outermost
from reachtest.explore.directed.turns import in_turns
from reachtest.navmesh.islands import Islands
from reachtest.records import Candidates, ExploreSettings, NavMesh, StepResult
from tests.levels import UNREAL
from tests.unit.explore.walker import KILL_Z_M, LEVEL, Run, Walker, stands

SIDE = 24.0


def rectangle(x0, y0, x1, y1, z=0.0):
    corners = [[x0, y0, z], [x1, y0, z], [x1, y1, z], [x0, y1, z]]
    return [[corners[i] for i in (0, 1, 2)], [corners[i] for i in (0, 2, 3)]]


def mesh(*rectangles) -> NavMesh:
    triangles = np.array([face for r in rectangles for face in rectangle(*r)], dtype=float)
    return NavMesh("", triangles.reshape(-1, 3), np.arange(3 * len(triangles)).reshape(-1, 3))


def places(*rectangles) -> tuple[Places, Gaps]:
    """Along the border, and at gaps; a spawn is on the first rectangle."""
    islands = Islands(mesh(*rectangles))
    return places_to_push(islands, np.arange(islands.count) == 0, UNREAL)


def borders(*rectangles) -> Borders:
    return watched(*rectangles)[0]


def watched(*rectangles) -> tuple[Borders, Footholds]:
    islands = Islands(mesh(*rectangles))
    connected = np.arange(islands.count) == 0
    footholds = Footholds(islands, connected, np.arange(islands.count))
    return Borders(
        *places_to_push(islands, connected, UNREAL), footholds, UNREAL, ExploreSettings()
    ), footholds


UNIT = np.array([[np.cos(a), np.sin(a)] for a in np.arange(8) * np.pi / 4])


def border_of(table: Borders):
    return table.effort()[0]


def cached(positions, off_mesh_m=0.0, grounded=True) -> tuple[PositionCache, Candidates]:
    cache = PositionCache(0.5)
    cache.insert(np.array(positions, dtype=float).reshape(-1, 3))
    n = len(cache)
    ones = np.ones(n, dtype=np.int64)
    off, stands_ = np.full(n, off_mesh_m), np.full(n, grounded)
    return cache, Candidates(ones, np.ones(n), off, 3.0, stands_, np.zeros(n), np.zeros((n, 3)))


def everywhere() -> tuple[PositionCache, Candidates]:
    x, y = np.meshgrid(np.arange(0.5, SIDE), np.arange(0.5, SIDE))
    return cached(np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], axis=1))


SQUARE = (0, 0, SIDE, SIDE)
RING = ((0, 0, SIDE, 9), (0, 15, SIDE, SIDE), (0, 9, 9, 15), (15, 9, SIDE, 15))  # round a block, of tiles


def test_places_stand_evenly_along_the_border_and_look_straight_out() -> None:
    along, gaps = places(*RING)
    assert not len(gaps.places.positions)
    positions, outwards = along.positions, UNIT[along.headings - 1]
    block = (np.abs(positions[:, :2] - SIDE / 2) <= 3.01).all(axis=1)
    centre = np.where(block[:, None], -1.0, 1.0) * (positions[:, :2] - SIDE / 2)
    assert (np.einsum("ni,ni->n", centre, outwards) > 0).all()
    np.testing.assert_allclose(np.abs(outwards).max(axis=1), 1.0)
    at_wall = np.abs(np.abs(positions[:, :2] - SIDE / 2).max(axis=1) - np.where(block, 3.0, SIDE / 2))
    assert at_wall.max() < 1e-9  # none between tiles that lie against each other
    north = np.sort(positions[(outwards[:, 1] > 0.5) & ~block, 0])
    assert np.diff(north).min() >= SPACING_M / 2
    assert np.diff(north).max() <= 1.5 * SPACING_M
    assert len(north) <= SIDE / SPACING_M + 1
    assert north[0] < SPACING_M
    assert north[-1] > SIDE - SPACING_M - 0.5


def test_only_the_border_of_what_counts_is_tried() -> None:
    along, gaps = places(SQUARE, (40, 0, 50, 10))  # too far for a jump
    assert along.positions[:, 0].max() <= SIDE
    assert not len(gaps.places.positions)


def test_the_world_ends_where_no_nav_mesh_comes_after_the_border() -> None:
    along, _ = places(*(np.array(RING) * 4.0))
    block = (np.abs(along.positions[:, :2] - 2 * SIDE) <= 12.01).all(axis=1)
    np.testing.assert_array_equal(outermost(along.positions, along.headings), ~block)


# --- gaps -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("gap_m", "rise_m", "within"),
    [
        (3.0, 0.0, True),
        (5.5, 0.0, True),
        (6.5, 0.0, False),
        (2.5, 0.9, True),
        (2.5, 1.2, False),
        (5.7, 0.8, False),
        (8.5, -4.0, True),
        (9.6, -4.0, False),
        (8.5, -6.0, False),
    ],
)
def test_a_gap_is_what_a_jump_of_the_character_may_cross(gap_m: float, rise_m: float, within: bool) -> None:
    """5.1 m flat, 0.9 m up, and 8.6 m on to 4 m lower; and a radius from the edge on both sides."""
    x = SIDE + gap_m
    along, gaps = places(SQUARE, (x, 8, x + 3, 11, rise_m))
    there = gaps.places.positions[gaps.places.island == 0]
    assert (len(there) > 0) is within
    assert (
        bool(along.positions[:, 0].max() > SIDE) is within
    )  # its border is tried too, once somebody stands there
    if within:
        assert (np.abs(there[:, :2] - SIDE / 2) <= SIDE / 2).all()  # on this side
        assert np.abs(there[:, 0] - SIDE).min() < 0.1
        assert set(gaps.places.target) == {1}  # one need not leap back


def test_jumps_are_followed_from_island_to_island() -> None:
    along, gaps = places(SQUARE, *((x, 8, x + 3, 11) for x in (27, 33, 39, 70)))
    assert set(gaps.places.target) == {1, 2, 3}
    assert 41 < along.positions[:, 0].max() < 43


def test_leaps_may_begin_where_no_leap_leads() -> None:
    """One may get there along a beam that is too narrow for the nav-mesh."""
    _, gaps = places(SQUARE, *((x, 8, x + 3, 11) for x in (60, 66)))
    there = np.column_stack([gaps.places.island, gaps.places.target])
    assert {tuple(pair) for pair in there.tolist()} == {(1, 2), (2, 1)}


def test_it_does_not_matter_how_many_pieces_are_looked_at_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    rectangles = SQUARE, *((x, 8, x + 3, 11) for x in (27, 33, 39, 70))
    _, whole = places(*rectangles)
    monkeypatch.setattr("reachtest.explore.directed.gaps.AT_ONCE", 5)
    _, by_fives = places(*rectangles)
    np.testing.assert_array_equal(by_fives.places.positions, whole.places.positions)
    np.testing.assert_array_equal(by_fives.places.target, whole.places.target)
    np.testing.assert_array_equal(np.concatenate(by_fives.landings), np.concatenate(whole.landings))


def test_a_floor_off_the_nav_mesh_has_no_border_and_is_leapt_at_by_the_shortest_gaps() -> None:
    islands, floors = Islands(mesh(SQUARE)), Islands(mesh((26, 0, 29, 24)))
    connected = np.array([True])
    along, gaps = places_to_push(islands, connected, UNREAL, floors)
    _, whole = places(SQUARE, (26, 0, 29, 24))
    assert set(along.island) == {0}
    onto, all_of_them = (some.places.positions[some.places.target == 1] for some in (gaps, whole))
    assert len(onto) == ONTO_FLOOR < len(all_of_them)
    assert (SIDE - onto[:, 0] < 0.1).all()  # none from farther back

    footholds = Footholds(islands, connected, np.zeros(1, dtype=np.int64), floors)
    table = Borders(along, gaps, footholds, UNREAL, ExploreSettings())
    cache, candidates = everywhere()
    footholds.note(cache.positions, candidates.grounded)
    aim = table.draw(np.random.default_rng(0), 70, cache, candidates)
    assert aim is not None
    assert (aim.targets >= len(along.positions)).sum() >= 70 / len(TURNS)


def test_between_connected_islands_there_is_nothing_to_try() -> None:
    islands = Islands(mesh(SQUARE, (27, 8, 30, 11)))
    assert not len(places_to_push(islands, np.ones(2, dtype=bool), UNREAL)[1].places.positions)


def test_a_gap_is_tried_jumping_until_somebody_stands_on_the_other_side() -> None:
    table, footholds = watched(SQUARE, (27, 8, 30, 11))
    near, far = [SIDE - 2.0, 9.5, 0], [28.5, 9.5, 0]
    along, gaps = places(SQUARE, (27, 8, 30, 11))
    rows = len(along.positions) + np.flatnonzero(gaps.places.island == 0)

    def drawn(*positions):
        cache, candidates = cached(positions)
        footholds.note(cache.positions, candidates.grounded)
        aim = table.draw(np.random.default_rng(0), 40, cache, candidates)
        assert aim is not None
        return np.isin(aim.targets, rows), aim.headings

    across, headings = drawn(near)
    assert across.sum() >= 40 / 5
    by_chance = headings[across][headings[across] <= LEAPS_AIMED]
    assert len(by_chance)
    assert set(by_chance) <= {
        LEAPS + 8,
        LEAPS + 1,
        LEAPS + 2,
    }  # east, give or take; the others are worked out
    before = len(border_of(table))
    across, _ = drawn(near, far)
    assert not across.any()
    assert len(border_of(table)) > before  # the other island's counts from now on


def test_a_gap_is_tried_from_a_pillar_too_small_for_a_run_up() -> None:
    """The place to begin lay beyond the pillar: nobody was sent, however many stood there."""
    pillars = [(x, 0, x + 1.7, 1.2) for x in (0.0, 4.8)]  # 2.5 m less a radius around, 2.3 m apart
    along, gaps = places(*pillars)
    rows = len(along.positions) + np.flatnonzero(gaps.places.island == 0)
    table = borders(*pillars)
    cache, candidates = cached([[1.69, 0.0, 0], [1.69, 1.2, 0]])
    aims = [table.draw(np.random.default_rng(seed), 16, cache, candidates) for seed in range(3)]
    sent = np.concatenate([aim.headings[np.isin(aim.targets, rows)] for aim in aims if aim is not None])
    assert (sent > LEAPS_AIMED).any()  # worked out
    assert (sent <= LEAPS_AIMED).any()  # by chance


def test_nobody_leaps_from_the_foot_of_a_tower_that_is_too_high() -> None:
    towers = (6, 8, 9, 11, 2.5), (12, 8, 15, 11, 2.5)
    along, gaps = places(SQUARE, *towers)
    n, between = len(along.positions), np.column_stack([gaps.places.island, gaps.places.target])
    assert {tuple(pair) for pair in between.tolist()} == {(1, 2), (2, 1)}
    table = borders(SQUARE, *towers)
    cache, candidates = everywhere()
    aim = table.draw(np.random.default_rng(0), 32, cache, candidates)
    assert aim is not None
    assert (aim.targets < n).all()
    cache, candidates = cached([*cache.positions, [8.0, 9.0, 2.5]])  # somebody got up all the same
    aim = borders(SQUARE, *towers).draw(np.random.default_rng(0), 32, cache, candidates)
    assert aim is not None
    leaps = aim.targets[aim.targets >= n] - n
    assert len(leaps) >= 8
    assert (gaps.places.island[leaps] == 1).all()


def test_the_world_ends_at_the_border_whatever_roofs_stand_beyond() -> None:
    alone, _ = places(SQUARE)
    with_roofs, _ = places(SQUARE, *((x, 8, x + 3, 11) for x in (60, 66)))
    np.testing.assert_array_equal(alone.positions, with_roofs.positions)
    np.testing.assert_array_equal(alone.headings, with_roofs.headings)


def test_who_flies_over_an_island_does_not_stand_on_it() -> None:
    _, footholds = watched(SQUARE, (27, 8, 30, 11))
    footholds.note(np.array([[28.0, 9, 0.3], [5, 5, 0], [28, 9, 2.0]]), np.array([False, True, True]))
    assert footholds.goals.tolist() == [True, False]
    footholds.note(np.concatenate([np.zeros((3, 3)), [[28, 9, 0.1]]]), np.ones(4, dtype=bool))
    assert footholds.goals.tolist() == [True, True]


# --- whose turn it is -------------------------------------------------------------------------------------


def test_every_place_is_tried_before_one_is_tried_again() -> None:
    table = borders(SQUARE)
    cache, candidates = everywhere()
    drawn, lanes = [], 8
    while sum(map(len, drawn)) < 2 * len(border_of(table)):
        aim = table.draw(np.random.default_rng(len(drawn)), lanes, cache, candidates)
        assert aim is not None
        drawn.append(aim.targets)
        assert len(np.unique(aim.targets)) == lanes
        tries = np.bincount(np.concatenate(drawn), minlength=len(border_of(table)))
        assert tries.max() - tries.min() <= 1


def test_the_target_that_was_tried_least_gets_the_lanes_however_few_gaps_lead_to_it() -> None:
    target = np.repeat([0, 1], [30, 2])
    rows = in_turns(np.where(target == 0, 1.0, 0.0), target, np.array([30.0, 0.0]), 40)
    assert np.bincount(rows, minlength=32)[30:].tolist() == [18, 17]  # 35 = 5 + 30: both have had as many
    assert len(np.unique(rows[rows < 30])) == 5  # each once before one is tried again


def test_a_push_starts_near_its_place_and_goes_straight_out() -> None:
    table = borders(SQUARE)
    cache, candidates = everywhere()
    aim = table.draw(np.random.default_rng(0), 16, cache, candidates)
    assert aim is not None
    away = border_of(table)[aim.targets] - cache.positions[aim.starts]
    assert np.linalg.norm(away, axis=1).max() <= NEAR_M
    side = np.abs(border_of(table)[aim.targets, :2] - SIDE / 2).argmax(axis=1)
    out = np.sign(border_of(table)[aim.targets, side] - SIDE / 2)
    east_or_north = np.where(side == 0, 1, 3)
    expected = np.where(out > 0, east_or_north, east_or_north + 4)
    np.testing.assert_array_equal((aim.headings - 1) % HEADINGS + 1, expected)
    assert 0 < (aim.headings > HEADINGS).sum() < 16  # some walk, some jump


def test_the_same_draws_for_the_same_generator() -> None:
    aims = [borders(SQUARE).draw(np.random.default_rng(3), 8, *everywhere()) for _ in range(2)]
    assert aims[0] is not None
    assert aims[1] is not None
    for one, other in zip(vars(aims[0]).values(), vars(aims[1]).values(), strict=True):
        np.testing.assert_array_equal(one, other)


def test_nobody_is_sent_from_afar_or_from_the_air() -> None:
    rng = np.random.default_rng(0)
    assert borders(SQUARE).draw(rng, 4, *cached([[SIDE / 2, SIDE / 2, 0]])) is None
    assert borders(SQUARE).draw(rng, 4, *cached([[0.5, 5, 0]], grounded=False)) is None
    assert borders(SQUARE).draw(rng, 4, *cached([[0.5, 5, 0]])) is not None


def test_a_nearer_start_takes_over_as_the_cache_grows() -> None:
    table = borders(SQUARE)
    far, near = [1.9, 5.0, 0.0], [0.2, 5.0, 0.0]
    table.draw(np.random.default_rng(0), 1, *cached([far]))
    for seed in range(4):
        aim = table.draw(np.random.default_rng(seed), 4, *cached([far, near]))
        assert aim is not None
        assert set(aim.starts) == {1}


def test_from_a_crate_beside_the_nav_mesh_all_ways_are_tried() -> None:
    table = borders(SQUARE)
    crate = cached([[30, 30, 1.0]], off_mesh_m=BESIDE_M + 0.1)
    aim = table.draw(np.random.default_rng(0), HEADINGS, *crate)
    assert aim is not None
    assert set((aim.headings - 1) % HEADINGS + 1) == set(range(1, HEADINGS + 1))
    assert borders(SQUARE).draw(np.random.default_rng(0), 8, *cached([[30, 30, 0]], BESIDE_M - 0.1)) is None


@pytest.mark.parametrize(
    ("stick", "x", "counts"), [(5, 0.3, True), (1, 0.3, False), (5, 3.0, False), (0, 0.3, False)]
)
def test_a_push_is_a_step_outwards_at_the_border_whoever_makes_it(stick: int, x: float, counts: bool) -> None:
    table = borders(SQUARE)
    west = np.flatnonzero(border_of(table)[:, 0] == 0)
    y = border_of(table)[west[3], 1]
    positions = np.full((5, 2, 3), np.nan)  # the other lane fell
    positions[:, 0] = [x, y, 0]
    table.note(positions, np.full((5, 2), stick, dtype=np.int8))
    assert table.effort()[1][west[3]] == counts  # once an episode, however long
    assert table.effort()[1].sum() == counts


def test_what_others_pushed_at_comes_later() -> None:
    table = borders(SQUARE)
    cache, candidates = everywhere()
    west = border_of(table)[:, 0] == 0
    table.note(border_of(table)[west][None] + [0.1, 0, 0], np.full((1, west.sum()), 5, dtype=np.int8))
    aim = table.draw(np.random.default_rng(0), int((~west).sum()), cache, candidates)
    assert aim is not None
    assert not west[aim.targets].any()


def test_a_jumping_push_goes_the_same_way_and_jumps_more() -> None:
    walks, jumps = (
        np.concatenate([action_stream(0, r, 0, 32, heading) for r in range(100)])
        for heading in (3, 3 + HEADINGS)
    )
    np.testing.assert_array_equal(walks[:, 0], jumps[:, 0])
    assert jumps[:, 1].mean() > 1.5 * walks[:, 1].mean()


def test_a_leap_is_a_run_up_one_jump_and_a_stop() -> None:
    takeoffs = set()
    for number in range(200):
        stream = action_stream(0, number, 0, 32, LEAPS + 3)
        takeoff = int(stream[:, 1].argmax())
        takeoffs.add(takeoff)
        there = stream[: takeoff + 7]
        assert set(there[:, 0]) in ({2}, {3}, {4})  # straight on
        assert there[:, 1].sum() == 1
        assert not stream[takeoff + 7 : takeoff + 10].any()
    assert takeoffs == set(range(8))
    assert len(action_stream(0, 0, 0, 5, LEAPS + 3)) == 5  # a short round's, too


class Fenced(Walker):
    """A fence stands round the square but for one narrow gap in its east side, behind which it goes down."""

    GAP = (-7.4, -6.6)

    def step(self, actions) -> StepResult:
        outside = self._states[:, 0] > 12.3
        super().step(actions)
        x, y, z, *_ = self._states.T
        through = outside | ((x > 12.3) & (y > self.GAP[0]) & (y < self.GAP[1]))
        x[~through] = np.clip(x[~through], -12.3, 12.3)
        np.clip(y, -12.3, 12.3, out=y)
        z[through] = np.minimum(z[through], -0.1)
        return self._result(z < KILL_Z_M)

    def _result(self, fell) -> StepResult:
        positions, grounded = self._states[:, :3].copy(), stands(self._states)
        return StepResult(
            positions, grounded, np.where(grounded[:, None], positions, np.nan), fell.astype(np.int8)
        )


def test_a_gap_in_a_long_fence_is_found_by_more_seeds_than_without(monkeypatch: pytest.MonkeyPatch) -> None:
    explore = replace(LEVEL.explore, steps=1_500, reset_interval=32, goal_radius_m=3.0, directed=0.8)
    where = replace(LEVEL, explore=explore)

    def found() -> int:
        runs = (Run(seed, where, Fenced(5)).result for seed in range(48))
        return sum(any(fall.footing[0] > 9 and fall.footing[1] < 0 for fall in run.falls) for run in runs)

    pushing = found()
    monkeypatch.setattr(Borders, "draw", lambda *_: None)
    assert pushing >= 28  # of 60 seeds 43 find it, and 20 without
    assert pushing >= found() + 12


def test_islands_take_turns_however_many_gaps_lead_to_them() -> None:
    wide, small = (27, 2, 30, 22), (8, -5, 11, -3)
    table, _ = watched(SQUARE, wide, small)
    drawn = [table.draw(np.random.default_rng(number), 16, *everywhere()) for number in range(20)]
    across = np.concatenate([table._target[aim.targets] for aim in drawn if aim is not None])
    tries = np.bincount(across[across != NOWHERE], minlength=3)[1:]
    assert tries.min() > 20
    assert np.ptp(tries) <= 2
