"""Hand-made nav-meshes: rectangles, each with vertices of its own unless it is said to share them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from reachtest.records import Floats, NavAgent, NavLink, NavMesh

REAL = Path(__file__).resolve().parents[3] / "maps/real"
SHARED = Path(__file__).resolve().parents[4] / "shared/levels"


def rectangle(low: Sequence[float], high: Sequence[float], z: float = 0.0, rise: float = 0.0) -> Floats:
    """Two triangles [2, 3, 3] at height `z`, `rise` higher at the end of x."""
    (a, b), (c, d) = low, high
    corners = np.array([[a, b, z], [c, b, z + rise], [c, d, z + rise], [a, d, z]], dtype=float)
    return corners[[[0, 1, 2], [0, 2, 3]]]


def navmesh(*pieces: Floats, links: Sequence[NavLink] = (), agent: NavAgent | None = None) -> NavMesh:
    """A nav-mesh of triangles [.., 3, 3] that share no vertex numbers."""
    triangles = np.concatenate(pieces)
    faces = np.arange(3 * len(triangles)).reshape(-1, 3)
    return NavMesh("nav.obj", triangles.reshape(-1, 3), faces, agent=agent or NavAgent(), links=tuple(links))


def link(
    start: Sequence[float], end: Sequence[float], both_ways: bool = False, kind: str = "jump"
) -> NavLink:
    """A link of 0.3 m radius."""
    return NavLink(kind, np.array(start, dtype=float), np.array(end, dtype=float), 0.3, both_ways)
