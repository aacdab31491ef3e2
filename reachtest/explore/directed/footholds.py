"""Which islands of the nav-mesh somebody stands on, as the run goes: those no spawn is connected to, too.

Shape legend: I islands, G goals, P cached points.
"""

from __future__ import annotations

import numpy as np

from reachtest.navmesh.coverage import STOOD_WITHIN_M
from reachtest.navmesh.faces import FaceIndex
from reachtest.navmesh.islands import Islands
from reachtest.records import Bools, Floats, Ints


class Footholds:
    """`stood` [I] are the islands that are connected to a spawn, and those that somebody got onto all the same."""

    def __init__(self, islands: Islands, connected: Bools, goal_island: Ints) -> None:
        """`connected` [I] islands; `goal_island` [G] is the island of each goal, -1 for none."""
        self.stood: Bools = connected.copy()
        self._goal_island, self._seen = goal_island, 0
        apart = ~connected[islands.labels]
        self._island = islands.labels[apart]  # of each face of `_faces`
        self._faces = FaceIndex(islands.navmesh.triangles[apart], STOOD_WITHIN_M)

    @property
    def goals(self) -> Bools:
        """The goals [G] on islands that somebody stood on."""
        return np.asarray((self._goal_island >= 0) & self.stood[self._goal_island], dtype=np.bool_)

    def note(self, positions: Floats, grounded: Bools) -> None:
        """Look at the cached points [P, 3] that are new since the last time, where they stand on the ground."""
        new = positions[self._seen :][grounded[self._seen :]]
        self._seen = len(positions)
        if len(self._island) and len(new):
            face, _ = self._faces.below(new, STOOD_WITHIN_M, STOOD_WITHIN_M)
            self.stood[self._island[face[face >= 0]]] = True
