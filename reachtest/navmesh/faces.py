"""Which face of a nav-mesh a point stands on: straight above one if it can be, else the nearest."""

from __future__ import annotations

import numpy as np

from reachtest.columns import Columns
from reachtest.geometry import point_triangle_distance
from reachtest.records import Bools, Floats, Ints

_CELL_M = 2.0  # or a face, if they are larger: then each stands in a few cells


class FaceIndex:
    """The faces of a nav-mesh, asked for by place."""

    def __init__(self, triangles: Floats, reach_m: float) -> None:
        """Index triangles [F, 3, 3]; `reach_m` is how far away a face beside a point may be."""
        self._triangles, self._reach = triangles, reach_m
        sides = triangles.max(axis=1) - triangles.min(axis=1) if len(triangles) else np.zeros((1, 3))
        self._columns = Columns(triangles, reach_m, max(_CELL_M, reach_m, float(sides[:, :2].mean())))

    def below(self, points: Floats, down_m: float, up_m: float) -> tuple[Ints, Floats]:
        """The face [n] that each point [n, 3] stands on, and how far away it is [n] [m]; -1 and inf for none.

        First choice is the face straight below or above, by at most `down_m` or `up_m`, with the smallest drop;
        then the nearest face within reach.
        """
        face, away = np.full(len(points), -1), np.full(len(points), np.inf)
        for begin, end, row, member in self._columns.pairs(points):
            cost, gap = self._cost(points[begin:end][row], row, self._triangles[member], down_m, up_m)
            some = np.flatnonzero(np.isfinite(cost))
            order = some[np.lexsort((member[some], cost[some], row[some]))]
            best = order[np.append(True, row[order[1:]] != row[order[:-1]])[: len(order)]]
            face[begin + row[best]], away[begin + row[best]] = member[best], gap[best]
        return face, away

    def _cost(
        self, points: Floats, row: Ints, triangles: Floats, down_m: float, up_m: float
    ) -> tuple[Floats, Floats]:
        """Of pairs, of which those of one point have the same `row`: what to choose by (infinite: never), and the
        distance [m]. Who has a face straight below or above needs no distance to those beside."""
        inside, drop = height_above(points, triangles)
        column = inside & (drop <= down_m) & (drop >= -up_m)
        cost = gap = np.where(column, np.abs(drop), np.inf)
        if self._reach > 0:
            settled = np.bincount(row, weights=column) > 0
            beside = np.flatnonzero(~settled[row])
            near = point_triangle_distance(points[beside], triangles[beside])
            cost = gap.copy()
            cost[beside], gap[beside] = np.where(near <= self._reach, down_m + up_m + near, np.inf), near
        return cost, gap


def height_above(points: Floats, triangles: Floats) -> tuple[Bools, Floats]:
    """Of pairs: is the point [n, 3] straight above or below the triangle [n, 3, 3], and its height above [n] [m]."""
    a, u, v = triangles[:, 0], triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    away = points - a
    area = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    safe = np.where(area == 0, 1.0, area)
    s = (away[:, 0] * v[:, 1] - away[:, 1] * v[:, 0]) / safe
    t = (u[:, 0] * away[:, 1] - u[:, 1] * away[:, 0]) / safe
    edge = -1e-9  # so that a point on a shared edge belongs to one of the two at least
    inside = (area != 0) & (s >= edge) & (t >= edge) & (s + t <= 1 - edge)
    return np.asarray(inside), np.asarray(away[:, 2] - s * u[:, 2] - t * v[:, 2])
