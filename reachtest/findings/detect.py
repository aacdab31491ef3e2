"""The detectors: each turns evidence into clusters of one or two kinds.

To add a kind: write the detector and name it in DETECTORS.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from reachtest.findings.build import Cluster, build_finding
from reachtest.findings.cluster import single_linkage
from reachtest.findings.evidence import Evidence
from reachtest.interfaces import Replayer
from reachtest.records import Exploration, Finding, Floats, Ints, Level

LINK_M = 4.0  # exits and areas closer than this are one bug: a little more than "expected" reaches
NO_POINTS: Ints = np.empty(0, dtype=np.int64)


def escapes(evidence: Evidence) -> list[Cluster]:
    """Where the character left the nav-mesh: `fell_out_of_world` where it fell, else `unexpected_area`.

    One bug has one exit: evidence is grouped by where its path left the nav-mesh. What was only flown
    through (a jump off a tower onto the nav-mesh again) is no evidence: somebody must have stood or fallen.
    """
    points = evidence.exploration.points
    off_mesh = ~points.expected & (evidence.solid_of < 0) & (evidence.in_zones("forbidden") < 0)
    chosen = np.flatnonzero(off_mesh & (evidence.in_zones("allowed_off_mesh") < 0))
    falls = evidence.exploration.falls
    exits = np.concatenate(
        [_anchors(points.exit_point[chosen], points.positions[chosen])]
        + [_anchors(fall.exit_point[None], fall.footing[None]) for fall in falls]
    )
    clusters = []
    for group in single_linkage(exits, LINK_M):
        some = chosen[group[group < len(chosen)]]
        fell = tuple(falls[i - len(chosen)] for i in group[group >= len(chosen)])
        if not fell and not points.grounded[some].any():
            continue
        # Bounds of where somebody stood: what is flown through below an edge is not the place to look at.
        footings = np.array([f.footing for f in fell]).reshape(-1, 3)
        places = np.concatenate([points.positions[some[points.grounded[some]]], footings])
        kind = "fell_out_of_world" if fell else "unexpected_area"
        clusters.append(Cluster(kind, "", some, fell, places))
    return clusters


def _anchors(exits: Floats, positions: Floats) -> Floats:
    """Exit points, or the positions themselves where the path never was on the nav-mesh."""
    return np.where(np.isnan(exits), positions, exits)


def inside_solids(evidence: Evidence) -> list[Cluster]:
    """Who got into a solid: one bug for each of them."""
    return _by_label(evidence, "inside_solid", evidence.solid_of, [s.name for s in evidence.level.solids])


def forbidden_zones(evidence: Evidence) -> list[Cluster]:
    """Who got into a forbidden zone: one bug for each of them."""
    zones = evidence.in_zones("forbidden")
    return _by_label(evidence, "forbidden_zone", zones, [zone.name for zone in evidence.level.zones])


def _by_label(evidence: Evidence, kind: str, member: Ints, labels: list[str]) -> list[Cluster]:
    positions = evidence.exploration.points.positions
    groups = [np.flatnonzero(member == index) for index in range(len(labels))]
    return [
        Cluster(kind, label, group, (), positions[group])
        for label, group in zip(labels, groups, strict=True)
        if len(group)
    ]


def unreached_areas(evidence: Evidence) -> list[Cluster]:
    """Goals that nobody came near, grouped by area."""
    exploration = evidence.exploration
    missing = exploration.goals[exploration.goal_step < 0]
    link = 2 * exploration.settings.goal_spacing_m
    groups = single_linkage(missing, link)
    return [Cluster("unreached_area", "", NO_POINTS, (), missing[group]) for group in groups]


def required_points(evidence: Evidence) -> list[Cluster]:
    """Required points that nobody came near."""
    pairs = zip(evidence.level.required, evidence.exploration.required_step, strict=True)
    return [
        Cluster("required_unreached", place.name, NO_POINTS, (), place.position[None])
        for place, step in pairs
        if step < 0
    ]


DETECTORS: tuple[Callable[[Evidence], list[Cluster]], ...] = (
    escapes,
    inside_solids,
    forbidden_zones,
    required_points,
    unreached_areas,
)


def find(level: Level, exploration: Exploration, replayer: Replayer) -> tuple[Finding, ...]:
    """All findings: gating ones first, then by kind, size and place."""
    evidence = Evidence(level, exploration, replayer)
    clusters = [cluster for detector in DETECTORS for cluster in detector(evidence)]
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
