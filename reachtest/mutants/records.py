"""What is planted, and what became of it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from reachtest.mutants.boxes import Box
from reachtest.mutants.decide import Change
from reachtest.mutants.ground import Ground
from reachtest.records import Floats, Level


@dataclass(frozen=True)
class Mutant:
    """One planted bug."""

    kind: str
    box: Box  # what was taken out or put in
    expected: tuple[str, ...]  # kinds of findings that tell it

    @property
    def position(self) -> Floats:
        """Its middle [3] m."""
        return self.box.centre


@dataclass(frozen=True)
class Planted:
    """A level with a mutant in it."""

    level: Level
    mutant: Mutant


Planter = Callable[[Ground, np.random.Generator], Iterator[Planted]]
Judge = Callable[[Ground, Level, Box], Change]
