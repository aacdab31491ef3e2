"""Leaps that are worked out: from where, which way, and after how long a run-up somebody lands across a gap.

A stick has eight directions and an agent step is most of a metre long, so of leaps drawn by chance few leave at the
edge and towards the other side. What is worked out is a flight over nothing: what stands in the way shows when tried.

Shape legend: m cached points, k starts before a gap, L leaps.
"""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from reachtest.explore.actions import AIMED, AIMED_LEAPS, HEADINGS, LEAP_FLIGHT_STEPS, LEAP_WAIT_STEPS, aimed
from reachtest.explore.gaps import Gaps, flight_s
from reachtest.records import Character, ExploreSettings, Floats, Ints
from reachtest.walking import Walk

NEAR_M = 4.0  # starts are no farther from the edge: a run-up to full speed, and from all sides
STOREY_M = 0.5  # above or below a slope of 45 degrees from the edge: another storey
ASIDE_M = 1.0  # along the edge: farther on other gaps begin, and on stairs at other heights
SPREAD_M = 0.3  # leaps that land so much farther from where they should are taken e times less
MOST_OFF_M = 2.0  # what lands farther off than that is no leap over this gap
STARTS_AT_ONCE = 8  # of those before a gap: all would take a millisecond
RISE_M = 0.05  # within it flights last as long
_ANGLES = np.arange(HEADINGS) * (2 * np.pi / HEADINGS)
_WISH = np.concatenate([[[0.0, 0.0]], np.column_stack([np.cos(_ANGLES), np.sin(_ANGLES)])])


@dataclass(frozen=True)
class TakeOffs:
    """Where the leaps take off when they begin at rest, how fast, and where they push in the air."""

    places: Floats  # [L, 2]
    velocities: Floats  # [L, 2]
    pushes: Floats  # [L, 2] unit vectors


