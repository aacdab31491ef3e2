"""A MuJoCo batch whose simulations each run on the tile they are in.

Shape legend: B simulations, n chosen ones.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import mujoco
import numpy as np
from mujoco import batch

from reachtest.geometry import indices
from reachtest.records import Bools, Character, Floats, HeightField, Ints
from reachtest.world.convex import pieces_of
from reachtest.world.model import CONTACT_FIELDS, CONTACT_SLOTS, Template
from reachtest.world.tiles import TileModels, margin_for, partition

_FRESH = int(mujoco.mjtStage.mjSTAGE_VEL)  # contacts of the state just reached, at no extra cost


class TiledBatch:
    """One capsule a simulation in one level; `position`, `velocity`, `force` and `sensor` are live arrays."""

    def __init__(
        self,
        triangles: Floats,
        fields: Sequence[HeightField],
        character: Character,
        timestep_s: float,
        spawns: Floats,
        agents: int,
        threads: int,
        tile_pieces: int,
        tiles_mb: float,
    ) -> None:
        """Cut `triangles` [F, 3, 3] into tiles, each with all `fields`, for B `agents`.

        They begin on the tiles of `spawns` [S, 3].
        """
        # Else MuJoCo prints every warning, and writes it to a file in the working directory, too.
        mujoco.set_mju_user_warning(_is_counted)
        starts = spawns[np.arange(agents) % len(spawns)]
        self._pieces = pieces_of(triangles, spawns)
        self._partition = partition(self._pieces, margin_for(character, timestep_s), tile_pieces)
        self._template = Template(
            self._partition.capacity, character, timestep_s, fields, self._pieces.corners.shape[1]
        )
        self._models = TileModels(self._compile, tiles_mb)
        self._tile = self._partition.find(starts)
        self._running = [self._models.get(tile, self._tile) for tile in self._tile.tolist()]
        self._batch = batch.Batch(self._running[0], len(starts), nthread=threads, persistent=True)
        self._batch.set_models(self._running)
        self._failed = np.zeros(len(starts), dtype=np.bool_)
        self._batch.reset()
        self.use(len(starts))

    @property
    def tiles_compiled(self) -> int:
        """Compilations so far; more than there are tiles where memory was short."""
        return self._models.compiled

    @property
    def threads(self) -> int:
        """Threads that simulate."""
        return self._batch.nthread

    @property
    def size(self) -> int:
        """B."""
        return self._batch.nsim

    def use(self, count: int) -> None:
        """From now on only the first `count` simulations take part: they are B."""
        self._in_use = None if count == self.size else np.arange(count)
        self.position: Floats = self._batch.bind("qpos")[:count]  # [B, 3]
        self.velocity: Floats = self._batch.bind("qvel")[:count]  # [B, 3]
        self.force: Floats = self._batch.bind("qfrc_applied")[:count]  # [B, 3]
        sensor = self._batch.bind("sensordata")[:count]
        self.sensor: Floats = sensor.reshape(-1, CONTACT_SLOTS, CONTACT_FIELDS)

    def set_state(self, ids: Ints, position: Floats, velocity: Floats) -> None:
        """Start simulations [n] afresh from positions and velocities [n, 3]; follow with `enter_tiles` and `touch`."""
        self._batch.warning[ids] = 0
        self._failed[ids] = False
        self.position[ids], self.velocity[ids], self.force[ids] = position, velocity, 0.0

    def enter_tiles(self, only: Ints | None = None) -> None:
        """Put who left a tile (of all, or of `only` [n]) onto the next.

        What they touch does not change by that, but `sensor` says nothing of them until the next step or `touch`.
        """
        here, tile = self.position, self._tile[: len(self.position)]
        low, high = self._partition.low[tile], self._partition.high[tile]
        left: Bools = np.asarray(~((here >= low) & (here < high)).all(axis=1), dtype=np.bool_)
        ids = indices(left) if only is None else only[left[only]]
        if not len(ids):
            return
        self._tile[ids] = self._partition.find(here[ids])
        for simulation, tile in zip(ids.tolist(), self._tile[ids].tolist(), strict=True):
            self._running[simulation] = self._models.get(tile, self._tile)
        self._batch.set_models(self._running)
        # MjData keeps the poses of static geoms while they sleep: only a reset moves it to other ones. The
        # reset also forgets warnings, and the state.
        self._failed[ids] |= (self._batch.warning[ids, :, 1] > 0).any(axis=1)
        kept = self.position[ids], self.velocity[ids]
        self._batch.reset(ids, stage=mujoco.mjtStage.mjSTAGE_NONE)
        self.position[ids], self.velocity[ids] = kept

    def step(self) -> None:
        """One physics step of everybody under `force`, and the contacts where it led."""
        self._call(lambda: self._batch.step(self._in_use, nstep=1, stage=_FRESH))

    def touch(self, ids: Ints) -> None:
        """Contacts of states [n] that were written from outside."""
        self._call(lambda: self._batch.forward(ids, stage=_FRESH))

    def deepest(self, ids: Ints | slice = slice(None)) -> Floats:
        """Signed distance of the closest contact [m] of all, or of simulations [n]; infinite where there is none."""
        closest = self.sensor[ids, 0]
        return np.where(closest[:, 0] > 0, closest[:, 1], np.inf)

    def diverged(self) -> Bools:
        """Which simulations [B] failed since `set_state`: an error, a warning, or numbers that are none."""
        count = len(self.position)
        finite = np.isfinite(self.position).all(axis=1) & np.isfinite(self.velocity).all(axis=1)
        warned = (self._batch.warning[:count, :, 1] > 0).any(axis=1)
        return np.asarray(self._failed[:count] | ~finite | warned, dtype=np.bool_)

    def _compile(self, tile: int) -> mujoco.MjModel:
        return self._template.fill(self._pieces.take(self._partition.members[tile]))

    def _call(self, run: Callable[[], None]) -> None:
        try:
            run()
        except batch.SimulationError as error:
            self._failed[error.ids] = True


def _is_counted(warning: str) -> None:
    """Say nothing: `diverged` tells, and the report how often."""
