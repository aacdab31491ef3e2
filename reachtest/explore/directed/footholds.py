"""Which islands of the nav-mesh, and floors off it, somebody stands on as the run goes: those no spawn is connected
to, too.

Shape legend: I islands and floors, G goals, P cached points.
"""

from __future__ import annotations

import numpy as np

from reachtest.explore.directed.places import NOWHERE
from reachtest.navmesh.coverage import STOOD_WITHIN_M
from reachtest.navmesh.faces import FaceIndex
from reachtest.navmesh.islands import Islands
from reachtest.records import Bools, Floats, Ints


class Footholds:
    """`stood` [I] are the islands that are connected to a spawn, and those that somebody got onto all the same."""

    def __init__(
        self, islands: Islands, connected: Bools, goal_island: Ints, floors: Islands | None = None
    ) -> None:
        """`connected` islands of the nav-mesh; `goal_island` [G] is that of each goal, -1 for none.

        The islands of `floors` off the nav-mesh count on from its own.
        """
        known = [islands] if floors is None else [islands, floors]
        self.stood: Bools = np.zeros(sum(some.count for some in known), dtype=np.bool_)
        self.stood[: islands.count] = connected
        self.island: Ints = np.empty(0, dtype=np.int64)  # [P] that cached points stand on, NOWHERE for none
        self._goal_island = goal_island
        self._known = [
            (some.labels + first, FaceIndex(some.navmesh.triangles, STOOD_WITHIN_M))
            for some, first in zip(known, (0, islands.count), strict=False)
            if some.count
        ]

    @property
    def goals(self) -> Bools:
        """The goals [G] on islands that somebody stood on."""
        return np.asarray((self._goal_island >= 0) & self.stood[self._goal_island], dtype=np.bool_)

    def note(self, positions: Floats, grounded: Bools) -> None:
        """Look at the cached points [P, 3] that are new since the last time, where they stand on the ground."""
        seen = len(self.island)
        if len(positions) == seen:  # both who aims and who pushes ask, in one round
            return
        new = np.full(len(positions) - seen, NOWHERE)
        rows = np.flatnonzero(grounded[seen:])
        for labels, faces in self._known:
            face, _ = faces.below(positions[seen + rows], STOOD_WITHIN_M, STOOD_WITHIN_M)
            new[rows[face >= 0]] = labels[face[face >= 0]]
            rows = rows[face < 0]  # who is on the nav-mesh is on no floor off it
        self.island = np.append(self.island, new)
        self.stood[new[new != NOWHERE]] = True
