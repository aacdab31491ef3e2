"""All exercises of one character side by side in walled lanes: one level."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from kit.mesh import Mesh, nodes
from kit.navmesh import navmesh
from kit.pieces import Corner, Piece, Rect, box

from gym.exercise import Character, Exercise, apex
from gym.table import EXERCISES

WALL_M = 0.5  # thickness
APART_M = 1.0  # between two lanes' walls: nobody gets there
ABOVE_M = 3.0  # of a lane's walls over what a jump from its highest place reaches


@dataclass(frozen=True)
class Lane:
    """An exercise at its place in the level, `north` [m] of where it was made."""

    name: str
    exercise: Exercise
    walls: tuple[Piece, ...]
    north: float

    def at(self, corner: Corner) -> Corner:
        """A place of the exercise in the level."""
        return corner[0], corner[1] + self.north, corner[2]

    def moved(self, piece: Piece) -> Piece:
        """A piece of the exercise in the level, as part of the node of its lane."""
        return replace(piece, name=self.name, low=self.at(piece.low), high=self.at(piece.high))

    @property
    def spawn(self) -> Corner:
        """Where its character starts in the level."""
        return self.at(self.exercise.spawn or self.exercise.start)


def lanes(c: Character) -> list[Lane]:
    """Every exercise there is for `c`, from south to north."""
    found, north = [], 0.0
    for name, build in EXERCISES.items():
        exercise = build(c)
        if exercise is None:
            continue
        ground = exercise.pieces[0].footprint
        north = float(np.ceil(north - ground.y0 + WALL_M + APART_M))
        found.append(Lane(name, exercise, tuple(_walls(exercise, apex(c) + ABOVE_M)), north))
        north += ground.y1 + WALL_M
    return found


def _walls(exercise: Exercise, above_m: float) -> Iterator[Piece]:
    ground = exercise.pieces[0]
    top = max(0.0, *(piece.high[2] for piece in exercise.pieces)) + above_m
    inner, outer = ground.footprint, ground.footprint.inset(-WALL_M)
    sides = (
        Rect(outer.x0, outer.y0, inner.x0, outer.y1),
        Rect(inner.x1, outer.y0, outer.x1, outer.y1),
        Rect(inner.x0, outer.y0, inner.x1, inner.y0),
        Rect(inner.x0, inner.y1, inner.x1, outer.y1),
    )
    for side in sides:
        yield box("wall", "block", side, ground.low[2], top)


def meshes(hall: list[Lane]) -> list[Mesh]:
    """One node a lane, and one for what of it no piece can be."""
    pieces = [lane.moved(piece) for lane in hall for piece in (*lane.exercise.pieces, *lane.walls)]
    more = [lane for lane in hall if len(lane.exercise.triangles)]
    return nodes(pieces) + [_shapes(lane) for lane in more]


def _shapes(lane: Lane) -> Mesh:
    corners = lane.exercise.triangles.reshape(-1, 3)
    vertices, faces = np.unique(corners.round(6), axis=0, return_inverse=True)
    return Mesh(f"{lane.name} (shapes)", vertices, faces.reshape(-1, 3), np.array([0.0, lane.north, 0.0]))


def walkable(hall: list[Lane]) -> Mesh:
    """The nav-mesh of all lanes."""
    pieces = [(lane, lane.exercise.nav or lane.exercise.pieces) for lane in hall]
    return navmesh([lane.moved(piece) for lane, some in pieces for piece in (*some, *lane.walls)])
