"""The risk that remains: whether the estimates hold where the truth is known, and when a run may stop on them."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from reachtest.explore.risk import MOST_SAMPLES, RECENT_LEAST, RiskCurve, is_done
from reachtest.explore.visits import VisitCounts
from reachtest.records import Exploration, GateSettings, Required, RiskSample, StopReason
from tests.unit.explore.walker import LEVEL, Run

SEEDS = range(5)
STEPS = (5_120, 10_240)  # a walker has found about 60 % and 80 % of its cells then
LONGEST = 10 * STEPS[-1]
WINDOW = 200  # episodes: enough to tell how many of them find something new
LONG_WINDOW = (
    800  # late in a run one episode in a hundred does: in 200 the next one by chance is half a percent
)


@cache
def run(seed: int) -> Exploration:
    """A longer run begins as the shorter one: its curve holds all of them."""
    return Run(seed, steps=LONGEST).result


def at(seed: int, steps: int) -> RiskSample:
    return next(sample for sample in run(seed).risk_curve if sample.agent_steps >= steps)


# --- quality: a walker on a fenced plane has some 2,330 cells -----------------------------------------------------


@pytest.mark.parametrize("steps", STEPS)
def test_the_estimate_brackets_what_a_ten_times_longer_run_finds(steps: int) -> None:
    """In every seed, with 2 % to spare below: Chao2 is about what there is, and this is about all of it."""
    for seed in SEEDS:
        low, high = at(seed, steps).ten_times_longer
        found = at(seed, 10 * steps).cells_total
        assert low <= 1.02 * found <= 1.02 * high, (seed, low, found, high)


@pytest.mark.parametrize("steps", STEPS)
def test_the_estimated_total_is_nearer_to_the_truth_than_what_was_seen(steps: int) -> None:
    """A lower bound, but one worth having: at most a quarter of what there is is missed."""
    for seed in SEEDS:
        short, found = at(seed, steps), at(seed, 10 * steps).cells_total
        assert 0.75 * found <= short.estimated_cells_total <= 1.02 * found
        assert found - short.estimated_cells_total < 0.6 * (found - short.cells_total)


def test_the_bound_holds_for_what_the_next_episodes_find() -> None:
    """Where it says more than "at most 100 %": in 19 of 20 cases, though an adaptive search is no random sample."""
    pairs = [
        pair for seed in SEEDS for pair in _pairs(seed, LONG_WINDOW) if pair[0].discovery_probability < 1
    ]
    held = [now.discovery_probability >= _observed(now, later) for now, later in pairs]
    assert len(held) >= 20 * len(SEEDS)
    assert np.mean(held) >= 0.95


def test_the_latest_episodes_tell_what_the_next_ones_find() -> None:
    """Closer than the bound, and rather too high than too low: discovery only gets rarer."""
    pairs = [pair for seed in SEEDS for pair in _pairs(seed) if pair[0].episodes >= RECENT_LEAST]
    shares = np.array([now.recent_share for now, _ in pairs], dtype=float)
    bounds = np.array([now.discovery_probability for now, _ in pairs])
    observed = np.array([_observed(now, later) for now, later in pairs])
    assert np.abs(shares - observed).mean() < np.abs(bounds - observed).mean()
    assert 0.0 <= (shares - observed).mean() < 0.15


def _pairs(seed: int, window: int = WINDOW) -> list[tuple[RiskSample, RiskSample]]:
    """Each sample with the first one that is `window` episodes later."""
    curve = run(seed).risk_curve
    later = [next((b for b in curve if b.episodes >= a.episodes + window), None) for a in curve]
    return [(a, b) for a, b in zip(curve, later, strict=True) if b is not None]


def _observed(now: RiskSample, later: RiskSample) -> float:
    """Share of the episodes between two samples that found something new."""
    return (later.discovering - now.discovering) / (later.episodes - now.episodes)


# --- what is counted ----------------------------------------------------------------------------------------------


def test_cells_are_counted_as_a_look_at_all_of_them_would() -> None:
    rng = np.random.default_rng(0)
    visits, seen = VisitCounts(1.0), np.zeros((6, 6), dtype=int)
    for _ in range(20):
        at, episodes = rng.integers(0, 6, (9, 2)), rng.integers(0, 4, 9)
        before = seen.copy()
        finders = set()
        for episode in range(4):
            for x, y in {tuple(place) for place in at[episodes == episode].tolist()}:
                finders |= {episode} if seen[x, y] == 0 else set()
                seen[x, y] += 1
        discovering = visits.add(np.c_[at + 0.5, np.zeros(9)], episodes)
        assert discovering == len(finders) >= ((before == 0) & (seen > 0)).any()
        assert visits.incidence() == ((seen == 1).sum(), (seen == 2).sum(), (seen > 0).sum())


def test_the_curve_ends_with_the_run() -> None:
    result = run(0)
    last = result.risk_curve[-1]
    assert (last.agent_steps, last.episodes) == (result.agent_steps, result.episodes)
    assert (last.cells_once, last.cells_twice) == (result.cells_once, result.cells_twice)
    assert (last.goals_reached, last.points) == ((result.goal_step >= 0).sum(), len(result.points))
    assert last.discovery_probability == result.discovery_probability
    assert last.estimated_cells_total == result.estimated_cells_total


@pytest.mark.parametrize("rounds", [1, 49, 50, 51, 777, 5_000])
def test_a_curve_is_short_and_even_however_long_the_run(rounds: int) -> None:
    curve, visits = RiskCurve(), VisitCounts(1.0)
    for number in range(1, rounds + 1):
        curve.note(number % 3, visits, 100 * number, 7 * number, 0, 0)
    steps = [sample.agent_steps for sample in curve.samples]
    assert min(rounds, MOST_SAMPLES // 2) <= len(steps) <= MOST_SAMPLES
    assert steps[-1] == 100 * rounds
    assert len(set(np.diff(steps[:-1]).tolist())) <= 1
    assert curve.latest.discovering == sum(number % 3 for number in range(1, rounds + 1))


def test_the_latest_episodes_are_a_fifth_of_all() -> None:
    curve, visits = RiskCurve(), VisitCounts(1.0)
    for number in range(1, 1_001):
        curve.note(10 if number <= 900 else 1, visits, number, 10 * number, 0, 0)
    assert (curve.latest.recent_episodes, curve.latest.recent_discovering) == (2_000, 100 * 10 + 100)


# --- stopping -----------------------------------------------------------------------------------------------------

EASY = replace(LEVEL, gate=replace(LEVEL.gate, max_discovery_probability=0.9))


def test_a_run_stops_when_all_is_reached_and_the_risk_is_small() -> None:
    result = Run(where=EASY, steps=100_000, stop_when_done=True).result
    assert result.stop_reason is StopReason.DONE
    assert result.agent_steps < 50_000
    assert (result.goal_step >= 0).all()
    assert result.discovery_probability <= 0.9
    assert min(sample.discovery_probability for sample in result.risk_curve[:-1]) > 0.9  # and not later


def test_it_is_the_longer_run_up_to_there() -> None:
    short = Run(where=EASY, steps=100_000, stop_when_done=True).result
    same = Run(where=EASY, steps=short.agent_steps).result
    np.testing.assert_array_equal(short.points.positions, same.points.positions)
    assert same.stop_reason is StopReason.STEPS


def test_a_required_place_out_of_reach_keeps_it_going() -> None:
    sky = replace(EASY, required=(Required("sky", np.array([0.0, 0.0, 50.0]), 1.0),))
    result = Run(where=sky, steps=30_000, stop_when_done=True).result
    assert result.stop_reason is StopReason.STEPS
    assert result.discovery_probability <= 0.9


@pytest.mark.parametrize(
    ("limit", "reached", "wanted", "lately", "done"),
    [
        (0.05, [3, 9], [True, True], 1, True),
        (0.04, [3, 9], [True, True], 0, False),
        (0.05, [3, 9], [True, True], 2, False),  # the estimate is within the limit, what came of late is not
        (0.05, [3, -1], [True, True], 1, False),
        (0.05, [3, -1], [True, False], 1, True),  # nobody can get there
        (None, [3, 9], [True, True], 0, False),
    ],
)
def test_done_is_all_reached_and_the_risk_within_a_limit(limit, reached, wanted, lately, done) -> None:
    latest = RiskSample(1_000, 100, 50, 5, 5, 50, 20, lately, 2, 40)
    assert is_done(GateSettings((), 1.0, limit), np.array(reached), np.array(wanted), latest) is done
