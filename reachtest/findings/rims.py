"""Open rims: falls off one open edge are one bug, however far apart chance found them.

Two places are on one rim if, every half metre of the straight way between them, one stands on a floor and can walk off
it without touching anything, into one void. A fence with two gaps is no open rim, nor is the ground between two holes.

Shape legend: n samples, d directions.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial import cKDTree

from reachtest.findings.void import Void
from reachtest.findings.walls import Walls
from reachtest.records import Floats, Level

FARTHEST_M = 25.0  # between two falls: in longer gaps it is rather the exploration that is too short
_SPACING_M = 0.5
_BACK_M = np.arange(11) * _SPACING_M  # rims are not straight: from the line to the floor behind it
_AT_EDGE_M = 1.5  # one stands up to a radius over the edge, and moves on for a tick; slantwise that is more
_STRIDE_M = 3 * _SPACING_M
_AHEAD_M = np.arange(1, 17) * _SPACING_M  # and from there to the void: a jump begins before the edge
_INLAND_M = 1.5  # a fence that near the edge closes it, though one may squeeze along outside of it
_ALONG = 0.75  # cosine: one walks off a rim to its side; from one hole one walks straight on to the next
_DIRECTIONS = 16
_TRIES = 5  # lines between two clusters: the shortest may cut a corner or meet a post
_FLOOR_M = 1.0  # the floor between two places on it may be that much off the straight line


def join_rims(level: Level, void: Void, edges: Sequence[Floats]) -> list[int]:
    """For clusters of falls, by the edges they fell off [k, 3], the smallest index of a cluster on the same rim.

    Clusters without an edge stay by themselves.
    """
    label = list(range(len(edges)))
    rims = _Rims(level, void)
    for _, one, other, start, end in sorted(_near_pairs(edges), key=lambda pair: pair[:3]):
        first, second = label[one], label[other]
        if first == second:
            continue
        if rims.open_between(start, end):
            label = [min(first, second) if mine in (first, second) else mine for mine in label]
    return label


def _near_pairs(edges: Sequence[Floats]) -> list[tuple[float, int, int, Floats, Floats]]:
    """Clusters near each other: distance [m], their indices and places near each other [3], the nearest first."""
    trees = [cKDTree(places.reshape(-1, 3)) for places in edges]
    pairs = []
    for one in range(len(edges)):
        for other in range(one + 1, len(edges)):
            if not len(edges[one]) or not len(edges[other]):
                continue
            found = trees[other].query(edges[one], distance_upper_bound=FARTHEST_M)
            away, which = np.asarray(found[0]), np.asarray(found[1])
            for near in np.argsort(away, kind="stable")[:_TRIES].tolist():
                if np.isfinite(away[near]):
                    end = edges[other][which[near]]
                    pairs.append((float(away[near]), one, other, edges[one][near], end))
    return pairs


class _Rims:
    def __init__(self, level: Level, void: Void) -> None:
        self._walls, self._void = Walls(level.collision), void
        character = level.character
        self._heights = np.linspace(character.step_height_m + 0.1, character.height_m, 3)
        angles = np.arange(_DIRECTIONS) * 2 * np.pi / _DIRECTIONS
        self._directions = np.stack([np.cos(angles), np.sin(angles), np.zeros(_DIRECTIONS)], axis=1)

    def open_between(self, start: Floats, end: Floats) -> bool:
        """Whether one can walk off everywhere between two places [3], in one direction and into one void."""
        count = max(2, int(np.ceil(np.linalg.norm(end - start) / _SPACING_M)) + 1)
        line = start + np.linspace(0, 1, count)[:, None] * (end - start)
        along = (end - start) / max(float(np.linalg.norm(end - start)), 1e-9)
        aside = self._directions[np.abs(self._directions @ along) <= _ALONG]
        return any(self._open_towards(line, direction) for direction in aside)

    def _open_towards(self, line: Floats, direction: Floats) -> bool:
        stands = line[:, None] - _BACK_M[:, None] * direction  # [n, steps, 3]
        floor, _ = self._void.columns.highest(stands.reshape(-1, 3), _FLOOR_M, _FLOOR_M)
        known = np.isfinite(floor).reshape(stands.shape[:-1])
        if not known.any(axis=1).all():
            return False
        nearest = known.argmax(axis=1)
        if _BACK_M[nearest[[0, -1]]].max() > _AT_EDGE_M:
            return False  # the floor is another than the one that was fallen off
        each = np.arange(len(line))
        line = stands[each, nearest] * [1.0, 1.0, 0.0]
        line[:, 2] = floor.reshape(known.shape)[each, nearest]
        if not self._one_floor(line):
            return False
        void = self._void.holds(line[:, None] + _AHEAD_M[:, None] * direction)  # [n, steps]
        if not void.any(axis=1).all():
            return False
        edge = line + _AHEAD_M[void.argmax(axis=1)][:, None] * direction
        if not self._void.holds((edge[1:] + edge[:-1]) / 2).all():
            return False
        ways = [(line - _INLAND_M * direction + [0, 0, up], edge + [0, 0, up]) for up in self._heights]
        starts, ends = (np.concatenate(side) for side in zip(*ways, strict=True))
        return not self._walls.between(starts, ends).any()

    def _one_floor(self, line: Floats) -> bool:
        """Whether the floor goes on between places [n, 3] on it: two platforms have two rims."""
        stride = np.linalg.norm(np.diff(line, axis=0), axis=1)
        floor, _ = self._void.columns.highest((line[1:] + line[:-1]) / 2, _FLOOR_M, _FLOOR_M)
        return bool((stride <= _STRIDE_M).all() and np.isfinite(floor).all())
