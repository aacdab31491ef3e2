"""What an exploration hands from round to round, and what came of it.

Shape legend: B agents, T agent steps of one round, P cached points, G goals, R required points.
"""

from __future__ import annotations

import enum
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from reachtest.records.arrays import Bools, Floats, Ints
from reachtest.records.risk import RiskSample
from reachtest.records.settings import ExploreSettings


class StopReason(enum.Enum):
    """Why the exploration ended, with the sentence for the report."""

    STEPS = "the step budget was used up"
    TIME = "the time budget was used up"
    INTERRUPTED = "interrupted (SIGINT)"
    TERMINATED = "terminated (SIGTERM)"
    DONE = "everything was reached and the risk is below the limit"


class EndReason(enum.IntEnum):
    """How an agent step left the agent."""

    ALIVE = 0
    FELL = 1  # below kill_z_m or outside the bounds
    DIVERGED = 2  # NaN, simulator warning or error: never becomes a position


@dataclass(frozen=True)
class StepResult:
    """What one agent step of every agent gave."""

    positions: Floats  # [B, 3]
    grounded: Bools  # [B] at the end of the step
    stood: (
        Floats  # [B, 3] where it stood last *during* the step (a hop touches the ground in between); else NaN
    )
    ended: NDArray[np.int8]  # [B] EndReason


@dataclass(frozen=True)
class Origin:
    """Where a position came from: enough to re-simulate it.

    The episode restored cached point `parent` (or spawn -1 - parent, if negative) at step `start` of round
    `round`, and lane `agent` (see `ExploreSettings.lanes`) then took the actions `start + 1 ... step` of its stream.
    """

    parent: int
    round: int
    agent: int
    start: int  # [agent steps] into the round
    step: int  # [agent steps] into the round


@dataclass(frozen=True)
class Fall:
    """One episode that left the world."""

    origin: Origin
    position: Floats  # [3] where it crossed the limit
    footing: Floats  # [3] where the character last stood; the spawn if it never did
    exit_point: Floats  # [3] where it last stood at an expected position; NaN if it did not yet


@dataclass(frozen=True)
class Points:
    """The position cache as arrays, row by row in order of discovery."""

    positions: Floats  # [P, 3]
    states: Floats  # [P, S] what the simulator needs to go on bit for bit
    grounded: Bools  # [P]
    parent: NDArray[np.int32]  # [P] cached point the episode started from; -1 - i for spawn i
    round: NDArray[np.int32]  # [P]
    agent: NDArray[np.int32]  # [P] lane
    start: NDArray[np.int16]  # [P]
    step: NDArray[np.int16]  # [P]
    off_mesh_m: Floats  # [P] distance to the nav-mesh surface; infinite beyond `expected_within_m`
    exit_point: Floats  # [P, 3] where the character last stood at an expected position; NaN if it did not yet

    @property
    def expected(self) -> Bools:
        """Which points [P] lie within `expected_within_m` of the nav-mesh surface."""
        return np.isfinite(self.off_mesh_m)

    def origin(self, index: int) -> Origin:
        """Where point `index` came from."""
        fields = (self.parent, self.round, self.agent, self.start, self.step)
        return Origin(*(int(column[index]) for column in fields))

    def __len__(self) -> int:
        return len(self.positions)


@dataclass(frozen=True)
class Candidates:
    """What a reset heuristic may ask about the cached points."""

    visits: Ints  # [P] episodes that visited the point's cell: n(s)
    goal_distance: Floats  # [P] to the nearest open goal [m]; infinite when none is open
    off_mesh_m: NDArray[np.floating]  # [P] distance to the nav-mesh; infinite beyond `expected_within_m`
    expected_within_m: float
    grounded: Bools  # [P]
    above_m: NDArray[np.floating]  # [P] the floor below [m]; infinite over nothing
    velocities: Floats  # [P, 3] [m/s]


