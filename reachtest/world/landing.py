"""What a character in the air comes down on: the first touch along the tick's way decides, not where the tick ends.

At a run a capsule is a tenth of a metre in the edge of a wall by then, and its round end leans on the top of the edge
instead of on its side: walls were climbed that are 8 cm too high.

Shape legend: B agents, n chosen agents. Positions are the feet.
"""

from __future__ import annotations

import numpy as np

from reachtest.geometry import indices
from reachtest.records import Bools, Floats, Ints
from reachtest.world.contacts import LEANING_NXY
from reachtest.world.tiled_batch import TiledBatch
from reachtest.world.tunnelling import CLEAR_M, DOUBTFUL_M

HALVINGS = 5  # of the way of a tick: 6 mm are left at a run
SLIDING_M = 0.002  # no deeper one only slides along what one was in before


class Landings:
    """Takes the ground from under who only flew past it into its side."""

    def __init__(self, batch: TiledBatch, slope_cos: float, radius_m: float) -> None:
        """What is walkable has a normal z of at least `slope_cos`."""
        self._batch, self._slope_cos, self._radius = batch, slope_cos, radius_m
        self._level_nz = np.sqrt(1.0 - LEANING_NXY**2)

    def correct(self, flew: Bools, came_from: Floats, planned: Floats) -> None:
        """Put who `flew` [B] and touched an edge from its side first there; `came_from` [B, 3] is where all were
        a tick ago and `planned` [B, 3] their velocities since."""
        batch = self._batch
        rises = -batch.sensor[:, :, 4]
        leaning = (rises >= self._slope_cos) & (rises < self._level_nz)
        ids = indices(flew & (leaning & (batch.sensor[:, :, 1] < -DOUBTFUL_M)).any(axis=1))
        if not len(ids):
            return
        here, began, deepest = batch.position[ids].copy(), came_from[ids], self._depth(ids)
        there = self._out_of_the_side(ids)
        before = self._depth(ids, began)
        clear = indices(before < DOUBTFUL_M)
        there[clear] = self._first_touch(ids[clear], began[clear], here[clear], before[clear])
        self._depth(ids, there)
        beside = (-batch.sensor[ids, :, 4] < self._slope_cos).all(axis=1)
        there[clear, 2] = np.maximum(there, here)[clear, 2]  # who rises goes on rising
        beside &= self._depth(ids, there) <= deepest
        batch.position[ids] = np.where(beside[:, None], there, here)
        batch.velocity[ids[beside]] = planned[ids[beside]]
        batch.touch(ids)

    def _first_touch(self, ids: Ints, began: Floats, here: Floats, before: Floats) -> Floats:
        """Where [n, 3] agents [n] that were hardly in anything where they `began`, no deeper than `before` [n], get
        deeper on their way to `here` [n, 3]."""
        free, met = np.zeros((len(ids), 1)), np.ones((len(ids), 1))
        touch = np.maximum(before + SLIDING_M, CLEAR_M)
        for _ in range(HALVINGS if len(ids) else 0):
            middle = (free + met) / 2
            touches = (self._depth(ids, began + middle * (here - began)) > touch)[:, None]
            free, met = np.where(touches, free, middle), np.where(touches, middle, met)
        return np.asarray(began + met * (here - began), dtype=np.float64)

    def _out_of_the_side(self, ids: Ints) -> Floats:
        """Where [n, 3] agents [n] only touch the edge they are deepest in, at the same height."""
        deepest = self._batch.sensor[ids, 0]
        inside = self._radius + deepest[:, 1]  # from the centre of the round end to the edge
        across = np.linalg.norm(deepest[:, 2:4], axis=1)
        out = np.sqrt(np.maximum(self._radius**2 - (inside * deepest[:, 4]) ** 2, 0.0)) - inside * across
        there = self._batch.position[ids].copy()
        there[:, :2] -= (out / np.maximum(across, LEANING_NXY))[:, None] * deepest[:, 2:4]
        return np.asarray(there, dtype=np.float64)

    def _depth(self, ids: Ints, positions: Floats | None = None) -> Floats:
        """How deep [n] agents [n] are in what they are deepest in, at `positions` [n, 3] if given, where they are left;
        negative outside of everything."""
        if positions is not None:
            self._batch.position[ids] = positions
            self._batch.touch(ids)
        return -self._batch.deepest(ids)
