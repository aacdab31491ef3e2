"""Transitions: between which places the episodes went, so that it is known from where nothing leads back.

Places are cells the character *stood* in (or came to rest in: a wedge gives no footing); a flight is one transition
from where it left the ground to where it landed. Cells in the air would join the bottom of a pit to its rim.
Lying somewhere is another place than standing in the same cell: who is wedged in there does not get away as who
stands beside it does.

Shape legend: B lanes, T agent steps of a round, N places, E transitions, S state size.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from reachtest.explore.graph import LYING, OUT, UNKNOWN, Graph
from reachtest.explore.retrace import AFTER, BEFORE, TIMES, WITHIN, Retrace
from reachtest.explore.rollout import Trajectories
from reachtest.explore.stays import Stays, stays_of
from reachtest.geometry import pack_cells
from reachtest.records import Bools, EndReason, Floats, Ints

FLATTER = (
    2  # cells are half as high as wide: a ledge just too high to jump onto is another cell than its foot
)
_SHIFT = 0.2  # of a cell's height: floors at round heights are not at the border of two cells
_GROWTH = 4  # new rows are merged when there are a quarter as many: few merges, little waste


class Transitions:
    """Collects the transitions of a run."""

    def __init__(self, cell_m: float, state_size: int, retrace: Retrace | None = None) -> None:
        """S is `state_size`; `retrace` tells which ways lead back as well; None: none that was not taken."""
        self._retrace = retrace
        self._cell = np.array([cell_m, cell_m, cell_m / FLATTER])
        self._keys: Ints = np.array([OUT], dtype=np.int64)
        self._places = np.full((1, 3), np.nan, dtype=np.float32)
        self._origins = np.full((1, 5), UNKNOWN, dtype=np.int32)
        self._states = np.full((1, state_size), np.nan)
        self._ends: Ints = np.empty((0, 2), dtype=np.int64)
        # Keys, places, origins, states and ends of rounds not merged yet.
        self._fresh: list[tuple[Ints, NDArray[np.float32], NDArray[np.int32], Floats, Ints]] = []
        self._waiting = 0

    @property
    def nbytes(self) -> int:
        """Memory of what is stored."""
        fresh = sum(array.nbytes for rows in self._fresh for array in rows)
        merged = self._keys, self._places, self._origins, self._states, self._ends
        return fresh + sum(array.nbytes for array in merged)

    def cells(self, positions: Floats, lying: Bools | Literal[False] = False) -> Ints:
        """The key [n] of the cell of each of `positions` [n, 3], for who stands or lies there [n].

        They are rounded as places are kept: else one at the border of two cells comes back in the other.
        """
        kept = np.asarray(positions, dtype=np.float32).astype(np.float64)
        cells = np.floor(kept / self._cell + np.array([0.0, 0.0, _SHIFT])).astype(np.int64)
        cells[:, 2] += np.multiply(lying, LYING)
        return pack_cells(cells)

    def add(
        self,
        rolled: Trajectories,
        starts: Stays,
        parents: Ints | None = None,
        round_: int = 0,
        standing: Bools | None = None,
    ) -> None:
        """Enter a round; `starts` [M, B] are where the characters stood or lay last at each of their starts.

        `parents` [M, B] are these starts; None if they are no cached points. `standing` [M, B] says who stands there
        still; None if that is not known of anybody, and then nothing is taken to lead back.
        """
        lane, time, episode, stays, out = _visits(rolled, starts)
        order = np.lexsort((time, lane))
        lane, time, episode, out = lane[order], time[order], episode[order], out[order]
        places = stays.places[order]
        keys = np.where(out, OUT, self.cells(np.where(out[:, None], 0.0, places), stays.lying[order]))
        step = (episode[1:] == episode[:-1]) & (keys[1:] != keys[:-1])
        ends = np.stack([keys[:-1][step], keys[1:][step]], axis=1)
        if self._retrace and standing is not None:
            here = self._retrace.lead_back(rolled, standing, lane, time, places[:, 2], step)
            ends = np.concatenate([ends, np.stack([keys[here], keys[here - 1]], axis=1)])
        known, first = np.unique(keys, return_index=True)
        lane, time = lane[first], time[first]
        origins, states = _origins(rolled, lane, time, parents, round_), _states(rolled, lane, time)
        self._fresh.append((known, places[first].astype(np.float32), origins, states, _distinct(ends)))
        self._waiting += len(ends)
        if self._waiting * _GROWTH > len(self._ends):
            self._merge()

    def graph(self) -> Graph:
        """Everything so far."""
        self._merge()
        ends = np.searchsorted(self._keys, self._ends)
        return Graph(self._keys, self._places.astype(np.float64), self._origins, self._states, ends)

    def _merge(self) -> None:
        keys = np.concatenate([self._keys, *(rows[0] for rows in self._fresh)])
        places = np.concatenate([self._places, *(rows[1] for rows in self._fresh)])
        origins = np.concatenate([self._origins, *(rows[2] for rows in self._fresh)])
        states = np.concatenate([self._states, *(rows[3] for rows in self._fresh)])
        self._keys, first = np.unique(keys, return_index=True)  # the earliest of equals
        self._places, self._origins, self._states = places[first], origins[first], states[first]
        self._ends = _distinct(np.concatenate([self._ends, *(rows[4] for rows in self._fresh)]))
        self._fresh, self._waiting = [], 0


def _origins(
    rolled: Trajectories, lane: Ints, time: Ints, parents: Ints | None, round_: int
) -> NDArray[np.int32]:
    """How the characters got to where they were in `lane` [n] at `time` [n]: origins [n, 5]."""
    result = np.full((len(lane), 5), UNKNOWN, dtype=np.int32)
    if parents is not None:
        t = time // TIMES
        parent = parents[rolled.which[t, lane], lane]
        columns = parent, np.full(len(lane), round_), lane, rolled.start[t, lane], _steps_done(time)
        result[:] = np.stack(columns, axis=1)
    return result


def _states(rolled: Trajectories, lane: Ints, time: Ints) -> Floats:
    """The states [n, S] of the characters then; NaN where nothing was done yet."""
    t, done = time // TIMES, _steps_done(time)
    moved = (done > rolled.start[t, lane])[:, None]
    return np.where(moved, rolled.states[np.maximum(done - 1, 0), lane], np.nan)


def _steps_done(time: Ints) -> Ints:
    """Agent steps of the round [n] that were done by then."""
    return (time + TIMES - 1) // TIMES


def _visits(rolled: Trajectories, starts: Stays) -> tuple[Ints, Ints, Ints, Stays, Bools]:
    """Lane, time, episode, foothold and "fell out" of every start, footing and fall of a round, in no order."""
    steps, lanes = rolled.ended.shape
    stays = stays_of(rolled)
    began = np.argwhere(rolled.start == np.arange(steps)[:, None])
    seen = np.argwhere(np.isfinite(stays.places[:, :, 0]))
    fell = np.argwhere(rolled.ended == EndReason.FELL)
    where = np.concatenate([began, seen, fell])
    time = TIMES * where[:, 0] + np.repeat([BEFORE, WITHIN, AFTER], [len(began), len(seen), len(fell)])
    episode = rolled.start[where[:, 0], where[:, 1]].astype(np.int64) * lanes + where[:, 1]
    first, then = (rolled.which[began[:, 0], began[:, 1]], began[:, 1]), (seen[:, 0], seen[:, 1])
    places = np.concatenate([starts.places[first], stays.places[then], np.full((len(fell), 3), np.nan)])
    lying = np.concatenate([starts.lying[first], stays.lying[then], np.zeros(len(fell), dtype=np.bool_)])
    out = np.arange(len(where)) >= len(began) + len(seen)
    return where[:, 1], time, episode, Stays(places, lying), out


def _distinct(ends: Ints) -> Ints:
    """The distinct rows of `ends` [E, 2], sorted."""
    ends = ends[np.lexsort((ends[:, 1], ends[:, 0]))]
    new = np.ones(len(ends), dtype=np.bool_)
    new[1:] = (ends[1:] != ends[:-1]).any(axis=1)
    return ends[new]
