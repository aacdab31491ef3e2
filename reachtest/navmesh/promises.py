"""What a nav-mesh promises, against the character: places it can never be at, steps it cannot walk up.

The rule is simple so that it is sound: a place is impossible where the capsule fits nowhere within one radius
of it, on any floor within the climb of the surface. What one can pass sideways, or by a small detour, is possible.

Shape legend: N samples, M pairs of them, n places, K impossible steps.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from reachtest.columns import ColumnIndex
from reachtest.navmesh.islands import CLIMB_M, climb_of
from reachtest.navmesh.raster import Samples, rasterise
from reachtest.navmesh.room import Room, Standing
from reachtest.records import Bools, Character, Floats, Ints, NavAgent, NavMesh

HANGING_M = 2.5  # a surface farther above the floor has nothing to do with it: a storey, a shelf
HANGING_SHARE = 0.99  # of a surface that hangs no higher than its agent climbs; the rest are holes and rims
STEP_REACH_M = 1.2  # erosion by a radius of half a metre on both sides, and a cell each
STEP_SLACK_M = 0.02  # rounding, and what a simulator's step-up allows
NARROW, LOW, STEEP = 1, 2, 3
_DIRECTIONS = np.array([[np.cos(a), np.sin(a), 0.0] for a in np.arange(8) * (np.pi / 4)])  # [8, 3]
_FINE_M = 0.03  # between two looks at the floor along a pair: finer than a tread
_MOST_PAIRS = 100_000  # that are looked at so closely
_LOOKS = 20  # at the way between two islands


@dataclass(frozen=True)
class Promises:
    """The nav-mesh's surface, and what of it is impossible for the character."""

    samples: Samples
    feet: Floats  # [N, 3] where one stands at them: on the floor below, or on the surface where there is none
    pairs: Ints  # [M, 2] neighbouring samples, of one island
    reason: Ints  # [N] 0 where it is possible, else NARROW, LOW or STEEP
    value: Floats  # [N] width [m], head room [m] or slope [deg] there; NaN where it is possible
    steps: Ints  # [K, 2] samples: from the lower to the upper one
    rise_m: Floats  # [K] height of the step between
    cuts: Ints  # [C, 2] likewise, between islands: steps that the nav-mesh does not promise, for the same reason
    cut_rise_m: Floats  # [C]


def check_promises(navmesh: NavMesh, labels: Ints, collision: Floats, character: Character) -> Promises:
    """Stand the character everywhere on the nav-mesh with islands `labels` [F], in `collision` [.., 3, 3]."""
    samples, room = rasterise(navmesh), Room(collision, character)
    climb = shown_climb(room, samples) if navmesh.agent.climb_m is None else climb_of(navmesh)
    pairs = _within_islands(samples, climb, labels)
    here = room.standing(samples.positions, climb)
    # Inside of a crate or a wall that stands in the way the nav-mesh is wrong, but not about the character.
    suspects = np.flatnonzero(~here.fits & np.isfinite(here.floor) & ~here.buried)
    fits, widest = _fits_nearby(room, samples.positions[suspects], climb, character.radius_m)
    suspects, widest = suspects[~fits], widest[~fits]
    reason = np.zeros(len(samples.positions), dtype=np.int64)
    value = np.full(len(samples.positions), np.nan)
    reason[suspects], value[suspects] = _reasons(here, suspects, widest, character, room.limit_deg)
    step_m, surface = highest_step(character), ColumnIndex(navmesh.triangles)
    steps = _steps(room, samples, here, pairs, climb, step_m, surface)
    cut_m = max(navmesh.agent.climb_m or 0.0, CLIMB_M)
    cuts = _steps(room, samples, here, _island_pairs(samples, labels), cut_m, step_m)
    feet = samples.positions.copy()
    feet[:, 2] = np.where(np.isfinite(here.floor), here.floor, feet[:, 2])
    return Promises(samples, feet, pairs, reason, value, *steps, *cuts)


def highest_step(character: Character) -> float:
    """What the character walks up [m]: its step, or what its round bottom meets as a slope that it may walk."""
    steepest = np.radians(character.slope_limit_deg)
    return max(character.step_height_m, character.radius_m * (1.0 - float(np.cos(steepest))))


def shown_climb(room: Room, samples: Samples) -> float:
    """What a nav-mesh's agent climbs [m], as far as its surface shows, where the file does not say.

    A nav-mesh is drawn as a ramp over the steps that its agent climbs, and so hangs as high above their foot.
    """
    floor, _ = room.floors(samples.positions, HANGING_M)
    hanging = samples.positions[:, 2] - floor
    known = hanging[np.isfinite(hanging)]
    shown = float(np.quantile(known, HANGING_SHARE)) if len(known) else 0.0
    return CLIMB_M if shown <= CLIMB_M else shown + samples.ramp_m


def _within_islands(samples: Samples, climb_m: float, labels: Ints) -> Ints:
    """Neighbours [M, 2] without those across a gap: at a coarse spacing they are next to each other too."""
    pairs = samples.pairs(climb_m)
    island = labels[samples.face[pairs]]
    return pairs[island[:, 0] == island[:, 1]]


