"""One way into a space is one bug, though within the 3 m in which a character is expected paths spread.

Behind a gap in a wall they still count as expected for a few metres, and leave the expected far apart: all around
the outside of a thin wall. So two spaces are one bug where the ways to both left the nav-mesh itself at one place, or
near to it if they touch; those ways are simulated again.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial import cKDTree

from reachtest.findings.evidence import Evidence
from reachtest.records import Fall, Floats, Ints

_SAME_EXIT_M = 1.5  # what lies between two spaces may count as expected, along the outside of a wall
_TOUCH_M = 4.0  # cached standing places of one area are hardly farther apart


@dataclass(frozen=True)
class Space:
    """Where somebody stood off the nav-mesh behind one exit."""

    points: Ints  # [k] indices of cached points
    falls: tuple[Fall, ...]  # that began there


def join_spaces(evidence: Evidence, spaces: Sequence[Space], link_m: float) -> list[int]:
    """The smallest index of a space of the same bug, for each space.

    Empty ones stay by themselves.
    """
    cached = evidence.exploration.points.positions
    stood = [
        np.concatenate([cached[space.points], *(fall.footing[None] for fall in space.falls)])
        for space in spaces
    ]
    trees = [cKDTree(places.reshape(-1, 3)) for places in stood]
    label, exits = list(range(len(spaces))), [_Exit(evidence, space) for space in spaces]
    for one in range(len(spaces)):
        for other in range(one + 1, len(spaces)):
            first, second = label[one], label[other]
            if first == second or not len(stood[one]) or not len(stood[other]):
                continue
            touch = trees[one].count_neighbors(trees[other], _TOUCH_M)
            # NaN, where a way never was on the nav-mesh, is near to nothing.
            if np.linalg.norm(exits[one].place - exits[other].place) <= (link_m if touch else _SAME_EXIT_M):
                label = [min(first, second) if mine in (first, second) else mine for mine in label]
    return label


class _Exit:
    """Where the shortest way to a space left the nav-mesh itself; simulated once, when asked for."""

    def __init__(self, evidence: Evidence, space: Space) -> None:
        self._evidence, self._space = evidence, space

    @cached_property
    def place(self) -> Floats:
        """[3]; NaN if the way never was on the nav-mesh."""
        evidence, space = self._evidence, self._space
        if len(space.points):
            nearest = int(space.points[evidence.steps_from_spawn[space.points].argmin()])
            way = evidence.replayer.path_to_point(nearest)
        else:
            way = evidence.replayer.path_to_fall(min(space.falls, key=evidence.steps_of_fall))
        left = evidence.navmesh_itself.last_of(way.positions)
        return np.full(3, np.nan) if left is None else way.positions[left]