class Leaps:
    """The cached points before each gap, and which of their leaps across it are likely to arrive."""

    def __init__(self, gaps: Gaps, who: Character, settings: ExploreSettings) -> None:
        """Leaps over `gaps`."""
        self._gaps, self._who = gaps, who
        self._edges = cKDTree(gaps.edges)
        self._points: list[list[int]] = [[] for _ in gaps.edges]  # cached points before each gap,
        self._places: list[list[Floats]] = [[] for _ in gaps.edges]  # and where they are
        self._drawn: defaultdict[int, list[int]] = defaultdict(list)  # leaps, by cached point
        self._settings, self._rule = settings, Walk.of(who, 1.0 / settings.physics_hz)
        self._leaps = take_offs(who, settings)
        self._carries: dict[int, Floats] = {}  # [L, 2] by rise
        self._pushed_s = LEAP_FLIGHT_STEPS * settings.action_repeat / settings.physics_hz

    def note(self, positions: Floats, velocities: Floats, who: Ints) -> None:
        """Take in cached points `who` [m] that are on the ground at `positions` [m, 3], with `velocities` [m, 3]."""
        if not len(who) or not self._edges.n:
            return
        positions = positions.copy()
        positions[:, :2] += self._run_out(velocities[:, :2])
        pairs = cKDTree(positions).sparse_distance_matrix(self._edges, NEAR_M, output_type="ndarray")
        away = np.abs(self._gaps.edges[pairs["j"]] - positions[pairs["i"]])
        pairs = np.sort(pairs[away[:, 2] <= np.hypot(away[:, 0], away[:, 1]) + STOREY_M], order=("i", "j"))
        for point, gap in zip(pairs["i"].tolist(), pairs["j"].tolist(), strict=True):
            self._points[gap].append(int(who[point]))
            self._places[gap].append(positions[point])

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
        total = np.cumsum(np.exp((likely.min() - likely) / SPREAD_M))
        drawn = min(int(np.searchsorted(total, rng.random() * total[-1], side="right")), len(total) - 1)
        start, leap = points[row[drawn]], int(number[drawn])
        self._drawn[start].append(leap)
        return start, AIMED + 1 + leap

    def _off_m(self, gap: int, starts: Floats, landing: Floats) -> Floats:
        """How far from `landing` [3] each leap from `starts` [k, 3] lands [k, L]; infinite if it is none over `gap`."""
        edge, out, leaps = self._gaps.edges[gap], self._gaps.outwards[gap], self._leaps
        lands = leaps.places + self._flown(round(float(landing[2] - edge[2]) / RISE_M))
        to_landing = landing - starts
        off = [lands[:, axis] - to_landing[:, axis, None] for axis in (0, 1)]
        off_m = np.sqrt(off[0] * off[0] + off[1] * off[1])
        row, number = np.nonzero(off_m < MOST_OFF_M)
        before = leaps.places[number] - (edge - starts)[row, :2]  # the edge
        on_floor = (before @ out <= self._who.radius_m) & (np.abs(before @ [-out[1], out[0]]) <= ASIDE_M)
        bad = ~(on_floor & (leaps.velocities[number] @ out > 0))
        off_m[row[bad], number[bad]] = np.inf
        return off_m

    def _flown(self, rise: int) -> Floats:
        """How far the leaps carry [L, 2] that end `rise` times RISE_M higher: the stick pushes on in the air."""
        if rise not in self._carries:
            self._carries[rise] = self._fly(float(flight_s(self._who, rise * RISE_M)))
        return self._carries[rise]

    def _run_out(self, velocity: Floats) -> Floats:
        """How far who has `velocity` [m, 2] gets until he stands [m, 2]."""
        way = np.zeros_like(velocity)
        for _ in range(LEAP_WAIT_STEPS * self._settings.action_repeat):
            velocity = self._rule.braked(velocity, np.hypot(velocity[:, 0], velocity[:, 1]))
            way += velocity / self._settings.physics_hz
        return way

    def _fly(self, time_s: float) -> Floats:
        who, velocity, pushed_s = self._who, self._leaps.velocities, min(time_s, self._pushed_s)
        after = velocity + who.air_control * who.acceleration_mps2 * pushed_s * self._leaps.pushes
        most = np.maximum(np.hypot(velocity[:, 0], velocity[:, 1]), who.walk_speed_mps)
        after *= (most / np.maximum(np.hypot(after[:, 0], after[:, 1]), most))[:, None]
        return np.asarray((velocity + after) / 2 * pushed_s + after * (time_s - pushed_s), dtype=np.float64)


def take_offs(who: Character, settings: ExploreSettings) -> TakeOffs:
    """What becomes of each of the leaps by the time it jumps."""
    rule = Walk.of(who, 1.0 / settings.physics_hz)
    leaps = [aimed(number) for number in range(AIMED_LEAPS)]
    last = np.array([leap[:, 1].argmax() for leap in leaps])
    sticks = np.zeros((AIMED_LEAPS, last.max() + 1), dtype=np.int64)
    for number, leap in enumerate(leaps):
        sticks[number, : last[number] + 1] = leap[: last[number] + 1, 0]
    place, velocity = np.zeros((AIMED_LEAPS, 2)), np.zeros((AIMED_LEAPS, 2))
    places, velocities = place.copy(), velocity.copy()
    for step, stick in enumerate(sticks.T):
        for tick in range(settings.action_repeat):
            speed = np.hypot(velocity[:, 0], velocity[:, 1])
            pushed = rule.towards(velocity, speed, _WISH[stick])
            velocity = np.where(stick[:, None] > 0, pushed, rule.braked(velocity, speed))
            if tick == 0:  # it jumps with the velocity of this tick, before it moves
                now = last == step
                places[now], velocities[now] = place[now], velocity[now]
            place = place + velocity / settings.physics_hz
    return TakeOffs(places, velocities, _WISH[sticks[np.arange(AIMED_LEAPS), last]])
