"""Trying every wall: where the border is, whose turn it is, and what counts as a push."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from reachtest.explore.actions import HEADINGS, action_stream, heading_of
from reachtest.explore.borders import BESIDE_M, NEAR_M, SPACING_M, Borders, border_places, outermost
from reachtest.explore.cache import PositionCache
from reachtest.records import Candidates, NavMesh, StepResult
from tests.unit.explore.walker import KILL_Z_M, LEVEL, Run, Walker, stands

SIDE = 24.0


def rectangle(x0, y0, x1, y1, z=0.0):
    corners = [[x0, y0, z], [x1, y0, z], [x1, y1, z], [x0, y1, z]]
    return [[corners[i] for i in (0, 1, 2)], [corners[i] for i in (0, 2, 3)]]


def mesh(*rectangles) -> NavMesh:
    triangles = np.array([face for r in rectangles for face in rectangle(*r)], dtype=float)
    return NavMesh("", triangles.reshape(-1, 3), np.arange(3 * len(triangles)).reshape(-1, 3))


def borders(*rectangles) -> Borders:
    navmesh = mesh(*rectangles)
    return Borders(navmesh, np.ones(len(navmesh.faces), dtype=bool))


def cached(positions, off_mesh_m=0.0, grounded=True) -> tuple[PositionCache, Candidates]:
    cache = PositionCache(0.5)
    cache.insert(np.array(positions, dtype=float).reshape(-1, 3))
    n = len(cache)
    ones = np.ones(n, dtype=np.int64)
    return cache, Candidates(ones, np.ones(n), np.full(n, off_mesh_m), 3.0, np.full(n, grounded))


def everywhere() -> tuple[PositionCache, Candidates]:
    x, y = np.meshgrid(np.arange(0.5, SIDE), np.arange(0.5, SIDE))
    return cached(np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], axis=1))


SQUARE = (0, 0, SIDE, SIDE)
RING = ((0, 0, SIDE, 9), (0, 15, SIDE, SIDE), (0, 9, 9, 15), (15, 9, SIDE, 15))  # round a block, of tiles


def test_places_stand_evenly_along_the_border_and_look_straight_out() -> None:
    navmesh = mesh(*RING)
    places, outwards = border_places(navmesh, np.ones(len(navmesh.faces), dtype=bool))
    block = (np.abs(places[:, :2] - SIDE / 2) <= 3.01).all(axis=1)
    centre = np.where(block[:, None], -1.0, 1.0) * (places[:, :2] - SIDE / 2)
    assert (np.einsum("ni,ni->n", centre, outwards) > 0).all()
    np.testing.assert_allclose(np.abs(outwards).max(axis=1), 1.0)
    at_wall = np.abs(np.abs(places[:, :2] - SIDE / 2).max(axis=1) - np.where(block, 3.0, SIDE / 2))
    assert at_wall.max() < 1e-9  # none between tiles that lie against each other
    north = np.sort(places[(outwards[:, 1] > 0.5) & ~block, 0])
    assert np.diff(north).min() >= SPACING_M / 2
    assert np.diff(north).max() <= 1.5 * SPACING_M
    assert len(north) <= SIDE / SPACING_M + 1
    assert north[0] < SPACING_M
    assert north[-1] > SIDE - SPACING_M - 0.5


def test_only_the_border_of_what_counts_is_tried() -> None:
    navmesh = mesh(SQUARE, (40, 0, 50, 10))
    places, _ = border_places(navmesh, np.array([True, True, False, False]))
    assert places[:, 0].max() <= SIDE


def test_the_world_ends_where_no_nav_mesh_comes_after_the_border() -> None:
    wide = mesh(*(np.array(RING) * 4.0))
    places, outwards = border_places(wide, np.ones(len(wide.faces), dtype=bool))
    block = (np.abs(places[:, :2] - 2 * SIDE) <= 12.01).all(axis=1)
    np.testing.assert_array_equal(outermost(places, heading_of(outwards)), ~block)


def test_every_place_is_tried_before_one_is_tried_again() -> None:
    table = borders(SQUARE)
    cache, candidates = everywhere()
    drawn, lanes = [], 8
    while sum(map(len, drawn)) < 2 * len(table.places):
        aim = table.draw(np.random.default_rng(len(drawn)), lanes, cache, candidates)
        assert aim is not None
        drawn.append(aim.targets)
        assert len(np.unique(aim.targets)) == lanes
        tries = np.bincount(np.concatenate(drawn), minlength=len(table.places))
        assert tries.max() - tries.min() <= 1


def test_a_push_starts_near_its_place_and_goes_straight_out() -> None:
    table = borders(SQUARE)
    cache, candidates = everywhere()
    aim = table.draw(np.random.default_rng(0), 16, cache, candidates)
    assert aim is not None
    away = table.places[aim.targets] - cache.positions[aim.starts]
    assert np.linalg.norm(away, axis=1).max() <= NEAR_M
    side = np.abs(table.places[aim.targets, :2] - SIDE / 2).argmax(axis=1)
    out = np.sign(table.places[aim.targets, side] - SIDE / 2)
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
    west = np.flatnonzero(table.places[:, 0] == 0)
    y = table.places[west[3], 1]
    positions = np.full((5, 2, 3), np.nan)  # the other lane fell
    positions[:, 0] = [x, y, 0]
    table.note(positions, np.full((5, 2), stick, dtype=np.int8))
    assert table.pushes[west[3]] == counts  # once an episode, however long
    assert table.pushes.sum() == counts


def test_what_others_pushed_at_comes_later() -> None:
    table = borders(SQUARE)
    cache, candidates = everywhere()
    west = table.places[:, 0] == 0
    table.note(table.places[west][None] + [0.1, 0, 0], np.full((1, west.sum()), 5, dtype=np.int8))
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


class Fenced(Walker):
    """A fence stands round the square but for one narrow gap in its east side, behind which it goes down."""

    GAP = (-7.4, -6.6)

    def step(self, actions) -> StepResult:
        outside = self._states[:, 0] > 12.3
        super().step(actions)
        x, y, z, _ = self._states.T
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
        runs = (Run(seed, where, Fenced(5)).result for seed in range(12))
        return sum(any(fall.footing[0] > 9 and fall.footing[1] < 0 for fall in run.falls) for run in runs)

    pushing = found()
    monkeypatch.setattr(Borders, "draw", lambda *_: None)
    assert pushing >= 9
    assert pushing >= found() + 4
