"""What a tick of a fifth of a metre would pass through: thin floors, the edges of floors, openings that are too narrow.

Contacts are looked for at the end of a tick only. Cheaper than a finer time step (everybody pays) or MuJoCo's
speculative contacts (three times the step, and jumps come out a tenth too high: measured).

Shape legend: B agents, n chosen agents. Positions are the feet.
"""

from __future__ import annotations

import numpy as np

from reachtest.columns import ColumnIndex
from reachtest.geometry import indices
from reachtest.records import Bools, Floats, Ints
from reachtest.world.tiled_batch import TiledBatch

SAFE_DROP_M = 0.3  # less than the lower half of any capsule: contacts still push it up
SAFE_RISE = 0.8  # of the radius: where a floor rises more, the middle of the round end gets behind it
LOOKS = np.linspace(0.0, 1.0, 5)  # at the way of a fast fall within a tick
DOUBTFUL_M = 0.009  # so deep in a side one may be in an opening that is 2 cm too narrow
CLEAR_M = 0.005  # less deep in something is beside it
FAST_M = 0.22  # farther in a tick one may be past the narrowest place of a thin wall
STEEP_NZ = 0.3  # a normal with less of a vertical part is a side's
LIFTED = 0.2  # of the way to and fro between two sides: they are edges that push up
MOVES_OUT = 5  # one after the other, out of what one is deepest in: enough for a corner, in vain in a slot


class Barriers:
    """Keeps the characters of a batch on their side of floors and walls."""

    def __init__(
        self, batch: TiledBatch, columns: ColumnIndex, slope_cos: float, timestep_s: float, radius_m: float
    ) -> None:
        """`columns` tells where there are floors; what is walkable has a normal z of at least `slope_cos`."""
        self._batch, self._columns, self._slope_cos, self._dt = batch, columns, slope_cos, timestep_s
        self._safe_rise_m = SAFE_RISE * radius_m
        self._above_m = np.where(
            LOOKS > 0.0, 0.0, self._safe_rise_m
        )  # one is on a steep floor that is over the feet

    def stop_at_floors(self, velocity: Floats) -> None:
        """No fall into or through a floor: who would fall past one within the tick falls onto it; `velocity` [B, 3]
        is changed in place.

        Looked for all along the way: its edge may be crossed within the tick, and in a floor one stays. What was
        passed already is met from the side.
        """
        ids = indices(velocity[:, 2] * self._dt < -SAFE_DROP_M)
        if not len(ids):
            return
        begin, move = self._batch.position[ids], velocity[ids] * self._dt
        way = begin[:, None] + LOOKS[None, :, None] * move[:, None]  # [n, looks, 3]
        passed = np.concatenate([way[:, :1, 2], way[:, :-1, 2]], axis=1)  # how high it was a look before
        way[:, :, 2] = begin[:, None, 2]
        down, up = np.repeat(-move[:, 2], len(LOOKS)), np.tile(self._above_m, len(ids))
        floor = self._columns.highest(way.reshape(-1, 3), down, up)[0]
        floor = floor.reshape(passed.shape)
        met = np.isfinite(floor)
        rows = indices(met.any(axis=1))
        ids, floor, passed, first = ids[rows], floor[rows], passed[rows], met[rows].argmax(axis=1)
        at = np.arange(len(rows)), first
        onto = floor[at] <= passed[at] + self._above_m[first]
        drop = np.minimum(floor[at][onto] - begin[rows[onto], 2], 0.0)
        velocity[ids[onto], 2] = drop / self._dt
        # No farther than before its side, or up to where it rises steeply.
        rising = onto[:, None] & (floor > floor[at][:, None] + self._safe_rise_m)
        last = np.where(rising.any(axis=1), rising.argmax(axis=1) - 1, len(LOOKS) - 1)
        velocity[ids, :2] *= LOOKS[np.where(onto, last, first - 1), None]

    def back_out(self, came_from: Floats) -> None:
        """Put who is where it does not fit, or was halfway there, back to where it came from [B, 3].

        Who did not fit before would stay there for ever. Who is held up by both edges of a gap rests where it is clear
        of them: the contacts alone pushed it up too late. The corners of too narrow an opening are passed between two
        looks, and then its sides push evenly: without this a third of approaches got through 5 cm too little. To look
        only as one gets into a side saves a tenth of the time and lets through who slides along it.
        """
        batch, sensor = self._batch, self._batch.sensor
        rises = -sensor[:, :, 4]
        deep = (sensor[:, :, 1] < -DOUBTFUL_M) & (rises > -STEEP_NZ) & (rises < self._slope_cos)
        ids = indices(deep.any(axis=1))
        if not len(ids):
            return
        here, there = batch.position[ids], came_from[ids]
        fits, squeezed = self._comes_clear(ids)
        here = np.where(squeezed[:, None], batch.position[ids], here)
        fast = indices(fits & (np.linalg.norm(here - there, axis=1) > FAST_M))
        if len(fast):
            fits[fast] = self._fits(ids[fast], (here[fast] + there[fast]) / 2)
        back = indices(~fits)
        if len(back):
            fitted = self._fits(ids[back], there[back])
            # Clear of all: as deep in something as it was it would go the same way again.
            there[back] = batch.position[ids[back]]
            back = back[fitted]
        batch.position[ids], batch.velocity[ids[squeezed]] = here, 0.0
        batch.position[ids[back]], batch.velocity[ids[back]] = there[back], 0.0
        batch.touch(ids)

    def _fits(self, ids: Ints, positions: Floats) -> Bools:
        """Who of agents [n] fits at `positions` [n, 3]; it is left near there."""
        self._batch.position[ids] = positions
        self._batch.touch(ids)
        return self._comes_clear(ids)[0]

    def _comes_clear(self, ids: Ints) -> tuple[Bools, Bools]:
        """Who of agents [n] comes clear of everything when moved out of what it is in, where it is left, and who of
        them is lifted out of a gap by both its edges."""
        batch = self._batch
        result, trying = np.zeros(len(ids), dtype=np.bool_), np.arange(len(ids))
        began, sideways = batch.position[ids], np.zeros(len(ids))
        for moves in range(MOVES_OUT + 1):
            deepest = batch.sensor[ids[trying], 0]
            clear = (deepest[:, 0] == 0) | (deepest[:, 1] > -CLEAR_M)
            result[trying[clear]] = True
            trying, deepest = trying[~clear], deepest[~clear]
            if not len(trying) or moves == MOVES_OUT:
                break
            out = deepest[:, 1:2] * deepest[:, 2:]
            sideways[trying] += np.hypot(out[:, 0], out[:, 1])
            batch.position[ids[trying]] += out
            batch.touch(ids[trying])
        moved = batch.position[ids] - began
        opposed = 2.0 * np.hypot(moved[:, 0], moved[:, 1]) < sideways
        return result, result & opposed & (moved[:, 2] > LIFTED * sideways)
