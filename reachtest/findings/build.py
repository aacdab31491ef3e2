"""Builds one Finding from a cluster of evidence: where to look, how to get there, how bad it is."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from reachtest.findings.cluster import thin_out
from reachtest.findings.evidence import Evidence
from reachtest.findings.gate import gates
from reachtest.records import Fall, Finding, Floats, Ints, ReplayPath

ERRORS = frozenset(
    {"unexpected_area", "fell_out_of_world", "inside_solid", "forbidden_zone", "stuck", "required_unreached"}
)
_SAME_FLIGHT_M = 1.0
_MOST_OTHERS = 3
_ID_GRID_M = 8.0  # coarse, so that the same bug seen a little elsewhere keeps its id


@dataclass(frozen=True)
class Cluster:
    """Evidence of one bug."""

    kind: str
    label: str  # what the title says of it: a solid's, a zone's or a required point's name
    points: Ints  # [n] indices of cached points
    falls: tuple[Fall, ...]
    places: Floats  # [m, 3] what the bounds enclose
    exits: Floats | None = None  # [k, 3] where the paths left the nav-mesh; of falls, in their order
    details: tuple[str, ...] = ()  # lines for people
    title: str = ""  # where the kind's own title does not say it
    count: int | None = None  # of whatever was found, where it is not the points or places
    never_gates: bool = False  # for information, whatever `fail_on` says
    standing: Floats | None = None  # [k, 3] of a pocket: where somebody stood or lay in it
    reach_m: float | None = None  # of a pocket: farthest that anybody got from where it began in it
    position: Floats | None = None  # [3] what to look at, where no evidence says it better


@dataclass(frozen=True)
class _Sight:
    position: Floats  # [3]
    exit_point: Floats | None  # [3]
    first_seen_step: int | None
    path: ReplayPath | None
    beyond: Floats | None = None  # [3] what to name it after, where that is not the exit


def build_finding(evidence: Evidence, cluster: Cluster) -> Finding:
    """The finding, with the shortest known way re-simulated."""
    sight = _representative(evidence, cluster)
    anchor = sight.position if sight.exit_point is None else sight.exit_point
    named = evidence.nearest_part(anchor if sight.beyond is None else sight.beyond)
    # What has a name of its own is known by it; other places by the part they are at and a coarse grid.
    where = cluster.label or f"{named} {np.floor(anchor / _ID_GRID_M).astype(int).tolist()}"
    digest = hashlib.sha256(f"{cluster.kind} {where}".encode()).hexdigest()
    severity = "error" if cluster.kind in ERRORS else "warning"
    return Finding(
        id=f"{cluster.kind}-{digest[:8]}",
        kind=cluster.kind,
        severity=severity,
        gating=not cluster.never_gates and gates(cluster.kind, severity, evidence.level.gate.fail_on),
        title=cluster.title or _title(cluster, named),
        position=sight.position,
        low=cluster.places.min(axis=0),
        high=cluster.places.max(axis=0),
        points=cluster.count or len(cluster.points) or len(cluster.places),
        exit_point=sight.exit_point,
        nearest_named=named,
        first_seen_step=sight.first_seen_step,
        path=sight.path,
        suppressed_by=None,
        exits=None if cluster.exits is None else thin_out(cluster.exits),
        details=cluster.details,
        standing=cluster.standing,
        reach_m=cluster.reach_m,
        target=cluster.label or None,
        others=_spread(cluster.falls, sight.position),
    )


def _representative(evidence: Evidence, cluster: Cluster) -> _Sight:
    """What to show of a cluster: its evidence with the shortest known way from a spawn."""
    if cluster.falls:
        chosen = min(_from_the_edge(cluster.falls), key=lambda i: evidence.steps_of_fall(cluster.falls[i]))
        fall = cluster.falls[chosen]
        first = min(evidence.seen_step(fall.origin) for fall in cluster.falls)
        path = evidence.replayer.path_to_fall(fall)
        # The edge, not where the jump began; from a wall's top it would be any edge.
        if cluster.exits is not None and evidence.navmesh_itself.holds(fall.footing[None])[0]:
            return _Sight(fall.footing, cluster.exits[chosen], first, path)
        exit_point, beyond = _left_at(evidence, path, fall.exit_point)
        return _Sight(fall.footing, exit_point, first, path, beyond)
    points = evidence.exploration.points
    if len(cluster.points):
        # Standing evidence first: a designer wants to be taken to where the character stands.
        standing = cluster.points[points.grounded[cluster.points]]
        some = standing if len(standing) else cluster.points
        index = int(some[evidence.steps_from_spawn[some].argmin()])
        first = min(evidence.seen_step(points.origin(int(i))) for i in cluster.points)
        path = evidence.replayer.path_to_point(index)
        expected, known = points.expected[index], points.exit_point[index]
        exit_point, beyond = (None, None) if expected else _left_at(evidence, path, known)
        return _Sight(points.positions[index], exit_point, first, path, beyond)
    if cluster.position is not None:
        return _Sight(cluster.position, None, None, None)
    middle = cluster.places.mean(axis=0)
    nearest = np.linalg.norm(cluster.places - middle, axis=1).argmin()
    return _Sight(cluster.places[nearest], None, None, None)


def _from_the_edge(falls: Sequence[Fall]) -> list[int]:
    """Which falls flew hardly farther than any: who jumps out of a hole's reach shows its edge badly."""
    flown = np.array([np.hypot(*(fall.position - fall.footing)[:2]) for fall in falls])
    return [int(i) for i in np.flatnonzero(flown <= flown.min() + _SAME_FLIGHT_M)]


def _spread(falls: Sequence[Fall], shown: Floats) -> tuple[Fall, ...]:
    """A few falls as far as can be from `shown` [3] and from each other."""
    if not falls:
        return ()
    footings = np.array([fall.footing for fall in falls])
    chosen: list[int] = []
    away = np.linalg.norm(footings - shown, axis=1)
    while len(chosen) < _MOST_OTHERS and away.max() > _SAME_FLIGHT_M:
        chosen.append(int(away.argmax()))
        away = np.minimum(away, np.linalg.norm(footings - footings[chosen[-1]], axis=1))
    return tuple(falls[i] for i in chosen)


def _left_at(evidence: Evidence, path: ReplayPath, expected: Floats) -> tuple[Floats | None, Floats | None]:
    """Where a path left the nav-mesh itself [3], and the next place of it; for one that never was on it, where it was
    `expected` [3] last (NaN: never).

    A ramp off the nav-mesh is left for on the floor, and is what to look at.
    """
    if np.isnan(expected).any():
        return None, None
    left = evidence.navmesh_itself.last_of(path.positions)
    if left is None:
        return expected, None
    return path.positions[left], path.positions[min(left + 1, len(path.positions) - 1)]


def _title(cluster: Cluster, named: str | None) -> str:
    near = f" near '{named}'" if named else ""
    return {
        "fell_out_of_world": f"The player falls out of the world{near}",
        "unexpected_area": f"The player gets to where the nav-mesh does not go{near}",
        "inside_solid": f"The player gets into solid '{cluster.label}'",
        "forbidden_zone": f"The player gets into forbidden zone '{cluster.label}'",
        "stuck": f"The player gets stuck{near}",
        "no_return": f"No way back was found from where the player gets to{near}",
        "unreached_area": f"Part of the nav-mesh was not reached{near}",
        "required_unreached": f"Required point '{cluster.label}' was not reached",
    }[cluster.kind]
