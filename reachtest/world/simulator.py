"""B characters in one MuJoCo batch: plan, step, then the corrections a capsule on joints cannot make by itself.

Shape legend: B agents, n chosen agents. Positions are the feet.
A state row is position [3], velocity [3], footing [1]: the footing is 0 in the air, 1 on the ground, and 1 + k
while a step up is under way and has k control ticks left to find its ground; -1 for the first tick of a jam in the air.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from reachtest.columns import ColumnIndex
from reachtest.geometry import indices
from reachtest.interfaces import Simulator
from reachtest.records import Bools, EndReason, Floats, Ints, Level, StepResult
from reachtest.walking import STICK_DIRECTIONS
from reachtest.world.contacts import Contacts, read_contacts
from reachtest.world.controller import Controller, Plan, Stick
from reachtest.world.footwork import OVERLAP_M, Footwork
from reachtest.world.landing import Landings
from reachtest.world.model import MASS_KG
from reachtest.world.terrain import split_terrain
from reachtest.world.tiled_batch import TiledBatch
from reachtest.world.tiles import MODELS_MB, TARGET_PIECES
from reachtest.world.tunnelling import Barriers

STATE_SIZE = 7
JAMMED = -1.0  # footing of who was held at rest for a tick: after another one it has landed
STEP_S = 0.14  # enough to get from the foot of a step onto it at half the walking speed


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
        columns = ColumnIndex(level.collision, min_normal_z=0.05)
        self._controller = Controller(level.character, self._dt)
        spawns = np.array([spawn.position for spawn in level.spawns])
        self._batch = TiledBatch(
            *split_terrain(level), level.character, self._dt, spawns, agents, threads, tile_pieces, tiles_mb
        )
        self._footwork = Footwork(level.character, self._controller.slope_cos, self._batch, columns)
        slope_cos, radius_m = self._controller.slope_cos, level.character.radius_m
        self._barriers = Barriers(self._batch, columns, slope_cos, self._dt, radius_m)
        self._landings = Landings(self._batch, slope_cos, radius_m)
        self._ticks_to_land = np.ceil(STEP_S / self._dt)
        self._footing = np.zeros(agents)
        self.use(agents)

    @property
    def agents(self) -> int:
        """B, where all are in use."""
        return self._batch.size

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

    def use(self, agents: int) -> None:
        """From now on only the first `agents` take part: they are B. Who was not in use before is to be restored."""
        self._batch.use(agents)
        self._position, self._velocity = self._batch.position, self._batch.velocity
        self._footing = np.concatenate([self._footing, np.zeros(self.agents)])[:agents]
        self._contacts = self._read()

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
        self._batch.touch(agents)
        self._contacts = self._read()

    def save(self) -> Floats:
        """The states [B, 7] of all agents."""
        return np.concatenate([self._position, self._velocity, self._footing[:, None]], axis=1)

    def step(self, actions: NDArray[np.int8]) -> StepResult:
        """One agent step with `actions` [B, 2]: stick (0 to 8) and jump (0 or 1)."""
        stick = Stick(STICK_DIRECTIONS[actions[:, 0]], actions[:, 1] > 0, indices(actions[:, 0] == 0))
        stood = np.full((len(self._footing), 3), np.nan)
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
            result[begin : begin + len(some)] = self._batch.deepest()[: len(some)] > -OVERLAP_M
        return result

    # --- one control tick -------------------------------------------------------------------------

    def _tick(self, stick: Stick) -> None:
        before = self._footing > 0
        self._batch.enter_tiles()
        came_from = self._position.copy()
        plan = self._controller.plan(self._velocity, self._contacts, before, stick)
        self._barriers.stop_at_floors(plan.velocity)
        force = self._batch.force
        np.subtract(plan.velocity, self._velocity, out=force)
        force *= MASS_KG / self._dt
        force[:, 2] += MASS_KG * self.character.gravity_mps2
        self._batch.step()
        self._barriers.back_out(came_from)
        self._landings.correct(~before, came_from, plan.velocity)
        contacts = self._contacts = self._read()
        walked = before & ~plan.jumped
        stands = self._controller.grounded(self._velocity, contacts, walked)
        self._limit_boost(plan, walked, stands)
        jammed = self._controller.jammed(self._velocity, contacts, stands)
        stands[jammed] = self._footing[jammed] != 0
        self._footing = np.where(stands, 1.0, walked * np.maximum(self._footing - 1.0, 0.0))
        self._footing[jammed[~stands[jammed]]] = JAMMED
        if self.character.step_height_m > 0:
            self._follow_steps(plan, walked)

    def _follow_steps(self, plan: Plan, walked: Bools) -> None:
        """Up onto what blocks the way, down to ground that fell away: who `walked` [B] before the tick."""
        lifted = self._footwork.step_up(plan, self._contacts, walked)
        self._footing[lifted] = 1.0 + self._ticks_to_land
        lowered = self._footwork.snap_down(walked & (self._footing == 0))
        self._footing[lowered] = 1.0
        if len(lifted) or len(lowered):
            self._contacts = self._read()

    def _limit_boost(self, plan: Plan, walked: Bools, stands: Bools) -> None:
        """No throw without a jump: walking off a crest starts at rest, a steep surface only slows a fall."""
        allowed = np.where(walked, 0.0, np.maximum(plan.velocity[:, 2], 0.0))
        boosted = ~stands & (self._velocity[:, 2] > allowed)
        if boosted.any():
            self._velocity[boosted, 2] = allowed[boosted]

    # --- contacts ---------------------------------------------------------------------------------

    def _read(self) -> Contacts:
        slope_cos, radius_m = self._controller.slope_cos, self.character.radius_m
        return read_contacts(self._batch.sensor, slope_cos, radius_m)

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
