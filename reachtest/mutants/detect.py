"""Whether a run found a mutant: a finding of a kind that tells it, at its place, that the run without it lacks."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial import cKDTree

from reachtest.baseline.place import Place, match
from reachtest.mutants.decide import Change
from reachtest.mutants.records import Mutant
from reachtest.records import Bools, Finding, Floats

NEAR_M = 6.0  # paths leave the nav-mesh up to 3 m beside a hole, and at a run
_AREA_M = 3.0  # of what is cut off, an unreached area may lie beside it


def found_by(
    mutant: Mutant, change: Change, findings: Sequence[Finding], without: Sequence[Finding]
) -> Finding | None:
    """The finding that tells the mutant, of those that the unmutated level does not give; None: it was missed."""
    known = match([Place.of(f) for f in findings], [Place.of(f) for f in without])
    new = [finding for finding, old in zip(findings, known, strict=True) if old is None]
    telling = [finding for finding in new if finding.kind in mutant.expected and _at(mutant, change, finding)]
    return min(telling, key=lambda finding: mutant.expected.index(finding.kind), default=None)


def unreached_in(change: Change, goals: Floats, reached: Bools) -> int:
    """How many goals [G] of what a mutant cut off were not reached."""
    if "lost" not in change.reasons:
        return 0
    away, _ = cKDTree(change.places).query(goals)
    return int(((np.asarray(away) <= 1.0) & ~reached).sum())


def _at(mutant: Mutant, change: Change, finding: Finding) -> bool:
    """Whether a finding is at the mutant: where paths left the nav-mesh, else its own place."""
    if finding.kind == "inside_solid":
        return "mutant" in finding.title
    low, high = mutant.box.bounds
    points = finding.position[None]
    if finding.exits is not None and len(finding.exits):
        points = finding.exits
    elif finding.exit_point is not None:
        points = finding.exit_point[None]
    apart = np.maximum(np.maximum(low - points, points - high), 0.0)
    if np.linalg.norm(apart, axis=1).min() <= NEAR_M:
        return True
    if "lost" not in change.reasons:
        return False
    beyond = np.maximum(np.maximum(finding.low - change.places, change.places - finding.high), 0.0)
    return bool(np.linalg.norm(beyond, axis=1).min() <= _AREA_M)
