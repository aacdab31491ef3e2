"""Where a bug is, and whether two runs saw the same one there.

Ids go by a coarse grid and change at its lines, so bugs are known again by kind and place. The place of a bug is where
paths left the nav-mesh, because one roof can have two holes that lead to it; where there are no such exits, it is
the box around the evidence. What has a name (a solid, a zone, a required point) is known by it and by nothing else:
its id is made from it.

Shape legend: n found, m known, e exits.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from reachtest.records import Finding, Floats

NAMED = frozenset({"inside_solid", "forbidden_zone", "required_unreached"})
CLOSE_M = 4.0  # as far apart, two exits of one run are one bug: findings/detect.py
NEAR_M = 8.0  # seeds jump off a little elsewhere; as far, one known bug accounts for one finding only

_COUNTED = re.compile(r"(.+-[0-9a-f]{8})-\d+")  # the second and further findings of one id


@dataclass(frozen=True)
class Place:
    """What of a finding says which bug it is."""

    id: str
    kind: str
    low: Floats  # [3] m
    high: Floats  # [3] m
    exits: Floats  # [e, 3] m; e = 0 where no path left the nav-mesh
    remark: bool = False  # on islands that nothing connects: one box around them all, which fails nothing

    @classmethod
    def of(cls, finding: Finding) -> Place:
        """The place of a finding of this run."""
        exits = finding.exits
        if exits is None:
            exits = np.empty((0, 3)) if finding.exit_point is None else finding.exit_point[None]
        return cls(finding.id, finding.kind, finding.low, finding.high, exits, is_remark(finding))

    def joined(self, other: Place) -> Place:
        """Both places of one bug together."""
        low, high = np.minimum(self.low, other.low), np.maximum(self.high, other.high)
        return replace(self, low=low, high=high, exits=np.concatenate([self.exits, other.exits]))


class _Told(Protocol):
    """A finding, of this run or of a report."""

    @property
    def kind(self) -> str: ...
    @property
    def gating(self) -> bool: ...
    @property
    def suppressed_by(self) -> str | None: ...


def is_remark(finding: _Told) -> bool:
    """Whether a finding tells of what nobody gets to, and would fail nothing if it were not known, either."""
    return finding.kind == "unreached_area" and not finding.gating and finding.suppressed_by is None


def gap_m(found: Place, known: Place) -> float:
    """How far apart two bugs are [m]; infinite where `found` cannot be what is known.

    They are of one kind, but that who fell out of a known hole may only be seen standing beyond it in another run.
    A fall where only standing was known is worse, and new; so is a part cut off where islands never were connected.
    """
    if known.remark and not found.remark:
        return np.inf
    if found.kind != known.kind and (found.kind, known.kind) != ("unexpected_area", "fell_out_of_world"):
        return np.inf
    if found.kind in NAMED:
        return 0.0 if _name(found.id) == _name(known.id) else np.inf
    if len(found.exits) and len(known.exits):
        return float(np.linalg.norm(found.exits[:, None] - known.exits[None], axis=2).min())
    # The middle of each in the box of the other: what spans the whole level is not what lies somewhere in it.
    return max(_outside_m(found, known), _outside_m(known, found))


def match(found: Sequence[Place], known: Sequence[Place]) -> list[int | None]:
    """For each of `found` [n] the index of the one of `known` [m] that it is; None where it is new.

    Everything within CLOSE_M of a known bug is that bug, also when chance split it in two. Of what is left, the
    nearest pairs within NEAR_M are taken, each known bug at most once: so a second hole beside a known one is new.
    """
    gaps = np.array([[gap_m(one, other) for other in known] for one in found]).reshape(len(found), len(known))
    result: list[int | None] = [None] * len(found)
    if not gaps.size:
        return result
    nearest = gaps.argmin(axis=1)
    for row in np.flatnonzero(gaps.min(axis=1) <= CLOSE_M).tolist():
        result[row] = int(nearest[row])
    taken = set(result)
    for row, column in zip(
        *np.unravel_index(np.argsort(gaps, axis=None, kind="stable"), gaps.shape), strict=True
    ):
        if gaps[row, column] > NEAR_M:
            break
        if result[row] is None and int(column) not in taken:
            result[row] = int(column)
            taken.add(int(column))
    return result


def _outside_m(one: Place, other: Place) -> float:
    """How far the middle of one place is outside the box of the other [m]."""
    middle = (one.low + one.high) / 2
    return float(np.linalg.norm(np.maximum(np.maximum(other.low - middle, middle - other.high), 0.0)))


def _name(id_: str) -> str:
    counted = _COUNTED.fullmatch(id_)
    return counted[1] if counted else id_
