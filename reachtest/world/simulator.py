"""B characters in one MuJoCo batch: plan, step, then the corrections a capsule on joints cannot make by itself.

Shape legend: B agents, n chosen agents. Positions are the feet.
A state row is position [3], velocity [3], footing [1]: the footing is 0 in the air, 1 on the ground, and 1 + k
while a step up is under way and has k control ticks left to find its ground.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from reachtest.geometry import ColumnIndex, indices
from reachtest.interfaces import Simulator
from reachtest.records import Bools, EndReason, Floats, Ints, Level, StepResult
from reachtest.world.controller import STICK_DIRECTIONS, Contacts, Controller, Plan, Stick, read_contacts
from reachtest.world.model import MASS_KG
from reachtest.world.terrain import split_terrain
from reachtest.world.tiled_batch import TiledBatch
from reachtest.world.tiles import MODELS_MB, TARGET_PIECES

STATE_SIZE = 7
SAFE_DROP_M = 0.3  # less than the lower half of any capsule: contacts still push it up
OVERLAP_M = 0.02  # deeper than any resting contact: a place that overlaps more is not free
SQUEEZED_M = 0.008  # on two sides at once: contacts would push it through an opening it does not fit
OPPOSED_COS = -0.7  # between the normals of two sides
STEP_S = 0.14  # enough to get from the foot of a step onto it at half the walking speed
BLOCKED_COS = 0.25  # a velocity that points this much into an obstacle wants to step onto it


class MujocoSimulator:
    """Meets `interfaces.Simulator`."""

    def __init__(
        self,
        level: Level,
        agents: int,
        threads: int = 0,
        tile_pieces: int = TARGET_PIECES,
        tiles_mb: float = MODELS_MB,
    ) -> None:
        """Prepare the level for `agents` characters; `threads` 0 takes every core."""
        self.character = level.character
        self._dt = 1.0 / level.explore.physics_hz
        self._repeat = level.explore.action_repeat
        self._kill_z = level.kill_z_m
        self._bounds = level.bounds
        self._columns = ColumnIndex(level.collision, min_normal_z=0.05)
        self._controller = Controller(level.character, self._dt)
        spawns = np.array([spawn.position for spawn in level.spawns])
        self._batch = TiledBatch(
            *split_terrain(level), level.character, self._dt, spawns, agents, threads, tile_pieces, tiles_mb
        )
        self._position, self._velocity = self._batch.position, self._batch.velocity
        self._footing = np.zeros(agents)
        self._contacts = self._read()

    @property
    def agents(self) -> int:
        """B."""
        return len(self._footing)

    @property
    def threads(self) -> int:
        """Threads that simulate."""
        return self._batch.threads

    @property
    def tiles_compiled(self) -> int:
        """Compilations so far; more than there are tiles where memory was short."""
        return self._batch.tiles_compiled

    @property
    def step_s(self) -> float:
        """Simulated time of one agent step [s]."""
        return self._dt * self._repeat

    def place(self, positions: Floats) -> Floats:
        """States [n, 7] standing still at `positions` [n, 3]."""
        states = np.zeros((len(positions), STATE_SIZE))
        states[:, :3] = positions
        return states

    def restore(self, agents: Ints, states: Floats) -> None:
        """Put `agents` [n] into `states` [n, 7]."""
        self._batch.set_state(agents, states[:, :3], states[:, 3:6])
        self._footing[agents] = states[:, 6]
        self._batch.enter_tiles(agents)
        self._refresh(agents)

    def save(self) -> Floats:
        """The states [B, 7] of all agents."""
        return np.concatenate([self._position, self._velocity, self._footing[:, None]], axis=1)

    def step(self, actions: NDArray[np.int8]) -> StepResult:
        """One agent step with `actions` [B, 2]: stick (0 to 8) and jump (0 or 1)."""
        stick = Stick(STICK_DIRECTIONS[actions[:, 0]], actions[:, 1] > 0, indices(actions[:, 0] == 0))
        stood = np.full((self.agents, 3), np.nan)
        for _ in range(self._repeat):
            self._tick(stick)
            on_ground = self._footing > 0
            stood[on_ground] = self._position[on_ground]
        return StepResult(self._position.copy(), on_ground, stood, self._ended())

    def coast(self, push: Floats) -> None:
        """One agent step of bare physics under accelerations `push` [B, 3] [m/s2]: what speed is measured against.

        The same tiles, no controller; the states are not to be used.
        """
        for _ in range(self._repeat):
            self._batch.enter_tiles()
            np.multiply(push, MASS_KG, out=self._batch.force)
            self._batch.step()

    def has_room(self, positions: Floats) -> Bools:
        """Whether a character fits at `positions` [n, 3]. Takes the agents away from where they were."""
        result = np.zeros(len(positions), dtype=np.bool_)
        for begin in range(0, len(positions), self.agents):
            some = positions[begin : begin + self.agents]
            self.restore(np.arange(len(some)), self.place(some))
            result[begin : begin + len(some)] = self._deepest()[: len(some)] > -OVERLAP_M
        return result

    # --- one control tick -------------------------------------------------------------------------

    def _tick(self, stick: Stick) -> None:
        before = self._footing > 0
        self._batch.enter_tiles()
        came_from = self._position.copy()
        plan = self._controller.plan(self._velocity, self._contacts, before, stick)
        self._stop_at_floors(plan.velocity)
        force = self._batch.force
        np.subtract(plan.velocity, self._velocity, out=force)
        force *= MASS_KG / self._dt
        force[:, 2] += MASS_KG * self.character.gravity_mps2
        self._batch.step()
        self._contacts = self._read()
        self._back_out(came_from)
        contacts = self._contacts
        walked = before & ~plan.jumped
        stands = self._controller.grounded(self._velocity, contacts, walked)
        self._limit_boost(plan, walked, stands)
        self._footing = np.where(stands, 1.0, walked * np.maximum(self._footing - 1.0, 0.0))
        if self.character.step_height_m > 0:
            self._step_up(plan, contacts, walked)
            self._snap_down(walked & (self._footing == 0))

    def _stop_at_floors(self, velocity: Floats) -> None:
        """No fall through a thin floor: who would fall past one within the tick falls onto it, in place.

        Contacts are looked for at the end of a tick only, and 40 m/s is more than a metre a tick. Cheaper
        than a finer time step (everybody pays) or MuJoCo's speculative contacts (three times the step, and
        jumps come out a tenth too high: measured).
        """
        ids = indices(velocity[:, 2] * self._dt < -SAFE_DROP_M)
        if not len(ids):
            return
        drop = -velocity[ids, 2] * self._dt
        floor, _ = self._columns.highest(self._position[ids], drop, 0.0)
        hit = np.isfinite(floor)
        velocity[ids[hit], 2] = (floor[hit] - self._position[ids[hit], 2]) / self._dt

    def _back_out(self, came_from: Floats) -> None:
        """Put who is squeezed between two sides back where it came from [B, 3], unless it was deeper in there.

        At 0.2 m a tick the corners of too narrow an opening are passed between two looks at the contacts, and
        then both sides push evenly: without this one approach in five got through 5 cm too little.
        """
        sensor = self._batch.sensor
        ids = indices(sensor[:, 1, 1] < -SQUEEZED_M)
        if not len(ids):
            return
        deep = (sensor[ids, :, 1] < -SQUEEZED_M) & (sensor[ids, :, 0] > 0)
        normals = np.where(deep[:, :, None], sensor[ids, :, 2:], 0.0)
        ids = ids[(normals @ normals.transpose(0, 2, 1)).min(axis=(1, 2), initial=0.0) < OPPOSED_COS]
        if not len(ids):
            return
        here = self._position[ids], self._velocity[ids], self._deepest()[ids]
        self._position[ids], self._velocity[ids] = came_from[ids], 0.0
        self._refresh(ids)
        worse = self._deepest()[ids] <= here[2]  # where it came from: there it would stay for ever
        if worse.any():
            self._position[ids[worse]], self._velocity[ids[worse]] = here[0][worse], here[1][worse]
            self._refresh(ids[worse])

    def _limit_boost(self, plan: Plan, walked: Bools, stands: Bools) -> None:
        """No throw without a jump: walking off a crest starts at rest, a steep surface only slows a fall."""
        allowed = np.where(walked, 0.0, np.maximum(plan.velocity[:, 2], 0.0))
        boosted = ~stands & (self._velocity[:, 2] > allowed)
        if boosted.any():
            self._velocity[boosted, 2] = allowed[boosted]

    def _step_up(self, plan: Plan, contacts: Contacts, may: Bools) -> None:
        """Lift onto a ledge no higher than the step height, where there is room and walkable ground."""
        if not len(contacts.ids):
            return
        uncut = plan.uncut[contacts.ids]
        flat = contacts.flat
        pressing = flat[:, :, 0] * uncut[:, 0, None] + flat[:, :, 1] * uncut[:, 1, None]
        worst = pressing.argmin(axis=1)
        need = -np.maximum(BLOCKED_COS * np.hypot(uncut[:, 0], uncut[:, 1]), 0.05)
        chosen = indices(may[contacts.ids] & (pressing.min(axis=1) < need))
        if not len(chosen):
            return
        c = self.character
        ids = contacts.ids[chosen]
        ahead = self._position[ids]
        ahead[:, :2] -= flat[chosen, worst[chosen]] * (c.radius_m + 0.06)
        ledge, slope = self._columns.highest(ahead, -0.02, c.step_height_m + 0.005)
        good = np.isfinite(ledge) & (slope >= self._controller.slope_cos)
        if not good.any():
            return
        ids = ids[good]
        lifted, moved = self._position[ids], self._velocity[ids]
        lifted[:, 2] = ledge[good] + 0.005
        moved[:, :2], moved[:, 2] = plan.uncut[ids], 0.0
        self._footing[self._try_place(ids, lifted, moved)] = 1.0 + np.ceil(STEP_S / self._dt)

    def _snap_down(self, may: Bools) -> None:
        """Keep a walking character on ground that falls away by no more than the step height."""
        ids = indices(may & (self._velocity[:, 2] < 0.5))
        if not len(ids):
            return
        c = self.character
        feet = self._position[ids]
        ground, slope = self._columns.highest(feet, 1.5 * c.step_height_m + 0.1, 0.05)
        # A sphere resting on a plane touches it uphill of its lowest point, which therefore hangs above.
        target = ground + c.radius_m * (1.0 / np.maximum(slope, 1e-3) - 1.0)
        drop = feet[:, 2] - target
        good = np.isfinite(ground) & (slope >= self._controller.slope_cos) & (drop > -0.02)
        good &= drop <= c.step_height_m
        ids = ids[good]
        lowered = feet[good]
        lowered[:, 2] = target[good]
        still = self._velocity[ids]
        still[:, 2] = 0.0
        self._footing[self._try_place(ids, lowered, still, on_ground=True)] = 1.0

    def _try_place(self, ids: Ints, positions: Floats, velocities: Floats, on_ground: bool = False) -> Ints:
        """Move agents [n] where there is room (and ground, if asked); returns those that moved."""
        if not len(ids):
            return ids
        kept = self._position[ids], self._velocity[ids]
        self._position[ids], self._velocity[ids] = positions, velocities
        self._refresh(ids)
        free = self._deepest()[ids] > -OVERLAP_M
        if on_ground:
            free &= self._contacts.walkable[ids].any(axis=1)
        back = ids[~free]
        if len(back):
            self._position[back], self._velocity[back] = kept[0][~free], kept[1][~free]
            self._refresh(back)
        return ids[free]

    # --- contacts ---------------------------------------------------------------------------------

    def _refresh(self, ids: Ints) -> None:
        """Contacts of states that were written from outside."""
        self._batch.touch(ids)
        self._contacts = self._read()

    def _read(self) -> Contacts:
        slope_cos, radius_m = self._controller.slope_cos, self.character.radius_m
        return read_contacts(self._batch.sensor, slope_cos, radius_m)

    def _deepest(self) -> Floats:
        """Signed distance [B] of the closest contact; positive where there is none."""
        found = self._batch.sensor[:, 0, 0] > 0
        return np.where(found, self._batch.sensor[:, 0, 1], np.inf)

    def _ended(self) -> NDArray[np.int8]:
        position = self._position
        low, high = self._bounds
        fell = (position[:, 2] < self._kill_z) | (position < low).any(axis=1) | (position > high).any(axis=1)
        reason = np.where(
            self._batch.diverged(), EndReason.DIVERGED, np.where(fell, EndReason.FELL, EndReason.ALIVE)
        )
        return reason.astype(np.int8)


# The first is the default.
SIMULATORS: dict[str, Callable[[Level, int, int], Simulator]] = {"mujoco": MujocoSimulator}
