"""The position cache, the visit counts and the goals against the plainest code that says what they mean.

Positions are drawn from a coarse lattice now and then, so that distances of exactly K happen all the time.
"""

from __future__ import annotations

from collections import defaultdict

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from reachtest.explore.astray import Astray
from reachtest.explore.cache import PositionCache
from reachtest.explore.goals import GoalSet
from reachtest.explore.visits import VisitCounts
from reachtest.levels import PRESETS
from reachtest.navmesh.allowed import AllowedZones
from reachtest.navmesh.expected import ExpectedSurface
from reachtest.records import NavLink, NavMesh, Zone

Points = NDArray[np.float64]

seeds = st.integers(0, 2**32 - 1)
thresholds = st.sampled_from([0.25, 0.5, 1.0, 2.0, 0.7, 1.3])
offsets = st.sampled_from([0.0, -3_000.0, 5_000.25])


@st.composite
def clouds(draw: st.DrawFn, most: int = 150, centre: bool = False) -> Points:
    """Points in a box of a few metres: dense enough to be rivals, on a lattice or anywhere, near or far away."""
    rng = np.random.default_rng(draw(seeds))
    extent = draw(st.sampled_from([[4, 4, 4], [12, 12, 1], [200, 3, 0], [0, 0, 0]]))
    points = rng.uniform(-1, 1, (draw(st.integers(0, most)), 3)) * extent
    lattice = draw(st.sampled_from([None, 0.25, 0.5]))  # binary fractions: distances come out exactly
    if lattice:
        points = np.round(points / lattice) * lattice
    return points if centre else points + draw(offsets)


@st.composite
def splits(draw: st.DrawFn, points: Points) -> list[Points]:
    cuts = draw(st.lists(st.integers(0, len(points)), max_size=6))
    return np.split(points, sorted(cuts))


def distances(points: Points, others: Points) -> Points:
    """Every distance [n, m]."""
    away = points[:, None] - others[None]
    return np.sqrt((away * away).sum(axis=2))


def filtered(points: Points, threshold: float) -> list[int]:
    """Algorithm 1: insert where S_disc is empty or d(S_disc, s) > K."""
    kept: list[int] = []
    for index, point in enumerate(points):
        if not kept or distances(points[kept], point[None]).min() > threshold:
            kept.append(index)
    return kept


@settings(max_examples=150, deadline=None)
@given(st.data(), clouds(), thresholds)
def test_cache_is_the_sequential_filter_however_the_batches_are_cut(data, points, threshold) -> None:
    cache, inserted, offset = PositionCache(threshold), [], 0
    for batch in data.draw(splits(points)):
        inserted += (cache.insert(batch) + offset).tolist()
        offset += len(batch)
    expected = filtered(points, threshold)
    assert inserted == expected
    assert len(cache) == len(expected)
    np.testing.assert_array_equal(cache.positions, points[expected])


@settings(max_examples=50, deadline=None)
@given(clouds(), thresholds)
def test_cached_points_are_more_than_the_threshold_apart_and_cover_the_rest(points, threshold) -> None:
    cache = PositionCache(threshold)
    for batch in np.array_split(points, 3):
        cache.insert(batch)
    if not len(points):
        assert len(cache) == 0
        return
    away = distances(cache.positions, cache.positions)
    np.fill_diagonal(away, np.inf)
    assert (away > threshold).all()
    assert distances(points, cache.positions).min(axis=1).max() <= threshold


@settings(max_examples=100, deadline=None)
@given(st.data(), clouds(), thresholds)
def test_what_was_stood_at_and_what_was_stood_at_astray_is_discovered_apart(data, points, threshold) -> None:
    rng = np.random.default_rng(data.draw(seeds))
    stands = rng.random(len(points)) < 0.5
    astray = stands & (rng.random(len(points)) < 0.3)
    cache, inserted, offset = PositionCache(threshold), [], 0
    for batch in data.draw(splits(points)):
        rows = slice(offset, offset + len(batch))
        inserted += (cache.insert(batch, stands[rows], astray[rows]) + offset).tolist()
        offset += len(batch)
    everyone = np.arange(len(points))
    kept = [
        some[filtered(points[some], threshold)] for some in (everyone, everyone[stands], everyone[astray])
    ]
    assert inserted == np.unique(np.concatenate(kept)).tolist()
    np.testing.assert_array_equal(cache.positions, points[inserted])


def surroundings(points: Points, within: float, seed: int) -> AllowedZones:
    """A nav-mesh among the points, two links whose ends have different radii, and a roof that is fine."""
    rng = np.random.default_rng(seed)
    middle = points.mean(axis=0) if len(points) else np.zeros(3)
    vertices = middle + rng.uniform(-3, 3, (12, 3)) * [1, 1, 0.1]
    ends = middle + rng.uniform(-6, 6, (2, 2, 3)) * [1, 1, 0.2]
    links = tuple(NavLink("jump", *pair, radius, True) for pair, radius in zip(ends, (0.0, 2.0), strict=True))
    mesh = NavMesh("nav", vertices, np.arange(12).reshape(4, 3), links=links)
    roof = Zone("roof", "allowed_off_mesh", middle + [0.3, 0.1, -2.0], middle + [4.0, 2.7, 2.0])
    return AllowedZones(ExpectedSurface(mesh, PRESETS["unreal"], within), [roof] if seed % 2 else [])


