"""The Protocols at the seams: what a new simulator, heuristic, observer or report output has to offer."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from reachtest.records import Candidates, Fall, Floats, Ints, ReplayPath, Report, RoundRecord, StepResult


class Simulator(Protocol):
    """Simulates B agents that cannot touch each other; states are rows of float64 that begin with
    the position [3] and the velocity [3] and are opaque otherwise."""

    @property
    def agents(self) -> int:
        """B, where all are in use."""

    @property
    def step_s(self) -> float:
        """Simulated time of one agent step [s]."""

    def place(self, positions: Floats) -> Floats:
        """States [n, S] of agents standing still with their feet at `positions` [n, 3]."""

    def use(self, agents: int) -> None:
        """From now on only the first `agents` take part, and B is that many: the others cost nothing.

        Who was not in use before has to be restored.
        """

    def restore(self, agents: Ints, states: Floats) -> None:
        """Put `agents` [n] into `states` [n, S]."""

    def save(self) -> Floats:
        """The states [B, S] of all agents, enough to go on bit for bit."""

    def step(self, actions: NDArray[np.int8]) -> StepResult:
        """One agent step: `actions` [B, 2] = stick (0 centred, 1 to 8 by 45 degrees), jump (0 or 1)."""


class ResetHeuristic(Protocol):
    """eta of the paper: how promising each cached point is to restart from."""

    def __call__(self, candidates: Candidates) -> Floats:
        """Priorities [P] >= 0, on any scale: mixtures normalise them. All zero: has no opinion."""


class Surface(Protocol):
    """The nav-mesh surface, asked for distances."""

    def distance(self, points: Floats) -> Floats:
        """Distance of each of `points` [n, 3] to the surface [n] [m]; infinite beyond `expected_within_m`."""


class Replayer(Protocol):
    """Re-simulates the way to what was found."""

    def path_to_point(self, index: int) -> ReplayPath:
        """The way from a spawn to cached point `index`."""

    def path_to_fall(self, fall: Fall) -> ReplayPath:
        """The way from a spawn out of the world."""

    def flights(self, falls: Sequence[Fall]) -> list[Floats]:
        """Where each of `falls` [m] went [n, 3] from where it stood last, as far as its last episode tells."""


class Observer(Protocol):
    """Is told of every round while the exploration runs."""

    def on_round(self, record: RoundRecord) -> None:
        """Called after each round, in order, from one thread."""


class Teller(Protocol):
    """Is told how far the work after the exploration is, often: what it is, and at which of how many."""

    def __call__(self, what: str, number: int, total: int) -> None:
        """Called in order, from one thread."""


class ReportOutput(Protocol):
    """Renders a report to one file."""

    def __call__(self, report: Report) -> str:
        """The whole text of the file."""
