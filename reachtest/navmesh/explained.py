"""Goals that nobody reaches because of what the nav-mesh promises: on impossible ground, or behind it.

The rule: walk the samples from where characters stood. What that gets to, but not once the impossible places and
the steps higher than a jump are taken out, is explained by them. What it does not get to at all is not.

Shape legend: N samples, M pairs, G goals, n points.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import breadth_first_order
from scipy.spatial import cKDTree

from reachtest.navmesh.promises import Promises
from reachtest.records import Bools, Floats, Ints

_SAME_STOREY_M = 1.0  # feet and surface of one place: a climb, a slope over the spacing


def without_visited(promises: Promises, stood: Floats, radius_m: float) -> Promises:
    """The promises less the places within a radius of where somebody stood [n, 3]: what happened is possible."""
    bad = np.flatnonzero(promises.reason > 0)
    if not len(bad) or not len(stood):
        return promises
    near = _near(promises.feet[bad], stood, radius_m)
    reason, value = promises.reason.copy(), promises.value.copy()
    reason[bad[near]], value[bad[near]] = 0, np.nan
    return replace(promises, reason=reason, value=value)


def explained_goals(
    promises: Promises, stood: Floats, goals: Floats, within_m: float, jump_m: float
) -> Bools:
    """Which of the unreached `goals` [G, 3] impossible places explain, as seen from where somebody stood [n, 3].

    A goal is reached from `within_m`; a character jumps `jump_m` high.
    """
    samples = promises.samples
    blocked = promises.steps[promises.rise_m > jump_m]
    if not len(goals) or not len(stood) or not ((promises.reason > 0).any() or len(blocked)):
        return np.zeros(len(goals), dtype=np.bool_)
    starts = np.flatnonzero(_near(promises.feet, stood, max(samples.spacing_m, within_m / 2)))
    both = np.concatenate([promises.pairs, promises.pairs[:, ::-1]])
    free = (promises.reason[both] == 0).all(axis=1) & ~_among(both, blocked, len(samples.positions))
    reach = max(within_m, samples.spacing_m)
    promised = _gets_to(both, starts, len(samples.positions))
    possible = _gets_to(both[free], starts[promises.reason[starts] == 0], len(samples.positions))
    # A goal floats with the surface: one comes near it with the feet, which a step too high keeps far below.
    return _near(goals, samples.positions[promised], reach) & ~_near(goals, promises.feet[possible], reach)


def _near(points: Floats, others: Floats, within_m: float) -> Bools:
    """Which of `points` [n, 3] have one of `others` within a distance horizontally, on the same storey."""
    if not len(points) or not len(others):
        return np.zeros(len(points), dtype=np.bool_)
    squash = np.array([1.0, 1.0, within_m / _SAME_STOREY_M])
    away, _ = cKDTree(others * squash).query(points * squash, distance_upper_bound=within_m * (1 + 1e-9))
    return np.isfinite(away)


def _among(pairs: Ints, chosen: Ints, count: int) -> Bools:
    return np.isin(pairs[:, 0] * count + pairs[:, 1], chosen[:, 0] * count + chosen[:, 1])


def _gets_to(ways: Ints, starts: Ints, count: int) -> Bools:
    """Which of `count` samples one gets to from `starts` over directed pairs `ways` [M, 2]."""
    first = np.stack(
        [np.full(len(starts), count), starts], axis=1
    )  # from one more, which leads to all starts
    every = np.concatenate([ways, first])
    shape = (count + 1, count + 1)
    graph = coo_matrix((np.ones(len(every), dtype=np.int8), (every[:, 0], every[:, 1])), shape=shape).tocsr()
    order = breadth_first_order(graph, count, directed=True, return_predecessors=False)
    result = np.zeros(count + 1, dtype=np.bool_)
    result[order] = True
    return result[:count]