@settings(max_examples=100, deadline=None)
@given(clouds(), st.sampled_from([0.1, 0.5, 1.0, 3.0, 6.0]), seeds)
def test_who_is_astray_is_who_is_not_expected(points, within, seed) -> None:
    surface = surroundings(points, within, seed)
    astray = Astray(surface, within)
    for some in np.array_split(points, 3):  # what was measured in one is known in the next
        assert astray(some).tolist() == np.isinf(surface.distance(some)).tolist()


@pytest.mark.parametrize("within", [0.5, 3.0])
@pytest.mark.parametrize("height", [0.0, 0.5, 2.25])
def test_who_stands_on_the_nav_mesh_is_not_measured_again(within, height) -> None:
    """Nor is where the middles of cells lie on it."""

    class Counted:
        asked = 0

        def distance(self, points: Points) -> Points:
            self.asked += len(points)
            away = np.abs(points[:, 2] - height)
            return np.where(away <= within, away, np.inf)

    surface, rng = Counted(), np.random.default_rng(0)
    astray = Astray(surface, within)
    everywhere = np.column_stack([rng.uniform(-20, 20, (10_000, 2)), np.full(10_000, height)])
    astray(everywhere)
    surface.asked = 0
    assert not astray(everywhere).any()
    assert surface.asked == 0


def test_cache_beyond_its_first_thousand_points() -> None:
    points = np.random.default_rng(1).uniform(-20, 20, (9_000, 3))
    cache = PositionCache(1.5)
    inserted = np.concatenate([cache.insert(batch) + i * 500 for i, batch in enumerate(np.split(points, 18))])
    expected = filtered(points, 1.5)
    assert len(expected) > 2_048  # twice grown
    assert inserted.tolist() == expected


def test_exactly_the_threshold_away_is_not_new() -> None:
    cache = PositionCache(1.0)
    points = np.array([[0.0, 0, 0], [1.0, 0, 0], [0, np.nextafter(1.0, 2.0), 0], [0, 0, 1.0]])
    assert cache.insert(points).tolist() == [0, 2]
    assert cache.insert(points).tolist() == []


@settings(max_examples=100, deadline=None)
@given(st.data(), clouds(), st.sampled_from([0.5, 1.0, 3.0]))
def test_visits_count_episodes_not_steps(data, points, cell) -> None:
    rng = np.random.default_rng(data.draw(seeds))
    visits = VisitCounts(cell)
    seen: dict[tuple[int, ...], set[tuple[int, int]]] = defaultdict(set)
    for number, batch in enumerate(data.draw(splits(points))):
        episodes = rng.integers(0, 5, len(batch))
        visits.add(batch, episodes)
        for point, episode in zip(batch, episodes.tolist(), strict=True):
            seen[tuple(np.floor(point / cell).astype(int).tolist())].add((number, episode))
    cells = [tuple(np.floor(point / cell).astype(int).tolist()) for point in points]
    assert visits.of(visits.cells(points)).tolist() == [len(seen[c]) for c in cells]
    counts = [len(who) for who in seen.values()]
    assert visits.incidence() == (counts.count(1), counts.count(2), len(counts))


def test_a_cell_nobody_visited_counts_nothing() -> None:
    visits = VisitCounts(1.0)
    visits.add(np.array([[0.5, 0.5, 0.5]]), np.array([0]))
    assert visits.of(visits.cells(np.array([[7.5, 0.5, 0.5], [0.1, 0.9, 0.2]]))).tolist() == [0, 1]
    assert visits.incidence() == (1, 0, 1)


@settings(max_examples=100, deadline=None)
@given(st.data(), clouds(60, centre=True), clouds(120, centre=True))
def test_goals_are_closed_by_the_first_position_within_their_radius(data, goals, positions) -> None:
    radii = np.random.default_rng(data.draw(seeds)).choice([0.3, 1.0, 2.5, 12.0], len(goals))
    steps = np.arange(len(positions)) * 3 + 1
    opened, first = GoalSet(goals, radii), 0
    for batch in data.draw(splits(positions)):
        opened.drain(batch, steps[first : first + len(batch)])
        first += len(batch)
    near = distances(goals, positions) <= radii[:, None]
    expected = [int(steps[row.argmax()]) if row.any() else -1 for row in near]
    assert opened.reached_step.tolist() == expected


@settings(max_examples=100, deadline=None)
@given(st.data(), clouds(40, centre=True), clouds(120, centre=True))
def test_distances_are_to_the_nearest_goal_that_is_still_open(data, goals, points) -> None:
    radii = np.full(len(goals), 1.0)
    opened = GoalSet(goals, radii)
    known = 0
    for batch in data.draw(splits(points)):
        known += len(batch)
        opened.drain(batch, np.arange(len(batch)))
        still = goals[opened.reached_step < 0]
        away = distances(points[:known], still)
        expected = away.min(axis=1) if len(still) else np.full(known, np.inf)
        np.testing.assert_allclose(opened.distances(points[:known]), expected, rtol=1e-12)


def test_no_goals_at_all() -> None:
    none = GoalSet(np.empty((0, 3)), np.empty(0))
    none.drain(np.zeros((2, 3)), np.arange(2))
    assert none.distances(np.zeros((2, 3))).tolist() == [np.inf, np.inf]
