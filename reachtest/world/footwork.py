"""Steps: what a capsule on joints cannot get onto, or walks off, within the step height.

Shape legend: B agents, n chosen agents. Positions are the feet.
"""

from __future__ import annotations

import numpy as np

from reachtest.columns import ColumnIndex
from reachtest.geometry import indices
from reachtest.records import Bools, Character, Floats, Ints
from reachtest.world.contacts import Contacts
from reachtest.world.controller import Plan
from reachtest.world.tiled_batch import TiledBatch

OVERLAP_M = 0.02  # deeper than any resting contact: a place that overlaps more is not free
TREAD_M = 0.05  # a step is at least so deep: what is less is the face of a wall
BLOCKED_COS = 0.25  # a velocity that points this much into an obstacle wants to step onto it


class Footwork:
    """Moves characters of a batch up and down steps, where there is room for them."""

    def __init__(
        self, character: Character, slope_cos: float, batch: TiledBatch, columns: ColumnIndex
    ) -> None:
        """`columns` tells where there are floors; what is walkable has a normal z of at least `slope_cos`."""
        self._who, self._slope_cos, self._batch, self._columns = character, slope_cos, batch, columns

    def step_up(self, plan: Plan, contacts: Contacts, may: Bools) -> Ints:
        """Lift whoever `may` [B] onto a ledge no higher than the step height, where there is room and walkable
        ground; returns who [n] moved."""
        ids, wall = self._blocked(plan, contacts, may)
        if not len(ids):
            return ids
        ahead = self._batch.position[ids]
        ahead[:, :2] -= wall * (self._who.radius_m + 0.06)
        ledge, slope = self._columns.highest(ahead, -0.02, self._who.step_height_m + 0.005)
        good = np.isfinite(ledge) & (slope >= self._slope_cos)
        ids, wall = ids[good], wall[good]
        lifted, moved = self._batch.position[ids], self._batch.velocity[ids]
        lifted[:, 2] = ledge[good] + 0.005
        moved[:, :2], moved[:, 2] = plan.uncut[ids], 0.0
        onto = lifted.copy()
        onto[:, :2] -= TREAD_M * wall
        room = self._has_room(ids, onto)
        return self._try_place(ids[room], lifted[room], moved[room])

    @staticmethod
    def _blocked(plan: Plan, contacts: Contacts, may: Bools) -> tuple[Ints, Floats]:
        """Who pushes against an obstacle, and the flat normal [n, 2] of the one pushed hardest."""
        uncut, flat = plan.uncut[contacts.ids], contacts.flat
        pressing = flat[:, :, 0] * uncut[:, 0, None] + flat[:, :, 1] * uncut[:, 1, None]
        need = -np.maximum(BLOCKED_COS * np.hypot(uncut[:, 0], uncut[:, 1]), 0.05)
        chosen = indices(may[contacts.ids] & (pressing.min(axis=1) < need))
        return contacts.ids[chosen], flat[chosen, pressing[chosen].argmin(axis=1)]

    def snap_down(self, may: Bools) -> Ints:
        """Keep whoever `may` [B] on ground that falls away by no more than the step height; returns who [n] moved."""
        position, velocity = self._batch.position, self._batch.velocity
        ids = indices(may & (velocity[:, 2] < 0.5))
        if not len(ids):
            return ids
        who, feet = self._who, position[ids]
        ground, slope = self._columns.highest(feet, 1.5 * who.step_height_m + 0.1, 0.05)
        # A sphere resting on a plane touches it uphill of its lowest point, which therefore hangs above.
        target = ground + who.radius_m * (1.0 / np.maximum(slope, 1e-3) - 1.0)
        drop = feet[:, 2] - target
        good = np.isfinite(ground) & (slope >= self._slope_cos) & (drop > -0.02) & (drop <= who.step_height_m)
        ids, lowered, still = ids[good], feet[good], velocity[ids[good]]
        lowered[:, 2], still[:, 2] = target[good], 0.0
        return self._try_place(ids, lowered, still, on_ground=True)

    def _has_room(self, ids: Ints, positions: Floats) -> Bools:
        """Who of agents [n] would overlap nothing at `positions` [n, 3]: a joint between two blocks is no step."""
        if not len(ids):
            return np.zeros(0, dtype=np.bool_)
        batch = self._batch
        kept = batch.position[ids]
        batch.position[ids] = positions
        batch.touch(ids)
        free = batch.deepest(ids) > -OVERLAP_M
        batch.position[ids] = kept
        batch.touch(ids[~free])
        return np.asarray(free, dtype=np.bool_)

    def _try_place(self, ids: Ints, positions: Floats, velocities: Floats, on_ground: bool = False) -> Ints:
        """Move agents [n] where there is room (and ground, if asked); returns those that moved."""
        if not len(ids):
            return ids
        batch = self._batch
        kept = batch.position[ids], batch.velocity[ids]
        batch.position[ids], batch.velocity[ids] = positions, velocities
        batch.touch(ids)
        free = batch.deepest(ids) > -OVERLAP_M
        if on_ground:
            free &= (batch.sensor[ids, :, 4] <= -self._slope_cos).any(axis=1)
        back = ids[~free]
        if len(back):
            batch.position[back], batch.velocity[back] = kept[0][~free], kept[1][~free]
            batch.touch(back)
        return ids[free]
