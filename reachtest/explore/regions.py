"""Regions that nothing found leads out of: small ones hold the character, large ones do not lead back to a spawn.

Shape legend: N places of the transition graph, T trapped ones among them, S spawns.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial import cKDTree

from reachtest.columns import ColumnIndex
from reachtest.connected import STRONGLY, WAYS, Connection, grouped, inner_pairs, part_labels
from reachtest.explore.graph import Graph
from reachtest.navmesh.islands import Islands
from reachtest.records import Bools, Floats, Ints, Level

STUCK_M = 4.0  # a trap no part of which is farther along the axes holds the character; cells add up to one
SAME_TRAP_M = 2.0  # traps this near each other are one: a groove has many
BESIDE_M = 1.0  # so far beside a spawn is at the spawn
STAND_M = 0.35  # a spawn stands so near its ground


@dataclass(frozen=True)
class Region:
    """Places without a known way out."""

    rows: Ints  # [n] rows of the graph
    core: Ints  # [m] those of them where one is held
    stuck: bool


@dataclass(frozen=True)
class Trapped:
    """What the transitions say as they stand."""

    graph: Graph
    back: Bools  # [N] places that lead back to a spawn, or out of the world
    suspects: Ints  # keys of the places that do not, and that the exploration got to itself
    regions: list[Region]  # largest first

    def way_back(self, places: Floats) -> Floats:
        """The place that leads back to a spawn nearest to each of `places` [n, 3]; themselves if none does."""
        known, tree = self._ways_back
        return known[tree.query(places)[1]] if len(known) else places

    @cached_property
    def _ways_back(self) -> tuple[Floats, cKDTree]:
        known = self.graph.places[self.back & ~self.graph.is_out]
        return known, cKDTree(known)


class TrapFinder:
    """Finds the traps of transition graphs of one level."""

    def __init__(self, level: Level, islands: Islands) -> None:
        self._islands = islands
        spawns = np.array([spawn.position for spawn in level.spawns])
        self._home_islands = np.setdiff1d(islands.of(spawns), -1)
        self._spawns = _on_the_floor(level, spawns)

    def find(self, graph: Graph, suspects: Ints | None = None) -> Trapped:
        """Regions of the transitions as they stand; if given, only those with some of `suspects` (keys).

        Every episode ends somewhere, often where none was before: what a probe finds on its way is no suspect.
        To fall out of the world is a way back: it is a finding of its own, and games put who fell back to a spawn.
        """
        back = graph.leads_to(graph.is_out | self._homes(graph))
        suspected = ~back if suspects is None else ~back & np.isin(graph.keys, suspects)
        trapped = np.flatnonzero(graph.led_to_from(suspected))
        keys = graph.keys[suspected]
        if not len(trapped):
            return Trapped(graph, back, keys, [])
        label = _components(graph, trapped, STRONGLY)
        wide = np.zeros(len(back), dtype=np.bool_)
        wide[trapped] = _widths(graph.places[trapped], label)[label] > STUCK_M
        to_wide = graph.leads_to(wide)
        tight, lost = trapped[~to_wide[trapped]], trapped[to_wide[trapped]]
        lost = lost[~self._on_home_islands(graph, lost)] if len(lost) else lost
        ends = np.zeros(len(back), dtype=np.bool_)
        ends[trapped] = np.isin(label, _sinks(graph, trapped, label))
        part = np.full(len(back), -1, dtype=np.int64)
        part[trapped] = label
        regions = [Region(rows, _held(rows, ends, part), True) for rows in _near_each_other(graph, tight)]
        regions += [Region(rows, rows[wide[rows]], False) for rows in _connected(graph, lost)]
        regions = [region for region in regions if suspected[region.rows].any()]
        regions.sort(key=lambda region: (-len(region.rows), int(region.rows[0])))
        return Trapped(graph, back, keys, regions)

    def _homes(self, graph: Graph) -> Bools:
        """The places [N] where who spawns stands; below them if nobody stood there."""
        homes = np.zeros(len(graph.keys), dtype=np.bool_)
        for spawn in self._spawns:
            away = graph.places - spawn
            height = np.where((np.abs(away[:, :2]) <= BESIDE_M).all(axis=1), away[:, 2], np.nan)
            here = np.abs(height) <= STAND_M
            below = np.where(height <= STAND_M, height, -np.inf)
            homes |= here if here.any() else np.isfinite(below) & (below >= below.max() - STAND_M)
        return homes

    def _on_home_islands(self, graph: Graph, trapped: Ints) -> Bools:
        """Which of the places `trapped` [T] lead to the nav-mesh island of a spawn."""
        on = np.zeros(len(graph.keys), dtype=np.bool_)
        on[trapped] = np.isin(self._islands.of(graph.places[trapped]), self._home_islands)
        return graph.leads_to(on)[trapped]


def _on_the_floor(level: Level, spawns: Floats) -> Floats:
    """Where who begins at `spawns` [S, 3] comes to stand: some hang in the air, over what they fall onto."""
    floor, _ = ColumnIndex(level.collision).highest(spawns, np.inf, STAND_M)
    floors = spawns.copy()
    floors[:, 2] = np.where(np.isfinite(floor), floor, spawns[:, 2])
    return floors


def _held(rows: Ints, ends: Bools, part: Ints) -> Ints:
    """Of a tight trap's `rows` [n] those where one ends up, and those between which one goes to and fro: whoever was
    jammed in a pit once ended up there, and yet it is the pit that holds.

    `ends` [N], and by which `part` [N] places lead to each other.
    """
    parts, sizes = np.unique(part[rows], return_counts=True)
    largest = parts[sizes.argmax()] if sizes.max() > 1 else -1
    return np.asarray(rows[ends[rows] | (part[rows] == largest)], dtype=np.int64)


def _connected(graph: Graph, rows: Ints) -> list[Ints]:
    """Parts of `rows` that are connected by transitions, whichever way."""
    return _groups(rows, _components(graph, rows, WAYS)) if len(rows) else []


def _near_each_other(graph: Graph, rows: Ints) -> list[Ints]:
    """Parts of `rows` that are connected by transitions or near each other."""
    if not len(rows):
        return []
    near = cKDTree(graph.places[rows]).query_pairs(SAME_TRAP_M, output_type="ndarray")
    pairs = np.concatenate([_inner(graph, rows), near])
    return _groups(rows, part_labels(len(rows), pairs, WAYS))


def _groups(rows: Ints, label: Ints) -> list[Ints]:
    return [rows[group] for group in grouped(label)]


def _components(graph: Graph, rows: Ints, connection: Connection) -> Ints:
    """Label [n] of each of `rows` by the transitions between them."""
    return part_labels(len(rows), _inner(graph, rows), connection)


def _inner(graph: Graph, rows: Ints) -> Ints:
    """The transitions [E, 2] between `rows`, as places in `rows`."""
    return inner_pairs(graph.ends, rows, len(graph.keys))


def _sinks(graph: Graph, rows: Ints, label: Ints) -> Ints:
    """The components that lead to no other. What leads out of `rows` would lead back: there is no such place."""
    inner = label[_inner(graph, rows)]
    leaving = inner[inner[:, 0] != inner[:, 1], 0]
    return np.setdiff1d(np.arange(label.max() + 1), leaving)


def _widths(places: Floats, label: Ints) -> Floats:
    """Longer horizontal side of the box around the places [n, 3] of each label [m] [m]."""
    low, high = np.full((label.max() + 1, 2), np.inf), np.full((label.max() + 1, 2), -np.inf)
    np.minimum.at(low, label, places[:, :2])
    np.maximum.at(high, label, places[:, :2])
    return np.asarray((high - low).max(axis=1))
