"""The detectors: each turns evidence into clusters of one or two kinds.

To add a kind: write the detector and name it in DETECTORS.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from reachtest.findings.build import Cluster, build_finding
from reachtest.findings.effort import describe_required, required_tried
from reachtest.findings.escapes import escapes
from reachtest.findings.evidence import Evidence
from reachtest.findings.islands import unconnected_islands, unreached_areas
from reachtest.findings.mismatch import navmesh_mismatch
from reachtest.findings.stuck import no_returns, stuck_places
from reachtest.interfaces import Replayer, Teller
from reachtest.navmesh.survey import Survey
from reachtest.offlimits import SOLID, ZONE
from reachtest.records import Exploration, Finding, Ints, Level

NO_POINTS: Ints = np.empty(0, dtype=np.int64)


def inside_solids(evidence: Evidence) -> list[Cluster]:
    """Who got into a solid: one bug for each of them."""
    return _trespasses(evidence, SOLID)


def forbidden_zones(evidence: Evidence) -> list[Cluster]:
    """Who got into a forbidden zone: one bug for each of them."""
    return _trespasses(evidence, ZONE)


def _trespasses(evidence: Evidence, kind: str) -> list[Cluster]:
    """A cluster for everything off limits that somebody was seen in: cached, or between cached points."""
    positions, between = evidence.exploration.points.positions, evidence.exploration.trespasses
    result = []
    for (this, name), inside in evidence.off_limits.items():
        if this != kind:
            continue
        points = np.flatnonzero(inside)
        if len(points):
            result.append(Cluster(kind, name, points, (), positions[points]))
        elif (fall := between.get((kind, name))) is not None:
            result.append(Cluster(kind, name, NO_POINTS, (fall,), fall.position[None]))
    return result


def required_points(evidence: Evidence) -> list[Cluster]:
    """Required points that nobody came near; they gate once enough was done to get there."""
    exploration, required = evidence.exploration, evidence.level.required
    result = []
    for index in np.flatnonzero(exploration.required_step < 0).tolist():
        place = required[index]
        missed = Cluster("required_unreached", place.name, NO_POINTS, (), place.position[None])
        details, tried = describe_required(exploration, index), required_tried(exploration, index)
        result.append(replace(missed, details=details, never_gates=not tried))
    return result


DETECTORS: tuple[Callable[[Evidence], list[Cluster]], ...] = (
    escapes,
    inside_solids,
    forbidden_zones,
    stuck_places,
    no_returns,
    required_points,
    unreached_areas,
    unconnected_islands,
    navmesh_mismatch,
)


def find(
    level: Level,
    exploration: Exploration,
    replayer: Replayer,
    survey: Survey | None = None,
    tell: Teller = lambda what, number, total: None,
) -> tuple[Finding, ...]:
    """All findings: gating ones first, then by kind, size and place. `tell` hears which kind is looked for."""
    evidence = Evidence(level, exploration, replayer, survey)
    clusters = []
    for number, detector in enumerate(DETECTORS, 1):
        tell("telling findings apart", number, len(DETECTORS))
        clusters += detector(evidence)
    findings = [build_finding(evidence, cluster) for cluster in clusters]
    findings.sort(key=lambda f: (not f.gating, f.kind, -f.points, *f.position.round(3).tolist()))
    return tuple(_distinct(findings))


def _distinct(findings: list[Finding]) -> list[Finding]:
    """Two bugs at one place get different ids."""
    seen: dict[str, int] = {}
    result = []
    for finding in findings:
        seen[finding.id] = count = seen.get(finding.id, 0) + 1
        result.append(finding if count == 1 else replace(finding, id=f"{finding.id}-{count}"))
    return result
