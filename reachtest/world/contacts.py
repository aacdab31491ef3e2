"""What the capsules touch: which of it carries, which is in the way, and which is neither.

Shape legend: B agents, K contact slots, n agents with obstacles. Normals point from the surface to the capsule.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from reachtest.geometry import indices
from reachtest.records import Bools, Floats, Ints

LEVEL_NXY = 0.02  # a normal with less of a horizontal part has no say in horizontal movement
FLUSH_M = 0.002  # an edge this little above the ground one stands on is part of it
LEANING_NXY = 0.1  # a normal with less of a horizontal part is a floor's, wherever its point is
WALL_NZ = 0.1  # a normal with less of a vertical part is a wall's
HIDDEN_M = 0.01  # ground that is no farther in front of a wall is the wall's


@dataclass(frozen=True)
class Contacts:
    """What the capsules touch."""

    normals: Floats  # [B, K, 3] zero in empty slots
    walkable: Bools  # [B, K]
    ids: Ints  # [n] agents that touch obstacles: walls, steep slopes, overhangs, all that is not ground
    flat: Floats  # [n, K, 2] horizontal unit normals of their obstacles, zero elsewhere


def read_contacts(sensor: Floats, slope_cos: float, radius_m: float) -> Contacts:
    """Sort the contact sensor's slots [B, K, 5] (found, dist, normal from the capsule)."""
    normals = -sensor[:, :, 2:]
    x, y, z = normals[:, :, 0], normals[:, :, 1], normals[:, :, 2]
    walkable = z >= slope_cos
    length = np.hypot(x, y)
    blocking = (length > LEVEL_NXY) & ~walkable
    ids = indices(blocking.any(axis=1))
    if not len(ids):
        return Contacts(normals, walkable, ids, np.empty((0, sensor.shape[1], 2)))
    solid, reach = blocking[ids], radius_m + sensor[ids, :, 1]
    stands = walkable[ids]
    _forget_hidden(stands, solid, normals[ids], length[ids], reach)
    walkable[ids] = stands
    _forget_flush(solid, normals[ids], reach, stands)
    scale = np.where(solid, 1.0 / np.maximum(length[ids], LEVEL_NXY), 0.0)
    return Contacts(normals, walkable, ids, normals[ids, :, :2] * scale[:, :, None])


def _forget_hidden(walkable: Bools, solid: Bools, normals: Floats, length: Floats, reach: Floats) -> None:
    """Take from the `walkable` [n, K], in place, what lies in or behind a wall: the edges of blocks it is made of.

    At a run a capsule gets some centimetres into a wall before it is stopped, and there every joint is a ledge.
    """
    leaning, wall = walkable & (length > LEANING_NXY), solid & (np.abs(normals[:, :, 2]) < WALL_NZ)
    rows = indices(leaning.any(axis=1) & wall.any(axis=1))
    if len(rows):
        hidden = (_in_front(normals[rows], reach[rows]) < HIDDEN_M) & wall[rows][:, None, :]
        walkable[rows] &= ~(leaning[rows] & hidden.any(axis=2))


def _forget_flush(solid: Bools, normals: Floats, reach: Floats, walkable: Bools) -> None:
    """Take from the obstacles `solid` [n, K], in place, what lies in the plane of a walkable contact: the upper edge
    of a ramp, a seam of a floor.

    What a sphere nearly touches a little ahead has a normal that leans back more than the ground's.
    """
    leaning = solid & (normals[:, :, 2] > 0)
    rows = indices(leaning.any(axis=1) & walkable.any(axis=1))
    if len(rows):
        flush = (_in_front(normals[rows], reach[rows]) < FLUSH_M) & walkable[rows][:, None, :]
        solid[rows] &= ~(leaning[rows] & flush.any(axis=2))


def _in_front(normals: Floats, reach: Floats) -> Floats:
    """How far [n, K, K] the point of each contact is in front of the plane of every other.

    All touch a sphere, its centre `reach` [n, K] from their points.
    """
    return np.asarray(reach[:, None, :] - reach[:, :, None] * (normals @ normals.transpose(0, 2, 1)))
