"""Which places of a field the character gets to: surely, or possibly.

Both models walk and drop alike and differ in their jumps. `SURE` jumps lower and shorter than the character can,
up, over and down through air that is free throughout. `POSSIBLE` jumps as far as a parabola at walking speed goes,
steps up at its end, and needs only some free height all along the straight line. So what is new for certain is
surely reached now and was not possibly reached before; what is lost was surely reached and is not even possibly now.

Shape legend: N places, n pairs, S samples of a line.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from reachtest.mutants.field import Field
from reachtest.mutants.moves import Moves
from reachtest.records import Bools, Character, Floats, Ints

_SAMPLES = 20  # of a line of up to 8 m: nearer than a capsule is wide
_HEIGHTS = 6  # asked of the free height over a sample
_LONGEST_M = 8.0  # horizontally; from higher up one may fly farther, to where dropping leads too
_DEEPEST_M = 12.0
_COARSE, _FINE = 4, 2  # [cells] places to jump from and to: one of so many each way
_PAIRS_AT_ONCE = 1 << 17
_UNDER_SPAWN_M = 3.0


@dataclass(frozen=True)
class Jumping:
    """What a character is trusted to jump."""

    name: str
    apex_share: float  # of the jump's apex that a landing may be above the start
    speed_share: float  # of the walking speed
    steps_up: bool  # at the landing
    over_top: bool  # the way is up, over and down; else any free height will do


SURE = Jumping("sure", 0.8, 0.5, False, True)
POSSIBLE = Jumping("possible", 1.05, 1.05, True, False)


def reach(field: Field, moves: Moves, character: Character, seeds: Ints, jumping: Jumping) -> Bools:
    """The places [N] that `seeds` lead to."""
    reached = moves.flood(seeds)
    takeoffs = _thinned(field, np.flatnonzero(moves.rim & field.walkable), _COARSE)
    targets = _thinned(field, np.flatnonzero(moves.rim), _FINE)
    done = np.zeros(len(takeoffs), dtype=np.bool_)
    while character.jump_speed_mps > 0:
        ready = np.flatnonzero(reached[takeoffs] & ~done)
        open_ = targets[~reached[targets]]
        if not len(ready) or not len(open_):
            break
        done[ready] = True
        landed = _jumps(field, character, takeoffs[ready], open_, jumping)
        reached |= moves.flood(landed)
    return reached


def _thinned(field: Field, places: Ints, cells: int) -> Ints:
    """One of `places` [n] in every block of so many cells."""
    i, j = np.divmod(field.column[places], field.grid.shape[1])
    block = np.stack([i // cells, j // cells, field.level[places] // cells], axis=1)
    _, first = np.unique(block, axis=0, return_index=True)
    return places[np.sort(first)]


def _jumps(field: Field, who: Character, takeoffs: Ints, targets: Ints, jumping: Jumping) -> Ints:
    """The `targets` that a jump from one of `takeoffs` ends at."""
    squash = np.array([1.0, 1.0, _LONGEST_M / _DEEPEST_M])
    start, end = (cKDTree(field.positions[some] * squash) for some in (takeoffs, targets))
    near = start.sparse_distance_matrix(end, _LONGEST_M, output_type="coo_matrix")
    pairs = np.stack([takeoffs[near.row], targets[near.col]], axis=1)
    pairs = pairs[_in_range(field, who, pairs, jumping)]
    check = _over_the_top if jumping.over_top else _any_height
    landed = [np.zeros(0, dtype=np.int64)]
    known = np.zeros(len(field.column), dtype=np.bool_)
    for begin in range(0, len(pairs), _PAIRS_AT_ONCE):
        some = pairs[begin : begin + _PAIRS_AT_ONCE]
        some = some[~known[some[:, 1]]]
        ok = check(field, who, some)
        known[some[ok, 1]] = True
        landed.append(np.unique(some[ok, 1]))
    return np.concatenate(landed)


def _in_range(field: Field, who: Character, pairs: Ints, jumping: Jumping) -> Bools:
    """Which pairs [n, 2] a parabola joins."""
    away = field.positions[pairs[:, 1]] - field.positions[pairs[:, 0]]
    apex = who.jump_speed_mps**2 / (2 * who.gravity_mps2)
    rise = away[:, 2] - (who.step_height_m if jumping.steps_up else 0.0)
    highest = jumping.apex_share * apex
    fall = np.sqrt(2 * np.maximum(apex - np.minimum(rise, apex), 0.0) / who.gravity_mps2)
    airborne = who.jump_speed_mps / who.gravity_mps2 + fall
    far = jumping.speed_share * who.walk_speed_mps * airborne
    return np.asarray((rise <= highest) & (np.hypot(away[:, 0], away[:, 1]) <= far))


def _line(field: Field, pairs: Ints) -> Ints:
    """Columns [n, S] along the straight lines of pairs, both ends included."""
    ends = [np.stack(np.divmod(field.column[pairs[:, k]], field.grid.shape[1]), axis=1) for k in (0, 1)]
    share = np.linspace(0.0, 1.0, _SAMPLES)[None, :, None]
    cells = np.rint(ends[0][:, None] * (1 - share) + ends[1][:, None] * share).astype(np.int64)
    return np.asarray(cells[:, :, 0] * field.grid.shape[1] + cells[:, :, 1])


def _over_the_top(field: Field, who: Character, pairs: Ints) -> Bools:
    apex = who.jump_speed_mps**2 / (2 * who.gravity_mps2)
    up = int(np.floor(apex / field.grid.cell_height_m))
    low, end = field.level[pairs[:, 0]], field.level[pairs[:, 1]]
    top = np.minimum(low + up, field.free.shape[1] - 1)
    columns = _line(field, pairs)
    ok = field.free[columns, top[:, None]].all(axis=1) & (end <= top)
    ok &= field.land[columns[:, 0], top] == low
    return np.asarray(ok & (field.land[columns[:, -1], top] == end))


def _any_height(field: Field, who: Character, pairs: Ints) -> Bools:
    apex = who.jump_speed_mps**2 / (2 * who.gravity_mps2)
    up = int(np.ceil((apex + who.step_height_m) / field.grid.cell_height_m))
    low = np.minimum(field.level[pairs[:, 0]], field.level[pairs[:, 1]])
    high = np.minimum(field.level[pairs[:, 0]] + up, field.free.shape[1] - 1)
    columns = _line(field, pairs)
    ok = np.zeros(columns.shape, dtype=np.bool_)
    for share in np.linspace(0.0, 1.0, _HEIGHTS):
        level = np.rint(low + share * (high - low)).astype(np.int64)
        ok |= field.free[columns, level[:, None]]
    return np.asarray(ok.all(axis=1))


def spawn_places(field: Field, spawns: Floats) -> Ints:
    """The places [n] under spawn positions [s, 3]: the nearest walkable ones."""
    standing = np.flatnonzero(field.walkable)
    if not len(standing) or not len(spawns):
        return np.zeros(0, dtype=np.int64)
    away, which = cKDTree(field.positions[standing]).query(spawns)
    return standing[np.asarray(which)[np.asarray(away) < _UNDER_SPAWN_M]]
