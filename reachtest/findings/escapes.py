"""The ways off the nav-mesh: which of what was found beyond it is one bug.

One bug has one exit: evidence is grouped by where its path left the nav-mesh, so that a hole with a whole roofscape
behind it is one finding, and two holes to one roof are two. Who fell off expected ground left it at the edge of the
last floor below, wherever the jump began; who stepped onto a ledge and off it is one with those who jumped past it.

Shape legend: n points, m falls.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from reachtest.findings.build import Cluster
from reachtest.findings.cluster import single_linkage
from reachtest.findings.evidence import Evidence
from reachtest.findings.rims import join_rims
from reachtest.findings.spaces import Space, join_spaces
from reachtest.findings.void import Void
from reachtest.findings.walls import Walls
from reachtest.records import Bools, Floats, Ints

LINK_M = 4.0  # exits and areas closer than this are one bug: a little more than "expected" reaches
_SAME_M = 0.5  # who stands so near to where they were expected last fell off what is expected
_BENT = 512  # falls whose way is simulated again because it was not straight: about a second
_SAMPLES = 17  # of a way: a metre or less of a jump apart


def escapes(evidence: Evidence) -> list[Cluster]:
    """Where the character left the nav-mesh: `fell_out_of_world` where it fell, else `unexpected_area`.

    What was only flown through (a jump off a tower onto the nav-mesh again) is no evidence: somebody must have
    stood or fallen.
    """
    points, falls = evidence.exploration.points, evidence.exploration.falls
    bug_of_its_own = np.logical_or.reduce([evidence.allowed, *evidence.off_limits.values()])
    chosen = np.flatnonzero(~points.expected & ~bug_of_its_own)
    exits = _anchors(points.exit_point[chosen], points.positions[chosen])
    footings = np.array([fall.footing for fall in falls]).reshape(-1, 3)
    left = _anchors(np.array([fall.exit_point for fall in falls]).reshape(-1, 3), footings)
    fall_group, edges = _fall_groups(evidence, footings, left)
    group = _point_groups(exits, points.grounded[chosen], left, fall_group)
    count = int(max(group.max(initial=-1), fall_group.max(initial=-1))) + 1
    beyond = np.linalg.norm(footings - left, axis=1) >= _SAME_M  # they fell off what is off the nav-mesh
    spaces = [
        Space(
            chosen[(group == number) & points.grounded[chosen]],
            tuple(falls[i] for i in np.flatnonzero((fall_group == number) & beyond)),
        )
        for number in range(count)
    ]
    label = np.array([*join_spaces(evidence, spaces, LINK_M), -1], dtype=np.int64)  # -1 stays -1
    group, fall_group = label[group], label[fall_group]
    clusters = []
    for number in np.unique(label[:-1]).tolist():
        some, fell = np.flatnonzero(group == number), np.flatnonzero(fall_group == number)
        # Bounds of where somebody stood: what is flown through below an edge is not the place to look at.
        standing = chosen[some][points.grounded[chosen[some]]]
        places = np.concatenate([points.positions[standing], footings[fell]])
        kind = "fell_out_of_world" if len(fell) else "unexpected_area"
        shown = np.concatenate([exits[some] if not len(fell) else exits[:0], edges[fell]])
        clusters.append(Cluster(kind, "", chosen[some], tuple(falls[i] for i in fell), places, shown))
    return clusters


def _fall_groups(evidence: Evidence, footings: Floats, left: Floats) -> tuple[Ints, Floats]:
    """A number [m] for each bug that falls show, and where each of them left the nav-mesh [m, 3]."""
    level, falls = evidence.level, evidence.exploration.falls
    number = np.full(len(falls), -1, dtype=np.int64)
    if not falls:
        return number, left
    void = Void(level)
    ends = np.array([fall.position for fall in falls])
    over = void.entries(footings, ends)
    over[Walls(level.collision).behind(footings, over, level.character)] = np.nan  # it bounced
    at_once = np.linalg.norm(footings - left, axis=1) < _SAME_M
    bent = np.flatnonzero(at_once & np.isnan(over[:, 0]))
    some = bent[np.unique(np.linspace(0, len(bent) - 1, min(len(bent), _BENT)).astype(int))]
    flights = evidence.replayer.flights([falls[i] for i in some])
    over[some] = np.array([void.crossed(way) for way in flights]).reshape(-1, 3)
    _where_others_fell(over, at_once & np.isnan(over[:, 0]), footings, ends)
    direct = at_once & ~np.isnan(over[:, 0])
    edges = np.where(direct[:, None], over, left)
    # An edge counts as high as its floor, and as high as it was crossed: who jumps off a plateau at the rim joins both.
    crossed = np.where(direct[:, None], np.column_stack([edges[:, :2], footings[:, 2]]), left)
    ties = np.concatenate([np.arange(len(falls))[:, None] + [0, len(falls)], _beside(over, direct)])
    linked = single_linkage(np.concatenate([edges, crossed]), LINK_M, ties)
    groups = [group[group < len(falls)] for group in linked]
    label = join_rims(level, void, [edges[group] for group in groups])
    for group, same in zip(groups, label, strict=True):
        number[group] = same
    return np.unique(number, return_inverse=True)[1], edges


def _where_others_fell(over: Floats, bent: Bools, footings: Floats, ends: Floats) -> None:
    """Give falls that are `bent` [m] the edge, `over` [m, 3], of the nearest fall beside their way, in place.

    Who bounced off the wall of a hole, or slid down a chute, ends below a floor: on its way, taken to be straight,
    there is no void.
    """
    known, lost = np.flatnonzero(~np.isnan(over[:, 0])), np.flatnonzero(bent)
    if not len(known) or not len(lost):
        return
    share = np.linspace(0.0, 1.0, _SAMPLES)[:, None]
    ways = footings[lost, None] + share * (
        (ends - footings)[lost, None] * [1.0, 1.0, 0.0]
    )  # as high as the floor
    away, which = _nearest(over[known], ways.reshape(-1, 3))
    away, which = away.reshape(len(lost), _SAMPLES), which.reshape(len(lost), _SAMPLES)
    best = away.argmin(axis=1)
    near = away[np.arange(len(lost)), best] <= LINK_M
    over[lost[near]] = over[known[which[np.arange(len(lost)), best][near]]]


def _beside(over: Floats, direct: Bools) -> Ints:
    """Falls [t, 2] over one edge, `over` [m, 3]: from a ledge off the nav-mesh, and beside it past that ledge.

    Two that both went by way of the ledge are no pair: two holes may lead to it.
    """
    past, by_way = np.flatnonzero(direct), np.flatnonzero(~direct & ~np.isnan(over[:, 0]))
    away, which = _nearest(over[past], over[by_way])
    near = away <= LINK_M
    return np.stack([by_way[near], past[which[near]]], axis=1)


def _point_groups(exits: Floats, grounded: Bools, left: Floats, fall_group: Ints) -> Ints:
    """The number [n] of the bug that each point shows, -1 for none.

    Areas that somebody stood in belong to the falls with the same exit, else they are bugs of their own; what was flown
    through belongs to the nearest.
    """
    number = np.full(len(exits), -1, dtype=np.int64)
    count = int(fall_group.max(initial=-1)) + 1
    standing = np.flatnonzero(grounded)
    for area in single_linkage(exits[standing], LINK_M):
        members = standing[area]
        away, which = _nearest(left, exits[members])
        if away.min() <= LINK_M:
            number[members] = fall_group[which[away.argmin()]]
        else:
            number[members] = count
            count += 1
    flying = np.flatnonzero(number < 0)
    away, which = _nearest(np.concatenate([exits[standing], left]), exits[flying])
    near = away <= LINK_M
    number[flying[near]] = np.concatenate([number[standing], fall_group])[which[near]]
    return number


def _nearest(places: Floats, points: Floats) -> tuple[Floats, Ints]:
    """Distance [n] of each of points [n, 3] to the nearest of `places` [m, 3], and which it is; infinite for none."""
    if not len(places):
        return np.full(len(points), np.inf), np.zeros(len(points), dtype=np.int64)
    away, which = cKDTree(places).query(points)
    return np.asarray(away), np.asarray(which, dtype=np.int64)


def _anchors(exits: Floats, positions: Floats) -> Floats:
    """Exit points, or the positions themselves where the path never was on the nav-mesh."""
    return np.where(np.isnan(exits), positions, exits)
