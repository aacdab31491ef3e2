"""What a character in the air comes down on: the first touch along the tick's way decides, not where the tick ends.

At a run a capsule is a tenth of a metre in the edge of a wall by then, and its round end leans on the top of the edge
instead of on its side: walls were climbed that are 8 cm too high.

Shape legend: B agents, n chosen agents. Positions are the feet.
"""

from __future__ import annotations

import numpy as np

from reachtest.geometry import indices
from reachtest.records import Bools, Floats, Ints
from reachtest.world.controller import LEANING_NXY
from reachtest.world.tiled_batch import TiledBatch
from reachtest.world.tunnelling import CLEAR_M, DOUBTFUL_M

HALVINGS = 5  # of the way of a tick, down to 3 mm


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
        here, began = batch.position[ids].copy(), came_from[ids]
        there = self._out_of_the_side(ids)
        clear = indices(~self._touches(ids, began, DOUBTFUL_M))
        there[clear] = self._first_touch(ids[clear], began[clear], here[clear])
        self._touches(ids, there)
        beside = ~self._on_ground(ids)
        there[clear, 2] = np.maximum(there, here)[clear, 2]  # who rises goes on rising
        batch.position[ids] = np.where(beside[:, None], there, here)
        batch.velocity[ids[beside]] = planned[ids[beside]]
        batch.touch(ids)

    def _first_touch(self, ids: Ints, began: Floats, here: Floats) -> Floats:
        """Where [n, 3] agents [n] that are in nothing where they `began` meet what they are in `here` [n, 3]."""
        free, met = np.zeros((len(ids), 1)), np.ones((len(ids), 1))
        for _ in range(HALVINGS if len(ids) else 0):
            middle = (free + met) / 2
            touches = self._touches(ids, began + middle * (here - began))[:, None]
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

    def _touches(self, ids: Ints, positions: Floats, deeper_m: float = CLEAR_M) -> Bools:
        """Who of agents [n] is so deep in something at `positions` [n, 3]; they are left there."""
        self._batch.position[ids] = positions
        self._batch.touch(ids)
        return np.asarray(self._batch.deepest()[ids] < -deeper_m, dtype=np.bool_)

    def _on_ground(self, ids: Ints) -> Bools:
        return np.asarray((-self._batch.sensor[ids, :, 4] >= self._slope_cos).any(axis=1), dtype=np.bool_)
