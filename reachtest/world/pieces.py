"""What characters collide with: convex pieces.

Shape legend: N pieces, C corners of the one that has most.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from reachtest.records import Bools, Floats, Ints

PRISM_M = 0.03  # thick enough to be hit by walking characters, thin enough for double-sided walls
CORNERS = 8  # of a box: there is room for as many at the least


@dataclass(frozen=True)
class Pieces:
    """Convex pieces, each the hull of `corners`; a box where `half` says so."""

    corners: Floats  # [N, C, 3] where a piece has fewer, its last are repeated
    count: Ints  # [N] corners that are no repetitions
    half: Floats  # [N, 3] half extents of a box along its axes; NaN: not a box
    axes: Floats  # [N, 3, 3] the box's axes as columns, right-handed; identity elsewhere

    def __len__(self) -> int:
        return len(self.corners)

    @property
    def low(self) -> Floats:
        """Smallest coordinates [N, 3]."""
        return np.asarray(self.corners.min(axis=1))

    @property
    def high(self) -> Floats:
        """Largest coordinates [N, 3]."""
        return np.asarray(self.corners.max(axis=1))

    @property
    def is_box(self) -> Bools:
        """Which pieces [N] are boxes."""
        return np.isfinite(self.half[:, 0])

    def take(self, ids: Ints) -> Pieces:
        """The pieces `ids` [n]."""
        return Pieces(self.corners[ids], self.count[ids], self.half[ids], self.axes[ids])


def joined(parts: list[Pieces]) -> Pieces:
    """All pieces, with room for the corners of the roundest."""
    most = max(part.corners.shape[1] for part in parts)
    corners = [np.pad(p.corners, ((0, 0), (0, most - p.corners.shape[1]), (0, 0)), "edge") for p in parts]
    rest = (np.concatenate([getattr(part, name) for part in parts]) for name in ("count", "half", "axes"))
    return Pieces(np.concatenate(corners), *rest)
