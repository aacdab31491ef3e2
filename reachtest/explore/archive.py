"""What goes with the position cache: all that a cached point needs to be restarted and replayed, in few bytes.

Shape legend: P cached points, n new ones, S state size.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from reachtest.explore.cache import PositionCache
from reachtest.explore.rows import Rows
from reachtest.records import Bools, Floats, Ints, Points

_OWN = -1  # a place that is the point's own position


class Places:
    """A place [3] for every point. Most are the point's own position or the one before's: those cost 4 bytes."""

    def __init__(self) -> None:
        self._places = Rows(3, dtype=np.float32)  # half a millimetre at 5 km: it is for reports

    def add(self, places: Floats, positions: Floats) -> NDArray[np.int32]:
        """References [n] to `places` [n, 3] (NaN where unknown) of points at `positions` [n, 3]."""
        refs = np.full(len(places), _OWN, dtype=np.int32)
        other = np.flatnonzero((places != positions).any(axis=1))
        distinct, which = np.unique(places[other].astype(np.float32), axis=0, return_inverse=True)
        refs[other] = len(self._places) + which.reshape(-1)
        self._places.append(distinct)
        return refs

    def get(self, refs: NDArray[np.int32], positions: Floats) -> Floats:
        """The places [n, 3] behind references [n]."""
        own, known = (refs == _OWN)[:, None], self._places.values
        return np.where(own, positions, known[refs] if len(known) else np.nan)

    @property
    def nbytes(self) -> int:
        """Memory of what is stored."""
        return self._places.values.nbytes


class Archive:
    """Grows by batches; never changes what it holds. Row i belongs to point i of the cache."""

    def __init__(self, cache: PositionCache, state_size: int, lanes: int, interval: int) -> None:
        """States of `state_size` numbers, from rounds of `lanes` episodes of at most `interval` agent steps."""
        self._cache = cache
        lane, step = np.min_scalar_type(lanes - 1), np.min_scalar_type(interval)  # a byte each, as a rule
        self._footings, self._exits = Places(), Places()
        self._columns = {
            "motion": Rows(state_size - 3),  # the state but for the position it begins with
            "grounded": Rows(dtype=np.bool_),
            "parent": Rows(dtype=np.int32),
            "round": Rows(dtype=np.int32),
            "agent": Rows(dtype=lane),
            "start": Rows(dtype=step),
            "step": Rows(dtype=step),
            "off_mesh_m": Rows(dtype=np.float32),
            "footing": Rows(dtype=np.int32),
            "exit_point": Rows(dtype=np.int32),
            "cell": Rows(dtype=np.int32),
            "above_m": Rows(dtype=np.float16),
        }

    def __len__(self) -> int:
        return len(self._columns["motion"])

    def append(
        self, states: Floats, footing: Floats, exit_point: Floats, **rows: NDArray[np.generic]
    ) -> None:
        """Add n rows: `states` [n, S], where the character last stood and left the nav-mesh [n, 3], and the rest."""
        positions = states[:, :3]
        rows |= {
            "motion": states[:, 3:],
            "footing": self._footings.add(footing, positions),
            "exit_point": self._exits.add(exit_point, positions),
        }
        for name, column in self._columns.items():
            column.append(rows[name])

    def states_of(self, points: Ints) -> Floats:
        """The states [n, S] of cached points [n]."""
        return np.concatenate([self._cache.positions[points], self._column("motion")[points]], axis=1)

    def footings_of(self, points: Ints) -> Floats:
        """Where the characters of cached points [n] stood last [n, 3]."""
        return self._places(self._footings, "footing", points)

    def exits_of(self, points: Ints) -> Floats:
        """Where they last stood at an expected position [n, 3]; NaN if they did not yet."""
        return self._places(self._exits, "exit_point", points)

    def stood_at(self, parents: Ints) -> Bools:
        """Whether the characters of `parents` [...] stand: those of cached points; of spawns nobody looked."""
        known = self.grounded[np.maximum(parents, 0)] if len(self) else False
        return np.asarray(known & (parents >= 0))

    @property
    def grounded(self) -> Bools:
        """[P]"""
        return np.asarray(self._column("grounded"), dtype=np.bool_)

    @property
    def velocities(self) -> Floats:
        """[P, 3] [m/s]"""
        return np.asarray(self._column("motion"), dtype=np.float64)[:, :3]

    @property
    def off_mesh_m(self) -> NDArray[np.float32]:
        """Distance to the nav-mesh [P] [m], infinite where unexpected."""
        return np.asarray(self._column("off_mesh_m"), dtype=np.float32)

    @property
    def above_m(self) -> NDArray[np.float16]:
        """Height above the floor below [P] [m]: 0 for who stands, infinite over nothing."""
        return np.asarray(self._column("above_m"), dtype=np.float16)

    @property
    def cells(self) -> NDArray[np.int32]:
        """Visit cells [P]"""
        return np.asarray(self._column("cell"), dtype=np.int32)

    @property
    def bytes_per_point(self) -> float:
        """What a cached point takes outside the tree, its position in the cache included."""
        places = (self._footings.nbytes + self._exits.nbytes) / max(len(self), 1)
        fixed = sum(column.row_bytes for column in self._columns.values())
        return fixed + places + self._cache.positions.itemsize * 3

    def points(self) -> Points:
        """Everything as one frozen record."""
        everything = np.arange(len(self))
        positions = self._cache.positions.copy()
        exits = self._column("exit_point").astype(np.int32)
        return Points(
            positions=positions,
            states=self.states_of(everything),
            off_mesh_m=self.off_mesh_m.astype(np.float64),
            exit_point=self._exits.get(exits, positions),
            grounded=self.grounded.copy(),
            parent=self._column("parent").astype(np.int32),
            round=self._column("round").astype(np.int32),
            agent=self._column("agent").astype(np.int32),
            start=self._column("start").astype(np.int16),
            step=self._column("step").astype(np.int16),
        )

    def _column(self, name: str) -> NDArray[np.generic]:
        return self._columns[name].values

    def _places(self, places: Places, name: str, points: Ints) -> Floats:
        return places.get(self._column(name)[points].astype(np.int32), self._cache.positions[points])
