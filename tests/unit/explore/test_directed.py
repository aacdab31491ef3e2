"""Acting on purpose: headings, whose turn it is, and what counts as an attempt."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from reachtest.columns import ColumnIndex
from reachtest.explore.actions import STRAIGHTS, WALKS_AIMED, action_stream, heading_of
from reachtest.explore.cache import PositionCache
from reachtest.explore.directed.aim import BORDER_M, CONSIDERED, STRAIGHT_SHARE, Aims
from reachtest.explore.directed.walks import Walks
from reachtest.explore.goals import GoalSet
from reachtest.records import Candidates, ExploreSettings
from tests.levels import FLOOR, UNREAL
from tests.unit.explore.walker import Run

DIRECTIONS = np.array([[np.cos(a), np.sin(a)] for a in np.arange(8) * np.pi / 4])


@pytest.mark.parametrize("heading", range(1, 9))
def test_a_heading_carries_that_way_and_still_gets_around_corners(heading: int) -> None:
    stream = np.concatenate([action_stream(0, r, 0, 32, heading) for r in range(200)])
    moves = np.concatenate([[[0.0, 0.0]], DIRECTIONS])[stream[:, 0]]
    assert (moves.mean(axis=0) @ DIRECTIONS[heading - 1]) > 0.5
    assert set(stream[:, 0]) == set(range(9))  # no direction is ruled out
    assert heading_of(DIRECTIONS[heading - 1][None])[0] == heading


def test_a_straight_heading_keeps_to_a_beam_and_a_share_of_the_attempts_has_one() -> None:
    for number in range(20):
        stream = action_stream(0, number, 0, 64, STRAIGHTS + 6)
        assert (stream[:16] == [6, 0]).all()
        assert len(set(stream[16:, 0])) > 1  # then around corners as ever
    aim, _ = aims([[4, 0, 0]])
    drawn = aim.draw(np.random.default_rng(0), 200, *cached([0, 0, 0]))
    assert drawn is not None
    assert set((drawn.headings - 1) % 8 + 1) <= {8, 1, 2}
    assert (drawn.headings > STRAIGHTS).mean() == pytest.approx(STRAIGHT_SHARE, abs=0.1)
    assert (drawn.headings > WALKS_AIMED).any()
    nowhere, _ = aims([[4, 0, 0]])
    cache, candidates = cached([0, 0, 0])
    drawn = nowhere.draw(
        np.random.default_rng(0), 200, cache, replace(candidates, grounded=np.zeros(1, dtype=bool))
    )
    assert drawn is not None
    assert set(drawn.headings) == {1, STRAIGHTS + 1}  # nobody stands where a walk might begin


def test_a_directed_stream_is_its_own_and_the_others_stay_as_they_were() -> None:
    plain = action_stream(3, 2, 1, 64)
    np.testing.assert_array_equal(plain, action_stream(3, 2, 1, 64, 0))
    directed = action_stream(3, 2, 1, 64, 5)
    np.testing.assert_array_equal(directed, action_stream(3, 2, 1, 64, 5))
    assert not np.array_equal(plain, directed)
    assert action_stream(3, 2, 1, 400, 5, jump_share=0.0)[:, 1].sum() == 0


def cached(*positions) -> tuple[PositionCache, Candidates]:
    cache = PositionCache(1.0)
    cache.insert(np.array(positions, dtype=float))
    n = len(cache)
    ones = np.ones(n, dtype=np.int64)
    return cache, Candidates(
        ones, np.ones(n), np.zeros(n), 3.0, np.ones(n, dtype=bool), np.zeros(n), np.zeros((n, 3))
    )


def aims(goals, worth=None) -> tuple[Aims, GoalSet]:
    places = np.array(goals, dtype=float)
    all_goals = GoalSet(places, np.ones(len(places)))
    worth_ = np.ones(len(places), bool) if worth is None else np.array(worth)
    walks = Walks(UNREAL, ExploreSettings(), ColumnIndex(np.array(FLOOR, dtype=float)))
    return Aims(all_goals, worth_, 4.0, walks), all_goals


def test_every_open_part_gets_its_share_however_large_it_is() -> None:
    large = [[x, 20, 0] for x in range(0, 60, 4)]
    aim, _ = aims([*large, [0, -20, 0]])
    cache, candidates = cached(*[[x, 17, 0] for x in range(0, 60, 4)], [0, -17, 0])
    for seed in range(4):
        drawn = aim.draw(np.random.default_rng(seed), 8, cache, candidates)
    assert aim.attempts()[:-1].sum() == aim.attempts()[-1] == 16
    assert drawn is not None
    ahead = drawn.targets < len(large)
    way = (drawn.headings - 1) % 8 + 1
    assert set(way[ahead]) <= {1, 2, 3, 4, 5}  # north, give or take
    assert set(way[~ahead]) == {7}


def test_attempts_are_made_from_the_border_and_begin_anew_when_it_moves() -> None:
    aim, goals = aims([[4, 0, 0], [8, 0, 0], [30, 0, 0]])
    cache, candidates = cached([0, 0, 0])
    aim.draw(np.random.default_rng(0), 6, cache, candidates)
    assert (aim.attempts()[:2] > 0).all()
    goals.drain(np.array([[4.0, 0, 0]]), np.array([1]))
    cache, candidates = cached([0, 0, 0], [4, 0, 0])
    aim.draw(np.random.default_rng(1), 6, cache, candidates)
    assert aim.attempts()[0] == 0  # reached
    assert aim.attempts()[1] == 3  # those from the old border do not count
    assert aim.border_m[1] == pytest.approx(4.0)


def test_attempts_begin_anew_all_over_a_part_that_is_too_large_to_look_at_as_a_whole() -> None:
    """An open plain that is still being walked into was called unreached: each attempt counted, wherever it was."""
    across = np.arange(0, 200, 4)
    plain = [[x, y, 0] for x in across for y in across]
    assert len(plain) > 2 * CONSIDERED
    aim, goals = aims([*plain, [0, -40, 0]])
    cache, candidates = cached([-4, 0, 0], [0, -36, 0])
    for seed in range(40):
        aim.draw(np.random.default_rng(seed), 24, cache, candidates)
    beside = aim.attempts()[-1]
    assert aim.attempts()[:-1].sum() > 256
    assert beside > 0
    goals.drain(np.array([[0.0, 0, 0]]), np.array([1]))
    assert aim.attempts()[:-1].sum() == 0
    assert aim.attempts()[-1] == beside  # nobody got there


def test_what_lies_deep_in_an_open_part_is_tried_with_it() -> None:
    """A required point behind a blocked door: nobody aims at it from the door, but all attempts are at its part."""
    aim, _ = aims([*([x, 0, 0] for x in range(4, 44, 4)), [0, -40, 0]])
    cache, candidates = cached([0, 0, 0], [0, -36, 0])
    for seed in range(3):
        aim.draw(np.random.default_rng(seed), 8, cache, candidates)
    assert aim.attempts()[9] == 0
    assert aim.attempts_at_parts().tolist() == [12] * 10 + [12]


def test_what_was_tried_for_enough_is_not_wanted_any_more() -> None:
    """A required point on a roof took three of four directed lanes for good: hardly anybody tried the crates."""
    aim, goals = aims([[4, 0, 0], [0, -40, 0]], worth=[True, False])
    cache, candidates = cached([0, 0, 0], [0, -36, 0])
    assert aim.wanting(16)
    for seed in range(2):
        aim.draw(np.random.default_rng(seed), 8, cache, candidates)
    assert aim.wanting(17)
    assert not aim.wanting(16)
    goals.drain(np.array([[4.0, 0, 0]]), np.array([1]))
    assert not aim.wanting(17)


def test_attempts_from_afar_are_void_once_there_is_a_nearer_place() -> None:
    aim, _ = aims([[40, 0, 0]])
    aim.draw(np.random.default_rng(0), 5, *cached([0, 0, 0]))
    assert aim.attempts()[0] == 5
    aim.draw(np.random.default_rng(1), 5, *cached([0, 0, 0], [40 - BORDER_M, 0, 0]))
    assert aim.attempts()[0] == 5


def test_who_fell_off_a_beam_is_no_start_however_near_to_its_end() -> None:
    beam = [[1.5 * x, 0, 16] for x in range(6)]
    falling = [[12 + 1.5 * x, 2, 14 - 1.5 * y] for x in range(8) for y in range(8)]
    aim, _ = aims([[24, 0, 16]])
    cache, candidates = cached(*beam, *falling)
    high = np.concatenate([np.zeros(6), cache.positions[6:, 2]])
    drawn = aim.draw(np.random.default_rng(0), 8, cache, replace(candidates, above_m=high))
    assert drawn is not None
    assert (drawn.starts < 6).all()
    assert aim.border_m[0] == pytest.approx(16.5)
    over_it, _ = aims([[24, 0, 16]])
    drawn = over_it.draw(np.random.default_rng(0), 64, cache, replace(candidates, above_m=np.zeros(70)))
    assert drawn is not None
    assert (drawn.starts >= 6).any()  # could one stand there


def test_attempts_along_a_beam_begin_on_it_though_the_ground_below_is_nearer() -> None:
    beam = [[1.5 * x, 0, 4.5] for x in range(6)]
    ground = [[1.5 * x, 1.5 * y, 0] for x in range(12) for y in range(-2, 3)]
    aim, _ = aims([[15, 0, 4.5]])
    cache, candidates = cached(*beam, *ground)
    drawn = aim.draw(np.random.default_rng(0), 200, cache, candidates)
    assert drawn is not None
    on_it = drawn.starts < 6
    assert 60 < on_it.sum() < 140
    assert set((drawn.headings[on_it] - 1) % 8 + 1) == {1}
    assert aim.border_m[0] == pytest.approx(7.5)


def test_a_start_from_which_all_goes_wrong_is_not_the_only_one() -> None:
    """One who jumped off the end of a beam was the nearest by a metre: 2,000,000 steps began there, in vain."""
    aim, _ = aims([[0, 31.3, 0]])
    cache, candidates = cached([0, 39.0, 0.8], *[[x, 40.4, 0] for x in (-3, -1.5, 0, 1.5, 3)])
    visits, starts = candidates.visits.copy(), []
    for seed in range(20):
        drawn = aim.draw(np.random.default_rng(seed), 16, cache, replace(candidates, visits=visits))
        assert drawn is not None
        np.add.at(visits, drawn.starts, 1)
        starts.append(drawn.starts)
    shares = np.bincount(np.concatenate(starts), minlength=len(cache)) / 320
    assert len(shares) == 6
    assert shares.min() > 0.05
    assert shares[0] < 0.5


def test_no_effort_is_wasted_on_what_nobody_should_get_to() -> None:
    aim, _ = aims([[4, 0, 0], [0, 4, 0]], worth=[False, True])
    drawn = aim.draw(np.random.default_rng(0), 8, *cached([0, 0, 0]))
    assert drawn is not None
    assert set(drawn.targets) == {1}
    nothing, _ = aims([[4, 0, 0]], worth=[False])
    assert nothing.draw(np.random.default_rng(0), 8, *cached([0, 0, 0])) is None


@pytest.mark.parametrize("share", [0.0, 0.3, 1.0])
def test_the_share_of_directed_lanes_is_kept_over_the_rounds(share: float) -> None:
    run = Run(directed=share, steps=5 * 128 * 12, goal_spacing_m=6.0, goal_radius_m=0.01)
    directed = (run.result.headings > 0).mean(axis=1)[1:]  # of the first there is nothing to start from
    assert directed.mean() == pytest.approx(share, abs=0.1)
    assert run.result.headings.shape == (len(run.records), 5)


def test_points_that_directed_lanes_found_are_replayed_bit_for_bit() -> None:
    run = Run(directed=0.6, goal_radius_m=0.01)
    points, headings = run.result.points, run.result.headings
    found = np.flatnonzero(headings[points.round, points.agent] > 0)
    assert len(found) > 5
    replayer = run.replayer()
    for index in found[:: max(1, len(found) // 8)].tolist():
        assert replayer.path_to_point(index).succeeded == 1