@dataclass(frozen=True)
class RoundRecord:
    """What one round brought: handed to observers (progress, MCAP log) while the run goes on."""

    round: int
    agent_steps: int  # [agent steps] so far, over all agents
    sim_time_s: float  # simulated time at the end of the round, one agent's
    trajectories: Floats  # [T, B, 3]; NaN where an agent step gave no position
    new_points: Floats  # [n, 3]
    new_expected: Bools  # [n]
    points: int  # cached so far
    goals_reached: int
    goals_total: int
    falls: int  # so far
    discovery_share: float | None = None  # of the latest episodes, how many found a new cell


@dataclass(frozen=True)
class Pocket:
    """A region from which nothing found leads back to a spawn, after directed attempts to return."""

    cells: Floats  # [n, 3] a standing place in every cell of it that one ends up in: not of those on the way
    points: Ints  # [m] cached points in it
    arrival: Fall  # an episode that got into it, as if it fell: it need not have left a cached point there
    stuck: bool  # a few metres and no way out; else a larger region with no way back to a spawn's island
    attempts: int  # directed episodes that tried to leave it
    sim_time_s: float  # of those attempts
    volume_m3: float  # of the cells of side K that they passed through
    reach_m: float  # farthest that any of them got from where it began


@dataclass(frozen=True)
class Exploration:
    """Everything the exploration found."""

    points: Points
    visits: Ints  # [P] episodes that visited the point's cell
    goals: Floats  # [G, 3]
    goal_step: Ints  # [G] agent step at which it was reached; -1 if it was not
    required_step: Ints  # likewise for the level's required points, in their order
    falls: tuple[Fall, ...]
    agent_steps: int
    episodes: int
    diverged_episodes: int
    cells_once: int  # Q1: cells visited by exactly one episode
    cells_twice: int  # Q2
    cells_total: int
    stop_reason: StopReason
    seed: int
    settings: ExploreSettings
    timing: dict[str, float]  # physics_s, cache_s, rest_s, wall_s
    headings: NDArray[np.int16] = field(default_factory=lambda: np.zeros((0, 0), dtype=np.int16))
    # [rounds, B] what each directed lane began with (see `explore.actions.action_stream`); 0 for the others
    goal_attempts: Ints = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    # [G] directed at it since a goal of the same open part was reached last
    goal_border_m: Floats = field(default_factory=lambda: np.zeros(0))  # [G] nearest place they began at
    required_attempts: Ints = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    # [R] likewise, at the whole open part that a required point lies in
    required_connected: Bools = field(
        default_factory=lambda: np.ones(0, dtype=np.bool_)
    )  # [R] to a spawn, by
    # the nav-mesh; empty: not known to be otherwise
    trespasses: Mapping[tuple[str, str], Fall] = field(default_factory=dict)
    # where somebody was first seen in each solid and forbidden zone, by kind of finding and name
    pockets: tuple[Pocket, ...] = ()
    probe_episodes: int = 0  # of the search for ways back; outside the step budget
    probe_steps: int = 0  # [agent steps] likewise
    risk_curve: tuple[RiskSample, ...] = ()  # over the run, evenly in agent steps; the last is its end
    border: Floats = field(
        default_factory=lambda: np.zeros((0, 3))
    )  # [n, 3] places along the nav-mesh's border
    border_pushes: Ints = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    # [n] episodes that pushed outwards there, on purpose or not

    @property
    def discovery_probability(self) -> float:
        """Bound on the probability that the next episode finds a new cell: see `RiskSample`."""
        return self._at_the_end.discovery_probability

    @property
    def estimated_cells_total(self) -> float:
        """Lower bound on the cells that exist: see `RiskSample`."""
        return self._at_the_end.estimated_cells_total

    @property
    def risk(self) -> float:
        """What the gate goes by: see `RiskSample`."""
        return max([self.discovery_probability, *(sample.risk for sample in self.risk_curve[-1:])])

    @property
    def _at_the_end(self) -> RiskSample:
        cells = (self.cells_once, self.cells_twice, self.cells_total)
        return RiskSample(self.agent_steps, self.episodes, 0, *cells, 0, 0, 0, 0)
