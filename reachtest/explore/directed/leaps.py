"""Leaps that are worked out: from where, which way, and after how long a run-up somebody lands across a gap.

A stick has eight directions and an agent step is most of a metre long, so of leaps drawn by chance few leave at the
edge and towards the other side. What is worked out is a flight over nothing: what stands in the way shows when tried.

Shape legend: m cached points, k starts before a gap, L leaps.
"""

from __future__ import annotations

from collections import defaultdict

import numpy as np
from scipy.spatial import cKDTree

from reachtest.explore.actions import LEAPS_AIMED
from reachtest.explore.directed.gaps import Gaps
from reachtest.explore.directed.leap_table import LeapTable
from reachtest.explore.directed.places import NOWHERE
from reachtest.records import Bools, Character, ExploreSettings, Floats, Ints

NEAR_M = 4.0  # starts are no farther from the edge: a run-up to full speed, and from all sides
STOREY_M = 0.5  # above or below a slope of 45 degrees from the edge: another storey
ASIDE_M = 1.0  # along the edge: farther on other gaps begin, and on stairs at other heights
SPREAD_M = 0.3  # leaps that land so much farther from where they should are taken e times less
MOST_OFF_M = 2.0  # what lands farther off than that is no leap over this gap
STARTS_AT_ONCE = 8  # of those before a gap: all would take a millisecond
MOST_STARTS = 128  # before a gap: more than there is room for on one floor


class Leaps:
    """The cached points before each gap, and which of their leaps across it are likely to arrive."""

    def __init__(self, gaps: Gaps, who: Character, settings: ExploreSettings) -> None:
        """Leaps over `gaps`."""
        self._gaps, self._radius_m, self._table = gaps, who.radius_m, LeapTable(who, settings)
        count = len(gaps.outwards)
        self._edges = cKDTree(gaps.places.positions)
        self.has_start: Bools = np.zeros(count, dtype=np.bool_)  # before which gaps somebody stood
        self._points: list[list[int]] = [[] for _ in range(count)]  # cached points before each gap,
        self._places: list[list[Floats]] = [[] for _ in range(count)]  # and where they are
        self._drawn: defaultdict[int, list[int]] = defaultdict(list)  # leaps, by cached point

    def note(self, positions: Floats, velocities: Floats, who: Ints, on: Ints) -> None:
        """Take in cached points `who` [m] on the ground at `positions` [m, 3], with `velocities` [m, 3], `on` islands
        [m] or NOWHERE. A leap begins on the island before its gap, or off the nav-mesh as high as the edge."""
        if not len(who) or not self._edges.n:
            return
        positions = positions.copy()
        run_out, still = self._table.run_out(velocities[:, :2])
        positions[:, :2] += run_out
        pairs = cKDTree(positions).sparse_distance_matrix(self._edges, NEAR_M, output_type="ndarray")
        start, before = pairs["i"], self._gaps.places
        away = np.abs(before.positions[pairs["j"]] - positions[start])
        slope = away[:, 2] <= np.hypot(away[:, 0], away[:, 1]) + STOREY_M
        on_it = (on[start] == before.island[pairs["j"]]) & slope
        off = (on[start] == NOWHERE) | (on[start] >= self._gaps.own)
        beside = off & (away[:, 2] <= STOREY_M)
        pairs = np.sort(pairs[still[start] & (on_it | beside)], order=("i", "j"))
        for point, gap in zip(pairs["i"].tolist(), pairs["j"].tolist(), strict=True):
            if len(self._points[gap]) < MOST_STARTS:
                self._points[gap].append(int(who[point]))
                self._places[gap].append(positions[point])
        self.has_start[pairs["j"]] = True

    def draw(self, rng: np.random.Generator, gap: int) -> tuple[int, int] | None:
        """The cached point to start from and the heading of a leap over `gap`; None if none is likely to arrive."""
        if not self._points[gap]:
            return None
        some = rng.permutation(len(self._points[gap]))[:STARTS_AT_ONCE].tolist()
        points = [self._points[gap][start] for start in some]
        landing = self._gaps.landings[gap][rng.integers(len(self._gaps.landings[gap]))]
        off_m = self._off_m(gap, np.array([self._places[gap][start] for start in some]), landing)
        for place, point in enumerate(points):  # the same start and the same actions end the same way
            off_m[place, self._drawn[point]] = np.inf
        row, number = np.nonzero(off_m < MOST_OFF_M)
        if not len(row):
            return None
        likely = off_m[row, number]
        weight = np.exp((likely.min() - likely) / SPREAD_M)
        drawn = int(rng.choice(len(likely), p=weight / weight.sum()))
        start, leap = points[row[drawn]], int(number[drawn])
        self._drawn[start].append(leap)
        return start, LEAPS_AIMED + 1 + leap

    def any_start(self, rng: np.random.Generator, gap: int) -> int:
        """Some cached point before `gap`, which has one."""
        return self._points[gap][int(rng.integers(len(self._points[gap])))]

    def _off_m(self, gap: int, starts: Floats, landing: Floats) -> Floats:
        """How far from `landing` [3] each leap from `starts` [k, 3] lands [k, L]; infinite if it is none over `gap`."""
        edge, out, leaps = self._gaps.places.positions[gap], self._gaps.outwards[gap], self._table.take_offs
        lands = self._table.lands(float(landing[2] - edge[2]))
        to_landing = landing - starts
        off = [lands[:, axis] - to_landing[:, axis, None] for axis in (0, 1)]
        off_m = np.sqrt(off[0] * off[0] + off[1] * off[1])
        row, number = np.nonzero(off_m < MOST_OFF_M)
        before = leaps.places[number] - (edge - starts)[row, :2]  # the edge
        on_floor = (before @ out <= self._radius_m) & (np.abs(before @ [-out[1], out[0]]) <= ASIDE_M)
        bad = ~(on_floor & (leaps.velocities[number] @ out > 0))
        off_m[row[bad], number[bad]] = np.inf
        return off_m
