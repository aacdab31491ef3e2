"""What makes a mesh unusable, or a triangle no surface.

Shape legend: F triangles.
"""

from __future__ import annotations

import numpy as np

from reachtest.levels.fields import FARTHEST
from reachtest.levels.meshes.scene import Piece
from reachtest.records import Bools, Floats

THINNEST_M = 1e-6  # below the resolution of 32-bit coordinates in any level: no surface, only rounding


def defects(pieces: list[Piece], file: str) -> list[tuple[str, str]]:
    """What makes a mesh unusable, as found and remedy."""
    found: list[tuple[str, str]] = []
    if not any(len(piece.faces) for piece in pieces):
        found.append(
            (f"{file} holds no triangles", "export the mesh's faces, not only points, lines or empties")
        )
    for piece in pieces:
        count = len(piece.vertices)
        bad = ~(np.abs(piece.vertices) <= FARTHEST).all(axis=1)  # also NaN
        if bad.any():
            first = int(np.argmax(bad))
            text = f"{file}: {bad.sum()} of {count} vertices of {piece.name!r} are NaN, infinite or beyond {FARTHEST:g}"
            place = ", ".join(f"{value:g}" for value in piece.vertices[first])
            remedy = (
                "repair the mesh (in Blender: Mesh > Clean Up) or its node's transform, and export it again"
            )
            found.append((f"{text}, the first is vertex {first} at ({place})", remedy))
        out = ((piece.faces < 0) | (piece.faces >= count)).any(axis=1)
        if out.any():
            first = int(np.argmax(out))
            text = f"{file}: {out.sum()} faces of {piece.name!r} name vertices outside of 0 to {count - 1}"
            found.append(
                (f"{text}, the first is face {first}: {piece.faces[first].tolist()}", "export it again")
            )
    return found


def degenerate(triangles: Floats) -> Bools:
    """Which triangles [F, 3, 3] are thinner than a micrometre, and so no surface [F]."""
    edges = triangles - np.roll(triangles, 1, axis=1)
    longest = np.sqrt(np.einsum("fij,fij->fi", edges, edges).max(axis=1, initial=0.0))
    area = np.linalg.norm(np.cross(edges[:, 1], edges[:, 2]), axis=1) / 2
    return np.asarray(2 * area <= THINNEST_M * longest)
