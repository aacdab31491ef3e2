"""A level in small pieces: a partition of space into tiles, and their models, compiled when somebody comes by.

A physics step costs what lies near, not what the level holds. A tile is a function of position alone, and holds
everything a character in its box can touch before it is asked for again, in the level's own order: so results
do not depend on how the level was cut.

Shape legend: N nodes, B agents.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from reachtest.records import Character, Floats, Ints
from reachtest.world.model import SKIN_M
from reachtest.world.pieces import PRISM_M, Pieces

TARGET_PIECES = 384  # half of it takes twice the tiles to compile and steps no faster: measured
MODELS_MB = 1536.0  # of compiled tiles kept, least recently used first to go


@dataclass(frozen=True)
class Margin:
    """How far from a tile's box a character that started the tick in it may have to be stopped."""

    low: Floats  # [3] towards smaller coordinates
    high: Floats  # [3]


def margin_for(character: Character, timestep_s: float) -> Margin:
    """What one tick can reach: a fall at terminal speed, deflected to any side; a capsule; a step up or down."""
    c = character
    travel = max(c.terminal_speed_mps, c.walk_speed_mps, c.jump_speed_mps) * timestep_s
    slack = SKIN_M + PRISM_M + 0.05
    side = travel + c.radius_m + slack
    rise = max(c.walk_speed_mps, c.jump_speed_mps) * timestep_s
    return Margin(
        np.array([side, side, travel + c.step_height_m + slack]),
        np.array([side, side, rise + c.height_m + c.step_height_m + slack]),
    )


def partition(pieces: Pieces, margin: Margin, target: int) -> Partition:
    """Tiles of about `target` pieces.

    All models have room for the fullest tile, so where one cannot be cut further the others need not be smaller.
    """
    tiles = Partition(pieces, margin, target)
    return Partition(pieces, margin, tiles.capacity) if tiles.capacity > target else tiles


class Partition:
    """A k-d tree whose leaves are tiles; every point of space lies in exactly one."""

    def __init__(self, pieces: Pieces, margin: Margin, target: int) -> None:
        """Cut until a tile touches at most `target` of the pieces, where that is possible."""
        # What a margin below reaches from above: the box of a piece grows the other way round.
        self._low, self._high = pieces.low - margin.high, pieces.high + margin.low
        self._least = margin.low + margin.high  # of what is smaller both halves would hold nearly the same
        self._target = target
        self._axis: list[int] = []  # [N] -1: a leaf
        self._cut: list[float] = []  # [N] or, of a leaf, its tile
        self._child: list[tuple[int, int]] = []  # [N]
        self.members: list[Ints] = []  # of every tile: its pieces, ascending
        self._boxes: list[tuple[Floats, Floats]] = []
        low, high = np.zeros((2, 3))  # nothing to cut
        if len(pieces):
            low, high = pieces.low.min(axis=0), pieces.high.max(axis=0)
        self._build(np.arange(len(pieces)), low, high, np.full(3, -np.inf), np.full(3, np.inf))
        self.low = np.array([low for low, _ in self._boxes])  # [tiles, 3] boxes, half open
        self.high = np.array([high for _, high in self._boxes])
        self._nodes = np.array(self._axis), np.array(self._cut), np.array(self._child)

    def __len__(self) -> int:
        return len(self.members)

    @property
    def capacity(self) -> int:
        """Pieces of the fullest tile."""
        return max(len(members) for members in self.members)

    def find(self, points: Floats) -> Ints:
        """The tile [n] of each point [n, 3]; some tile for NaN."""
        axis, cut, child = self._nodes
        node = np.zeros(len(points), dtype=np.int64)
        rows = np.arange(len(points))
        while (inner := axis[node] >= 0).any():
            ask = node[inner]
            right = points[rows[inner], axis[ask]] >= cut[ask]
            node[inner] = child[ask, right.astype(np.int64)]
        return cut[node].astype(np.int64)

    def _build(self, members: Ints, low: Floats, high: Floats, open_low: Floats, open_high: Floats) -> int:
        """Node of a box: `low` to `high` where there is geometry, `open_low` to `open_high` of all space."""
        node = len(self._axis)
        spare = (high - low) / self._least
        axis = int(spare.argmax())
        if len(members) <= self._target or spare[axis] < 1.0:
            self._add(-1, float(len(self.members)), (-1, -1))
            self.members.append(members)
            self._boxes.append((open_low, open_high))
            return node
        cut = float(low[axis] + high[axis]) / 2
        self._add(axis, cut, (-1, -1))
        below, above = members[self._low[members, axis] <= cut], members[self._high[members, axis] >= cut]
        left = self._build(below, low, _cut(high, axis, cut), open_low, _cut(open_high, axis, cut))
        right = self._build(above, _cut(low, axis, cut), high, _cut(open_low, axis, cut), open_high)
        self._child[node] = (left, right)
        return node

    def _add(self, axis: int, cut: float, child: tuple[int, int]) -> None:
        self._axis.append(axis)
        self._cut.append(cut)
        self._child.append(child)


def _cut(corner: Floats, axis: int, at: float) -> Floats:
    """The corner [3] of a box, moved to a cut."""
    moved = corner.copy()
    moved[axis] = at
    return moved


class TileModels:
    """The tiles' compiled models, as many as fit into memory."""

    def __init__(self, compile_tile: Callable[[int], mujoco.MjModel], limit_mb: float = MODELS_MB) -> None:
        self._compile, self._limit = compile_tile, limit_mb * 1e6
        self._models: OrderedDict[int, mujoco.MjModel] = OrderedDict()
        self._bytes = 0
        self.compiled = 0

    def get(self, tile: int, in_use: Sequence[int] | Ints = ()) -> mujoco.MjModel:
        """The model of a tile. Those `in_use` are not dropped to make room for it."""
        model = self._models.get(tile)
        if model is None:
            self._models[tile] = model = self._compile(tile)
            self._bytes += model.nbuffer
            self.compiled += 1
            self._make_room({tile, *(int(used) for used in in_use)})
        self._models.move_to_end(tile)
        return model

    def _make_room(self, keep: set[int]) -> None:
        for tile in [tile for tile in self._models if tile not in keep]:
            if self._bytes <= self._limit:
                return
            self._bytes -= self._models.pop(tile).nbuffer
