"""Arrays within a binary file: where they lie, and the message for a record that cannot be right."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from reachtest.levels.meshes.scene import Unreadable

Array = np.ndarray[Any, Any]


@dataclass(frozen=True)
class Section:
    """One array: where it starts, counted from the start of the file, and what it holds."""

    at: int  # [bytes]
    dtype: np.dtype[Any]
    count: int

    def read(self, data: bytes) -> Array:
        """The array [count]; the caller has checked that the file reaches so far."""
        return np.frombuffer(data, self.dtype, self.count, self.at if self.count else 0)

    def refuse(self, wrong: Array, name: str, found: str, remedy: str, rows: Array | None = None) -> None:
        """Raise Unreadable, with the byte, for the first of `rows` (of all, by default) that is `wrong`."""
        if wrong.any():
            first = int(np.argmax(wrong))
            row = first if rows is None else int(rows[first])
            raise Unreadable(
                f"has {name}[{row}] at byte {self.at + row * self.dtype.itemsize} {found}", remedy
            )
