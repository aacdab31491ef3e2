"""Random choices that are the same on every machine and Python version."""

from __future__ import annotations

import random
from collections.abc import Sequence
from typing import TypeVar

T = TypeVar("T")


class Dice:
    """A stream of choices from a seed.

    Only `random()` is used, the one method whose sequence Python promises to keep for a seed.
    """

    def __init__(self, *seed: object) -> None:
        self._random = random.Random(" ".join(map(str, seed))).random

    def chance(self, probability: float) -> bool:
        """True with the given probability."""
        return self._random() < probability

    def pick(self, options: Sequence[T]) -> T:
        """One of `options`."""
        return options[int(self._random() * len(options))]

    def length(self, low: float, high: float, step: float = 0.25) -> float:
        """A multiple of `step` above `low`, at most `high`."""
        return low + step * int(self._random() * (int((high - low) / step + 1e-9) + 1))