def _fits_nearby(room: Room, places: Floats, climb_m: float, radius_m: float) -> tuple[Bools, Floats]:
    """Whether the character fits within a radius of places [n, 3], and the widest gap there [n] [m]."""
    fits, widest = np.zeros(len(places), dtype=np.bool_), np.zeros(len(places))
    for away in (0.0, radius_m / 2, radius_m):
        for direction in _DIRECTIONS:
            ask = np.flatnonzero(~fits)
            there = room.standing(places[ask] + away * direction, climb_m)
            fits[ask] = there.fits
            widest[ask] = np.fmax(widest[ask], 2 * np.where(np.isfinite(there.clear_m), there.clear_m, 0.0))
    return fits, widest


def _reasons(
    here: Standing, which: Ints, widest: Floats, who: Character, limit_deg: float
) -> tuple[Ints, Floats]:
    """Why the character does not fit, and the number that says so, for samples `which` [n]."""
    steep = here.slope_deg[which] > limit_deg
    low = ~steep & (here.head_m[which] < who.height_m)
    reason = np.where(steep, STEEP, np.where(low, LOW, NARROW))
    value = np.where(low, here.head_m[which], widest)
    return reason, np.where(steep, here.slope_deg[which], value)


def _steps(
    room: Room,
    samples: Samples,
    here: Standing,
    pairs: Ints,
    climb_m: float,
    step_m: float,
    surface: ColumnIndex | None = None,
) -> tuple[Ints, Floats]:
    """Pairs of samples [K, 2] with a step on the way that is too high, from the lower one; and its height [K] [m].

    Only steps that a nav-mesh's climb can have meant: what is higher is a ledge. With a `surface`, only those
    that it leads over: between two samples a way may leave it.
    """
    low, high = pairs[:, 0], pairs[:, 1]
    swap = here.floor[low] > here.floor[high]
    low, high = np.where(swap, high, low), np.where(swap, low, high)
    limit = step_m + STEP_SLACK_M
    chosen = np.flatnonzero(here.floor[high] - here.floor[low] > limit)[:_MOST_PAIRS]
    low, high = low[chosen], high[chosen]
    rise = _highest_step(room, samples.positions[low], samples.positions[high], climb_m, surface)
    wrong = (rise > limit) & (rise <= max(climb_m, limit) + STEP_SLACK_M)
    return np.stack([low[wrong], high[wrong]], axis=1), rise[wrong]


def _island_pairs(samples: Samples, labels: Ints) -> Ints:
    """Samples of different islands [M, 2] as near as the two sides of a step after erosion.

    The nearest ones of every two islands do: a step is as high everywhere.
    """
    pairs = cKDTree(samples.positions).query_pairs(STEP_REACH_M, output_type="ndarray")
    island = labels[samples.face[pairs]]
    pairs, island = pairs[island[:, 0] != island[:, 1]], island[island[:, 0] != island[:, 1]]
    away = np.linalg.norm(samples.positions[pairs[:, 0]] - samples.positions[pairs[:, 1]], axis=1)
    island = np.sort(island, axis=1)
    order = np.lexsort((pairs[:, 1], pairs[:, 0], away, island[:, 1], island[:, 0]))
    new = np.append(True, (island[order[1:]] != island[order[:-1]]).any(axis=1))[: len(order)]
    begin = np.flatnonzero(new)
    rank = np.arange(len(order)) - np.repeat(begin, np.diff(np.append(begin, len(order))))
    return np.asarray(pairs[order[rank < _LOOKS]], dtype=np.int64).reshape(-1, 2)


def _highest_step(
    room: Room, low: Floats, high: Floats, climb_m: float, surface: ColumnIndex | None
) -> Floats:
    """The highest sudden rise [n] of the floor on the way from `low` to `high` [n, 3] [m].

    The way is straight, or follows the `surface`: who loses it has no more steps.
    """
    if not len(low):
        return np.empty(0)
    count = int(np.ceil(np.linalg.norm((high - low)[:, :2], axis=1).max() / _FINE_M)) + 1
    rise, before, height = np.zeros(len(low)), np.full(len(low), np.nan), low[:, 2]
    for share in np.linspace(0.0, 1.0, count):
        places = low + share * (high - low)
        if surface is not None:
            # From the last height on the surface; 0 stands in where it was lost.
            places[:, 2] = np.nan_to_num(height)
            height = np.where(np.isnan(height), np.nan, surface.highest(places, climb_m, climb_m)[0])
            places[:, 2] = np.nan_to_num(height)
        floor = np.where(np.isnan(height), np.nan, room.floors(places, climb_m)[0])
        rise = np.fmax(rise, floor - before)
        before = floor
    arrives = np.abs(height - high[:, 2]) <= climb_m if surface is not None else True
    return np.where(arrives, rise, 0.0)


def agent_differences(agent: NavAgent, who: Character) -> tuple[str, ...]:
    """Where the nav-mesh was built for somebody who gets to more places than the character, as far as it is known."""
    rows = (
        (agent.height_m, who.height_m, True, "height", "m", "is lower"),
        (agent.radius_m, who.radius_m, True, "radius", "m", "is smaller"),
        (agent.climb_m, who.step_height_m, False, "climb", "m", "steps higher"),
        (agent.slope_deg, who.slope_limit_deg, False, "slope", "deg", "walks up steeper ground"),
    )
    return tuple(
        f"{name}: the nav-mesh's agent has {theirs:.4g} {unit}, the character {ours:.4g} {unit} (it {more})"
        for theirs, ours, less, name, unit, more in rows
        if theirs is not None and abs(theirs - ours) > 0.005 * max(abs(ours), 1.0) and (theirs < ours) == less
    )
