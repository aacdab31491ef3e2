"""Characters that follow a route: acting on what they see, they get where a script of actions would drift off.

Pure pursuit (Coulter, CMU-RI-TR-92-01): push towards the point of the route a little ahead of the nearest one.

Shape legend: n pursuers, k of them asked, M points of the longest route, T agent steps.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from reachtest.records import Bools, Floats, Ints

_WINDOW = (
    16  # points of the route that are looked at for progress: no short cut through a wall to a later part
)
_HELD_UP_M = 0.2  # less than this a step is standing in front of something
_LOST_STEPS = 4  # held up for longer than this: try anything
_RISE_M = 0.3  # a point this much higher is jumped for
LOOP_M = 0.5  # a route that comes back this near has gone in a loop


@dataclass(frozen=True)
class Route:
    """Where to go, and where the jump button was held on the way."""

    points: Floats  # [m, 3]
    jumps: Bools  # [m]


@dataclass(frozen=True)
class Pursuit:
    """How one character follows its route."""

    route: Route
    ahead_m: float
    jumps_as_found: bool  # else only when held up or for something higher
    noise: Floats  # [T, 3] uniform in [0, 1): between two of the eight directions, for acting at random
    random_share: float = 0.0  # of the steps


def route_of(start: Floats, positions: Floats, actions: NDArray[np.int8], loop_m: float = LOOP_M) -> Route:
    """The route of a path from `start` [3] over `positions` [t, 3] with `actions` [t, 2], without its loops.

    What comes back within `loop_m` has gone in a loop; a larger one makes short cuts, at the risk of a wall.
    """
    points = np.concatenate([start[None], positions])
    jumps = np.append(actions[:, 1] > 0, False)
    kept, here = [], 0
    while here < len(points):
        kept.append(here)
        near = np.flatnonzero(np.linalg.norm(points[here + 1 :] - points[here], axis=1) < loop_m)
        here += 1 + (int(near[-1]) if len(near) else 0)
    if kept[-1] != len(points) - 1:
        kept.append(len(points) - 1)
    return Route(points[kept], jumps[kept])


class Pursuers:
    """Several pursuits at once; how far each has got along its route is all they remember."""

    def __init__(self, pursuits: Sequence[Pursuit]) -> None:
        n, most = len(pursuits), max((len(p.route.points) for p in pursuits), default=1)
        self._points = np.zeros((n, most, 3))
        self._jumps = np.zeros((n, most), dtype=np.bool_)
        self._noise = np.zeros((n, max((len(p.noise) for p in pursuits), default=0), 3))
        self._last = np.zeros(n, dtype=np.int64)
        for i, pursuit in enumerate(pursuits):
            m = len(pursuit.route.points)
            self._points[i, :m], self._points[i, m:] = pursuit.route.points, pursuit.route.points[-1]
            self._jumps[i, :m], self._last[i] = pursuit.route.jumps, m - 1
            self._noise[i, : len(pursuit.noise)] = pursuit.noise
        legs = np.linalg.norm(np.diff(self._points, axis=1), axis=2)
        self._arc = np.concatenate([np.zeros((n, 1)), np.cumsum(legs, axis=1)], axis=1)
        self._ahead = np.array([pursuit.ahead_m for pursuit in pursuits])
        self._as_found = np.array([pursuit.jumps_as_found for pursuit in pursuits], dtype=np.bool_)
        self._random = np.array([pursuit.random_share for pursuit in pursuits])
        self._at = np.zeros(n, dtype=np.int64)
        self._before = self._points[:, 0].copy()
        self._held_up = np.zeros(n, dtype=np.int64)
        self._stick = np.zeros(n, dtype=np.int64)

    def actions(self, rows: Ints, positions: Floats, steps: Ints) -> NDArray[np.int8]:
        """What pursuers `rows` [k] do [k, 2] at `positions` [k, 3], each in its own one of `steps` [k]."""
        at, held_up = self._progress(rows, positions)
        target_index = np.minimum(
            (self._arc[rows] < (self._arc[rows, at] + self._ahead[rows])[:, None]).sum(axis=1),
            self._last[rows],
        )
        target = self._points[rows, target_index]
        noise = self._noise[rows, steps]
        away = target - positions
        exact = np.arctan2(away[:, 1], away[:, 0]) / (np.pi / 4)
        octant = np.floor(exact).astype(np.int64)
        octant += noise[:, 0] < exact - octant
        arrived = np.hypot(away[:, 0], away[:, 1]) < 0.05  # over the edge: go on as before
        self._stick[rows] = np.where(arrived, self._stick[rows], 1 + octant % 8)
        astray = (noise[:, 1] < self._random[rows]) | (held_up > _LOST_STEPS)
        stick = np.where(astray, 1 + (noise[:, 2] * 8).astype(np.int64), self._stick[rows])
        jump = (held_up > 0) | (away[:, 2] > _RISE_M)
        jump |= self._as_found[rows] & self._jumps[rows, at]
        return np.stack([stick, jump], axis=1).astype(np.int8)

    def _progress(self, rows: Ints, positions: Floats) -> tuple[Ints, Ints]:
        """Which point of its route each is at [k], and for how many steps it has been held up [k]."""
        moved = np.linalg.norm(positions - self._before[rows], axis=1)
        held_up = np.where(moved < _HELD_UP_M, self._held_up[rows] + 1, 0)
        held_up[held_up > 2 * _LOST_STEPS] = 0  # and then try the route again
        window = np.minimum(self._at[rows, None] + np.arange(_WINDOW), self._last[rows, None])
        away = np.linalg.norm(self._points[rows[:, None], window] - positions[:, None], axis=2)
        at = window[np.arange(len(rows)), away.argmin(axis=1)]
        self._before[rows], self._held_up[rows], self._at[rows] = positions, held_up, at
        return at, held_up
