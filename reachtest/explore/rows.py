"""Arrays that grow by the batch."""

from __future__ import annotations

import numpy as np
from numpy.typing import DTypeLike, NDArray

_FIRST = 1024


class Rows:
    """Rows in the order they came in; whenever room runs out there is twice as much."""

    def __init__(self, *shape: int, dtype: DTypeLike = np.float64) -> None:
        """Each row has a `shape`, none for a number."""
        self._room: NDArray[np.generic] = np.empty((_FIRST, *shape), dtype=dtype)
        self._count = 0

    def __len__(self) -> int:
        return self._count

    @property
    def values(self) -> NDArray[np.generic]:
        """[len(self), ...]; what was appended later is not in it."""
        return self._room[: self._count]

    def append(self, new: NDArray[np.generic]) -> None:
        """Add rows [n, ...]."""
        begin, self._count = self._count, self._count + len(new)
        while self._count > len(self._room):
            self._room = np.concatenate([self._room, np.empty_like(self._room)])
        self._room[begin : self._count] = new

    @property
    def row_bytes(self) -> int:
        """Memory of a row."""
        return self._room[:1].nbytes
