"""The columns that go with the position cache: what every cached point needs to be restarted and replayed.

Shape legend: P cached points, n new ones, S state size.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from reachtest.records import Bools, Floats, Ints, Points

OWN = ("cell", "hopeless", "footing")  # for the exploration alone


class Archive:
    """Grows by batches; never changes what it holds."""

    def __init__(self, state_size: int) -> None:
        self._count = 0
        self._columns: dict[str, NDArray[np.generic]] = {
            "positions": np.empty((1024, 3)),
            "states": np.empty((1024, state_size)),
            "grounded": np.empty(1024, dtype=np.bool_),
            "parent": np.empty(1024, dtype=np.int32),
            "round": np.empty(1024, dtype=np.int32),
            "agent": np.empty(1024, dtype=np.int32),
            "start": np.empty(1024, dtype=np.int16),
            "step": np.empty(1024, dtype=np.int16),
            "off_mesh_m": np.empty(1024),
            "footing": np.empty((1024, 3)),
            "exit_point": np.empty((1024, 3)),
            "cell": np.empty(1024, dtype=np.int64),
            "hopeless": np.empty(1024, dtype=np.bool_),
        }

    def __len__(self) -> int:
        return self._count

    def append(self, **rows: NDArray[np.generic]) -> None:
        """Add n rows; every column must be given."""
        n = len(rows["positions"])
        for name, column in self._columns.items():
            while self._count + n > len(column):
                column = np.concatenate([column, np.empty_like(column)])
            self._columns[name] = column
            column[self._count : self._count + n] = rows[name]
        self._count += n

    @property
    def states(self) -> Floats:
        """[P, S]"""
        return self._float("states")

    @property
    def footings(self) -> Floats:
        """Where the character last stood [P, 3]; NaN if it has not yet."""
        return self._float("footing")

    @property
    def exit_points(self) -> Floats:
        """[P, 3]"""
        return self._float("exit_point")

    @property
    def grounded(self) -> Bools:
        """[P]"""
        return np.asarray(self._columns["grounded"][: self._count], dtype=np.bool_)

    @property
    def off_mesh_m(self) -> Floats:
        """Distance to the nav-mesh [P] [m], infinite where unexpected."""
        return self._float("off_mesh_m")

    @property
    def hopeless(self) -> Bools:
        """Points [P] that nothing can come of: in the air with nothing beneath."""
        return np.asarray(self._columns["hopeless"][: self._count], dtype=np.bool_)

    @property
    def cells(self) -> Ints:
        """Visit cells [P]"""
        return np.asarray(self._columns["cell"][: self._count], dtype=np.int64)

    @property
    def bytes_per_point(self) -> int:
        """What a cached point takes outside the tree."""
        return sum(int(column.nbytes // len(column)) for column in self._columns.values())

    def points(self) -> Points:
        """Everything as one frozen record."""
        rows = {
            name: column[: self._count].copy() for name, column in self._columns.items() if name not in OWN
        }
        return Points(**rows)  # type: ignore[arg-type]  # one dict of columns of several dtypes

    def _float(self, name: str) -> Floats:
        return np.asarray(self._columns[name][: self._count], dtype=np.float64)
