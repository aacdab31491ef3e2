"""The records that cross between stages: frozen, with shapes and units.

Shape legend: B agents, T agent steps of one round, P cached points, S spawns, G goals, F triangles.
Positions are the character's *feet* in level coordinates: metres, z up, float64, unless said otherwise.
"""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]


# --- the level ------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Frame:
    """The axes and units in which a file states its positions.

    `matrix` [3, 3] takes source coordinates to level coordinates (metres, z up).
    """

    matrix: Floats
    up_axis: str
    units: str

    def to_level(self, points: Floats) -> Floats:
        """Source coordinates [..., 3] to level coordinates [..., 3] [m]."""
        return np.asarray(points, dtype=np.float64) @ self.matrix.T

    def to_source(self, points: Floats) -> Floats:
        """Level coordinates [..., 3] [m] to source coordinates [..., 3]."""
        return np.asarray(points, dtype=np.float64) @ np.linalg.inv(self.matrix).T


@dataclass(frozen=True)
class Character:
    """The capsule and its movement rules."""

    radius_m: float
    height_m: float
    walk_speed_mps: float
    jump_speed_mps: float
    step_height_m: float
    slope_limit_deg: float
    gravity_mps2: float
    terminal_speed_mps: float
    acceleration_mps2: float
    braking_mps2: float
    ground_friction: float  # [1/s] how fast the velocity turns towards the stick
    air_control: float  # fraction of the acceleration available in the air


@dataclass(frozen=True)
class Part:
    """A named piece of the level: what a designer would call the place."""

    name: str
    low: Floats  # [3]
    high: Floats  # [3]


@dataclass(frozen=True)
class Solid:
    """A closed surface that nobody may get into."""

    name: str
    triangles: Floats  # [F, 3, 3]


@dataclass(frozen=True)
class HeightField:
    """A terrain sampled on a grid along x and y. Shape legend: R rows, towards +y; C columns, towards +x."""

    low: Floats  # [2] x and y of the first sample
    high: Floats  # [2] of the last
    heights: Floats  # [R, C] z
    first: int = 0  # its triangles are those of `Level.collision` from this one on

    @property
    def points(self) -> Floats:
        """Positions [R, C, 3] of the samples."""
        rows, columns = self.heights.shape
        x, y = np.linspace(self.low, self.high, columns)[:, 0], np.linspace(self.low, self.high, rows)[:, 1]
        return np.stack([*np.meshgrid(x, y), self.heights], axis=2)


@dataclass(frozen=True)
class NavAgent:
    """For whom a nav-mesh was built; None where the file does not say."""

    radius_m: float | None = None
    height_m: float | None = None
    climb_m: float | None = None
    slope_deg: float | None = None


@dataclass(frozen=True)
class NavLink:
    """A connection the surface does not show: a ladder, a jump, a teleporter."""

    kind: str  # what the file calls it: "off-mesh", "jump", "ladder", ...
    start: Floats  # [3]
    end: Floats  # [3]
    radius_m: float
    both_ways: bool


@dataclass(frozen=True)
class NavMesh:
    """The walkable surface as the game's own path-finding has it."""

    file: str
    vertices: Floats  # [V, 3]
    faces: Ints  # [F, 3]
    format: str = ""  # what it was read from, for people
    polygons: int | None = None  # as the file counts them; None: its faces are its polygons
    agent: NavAgent = NavAgent()
    links: tuple[NavLink, ...] = ()
    areas: Ints | None = None  # [F] area type of each face, where the format has some

    @property
    def triangles(self) -> Floats:
        """Corner positions [F, 3, 3]."""
        return self.vertices[self.faces]


@dataclass(frozen=True)
class Spawn:
    """A place where the player starts, feet on the ground."""

    name: str
    position: Floats  # [3]


@dataclass(frozen=True)
class Zone:
    """An axis-aligned box with a meaning: `forbidden` or `allowed_off_mesh`."""

    name: str
    kind: str
    low: Floats  # [3]
    high: Floats  # [3]


@dataclass(frozen=True)
class Required:
    """A place that must be reached for the level to pass."""

    name: str
    position: Floats  # [3]
    within_m: float


OUTWARDS = (
    0.25  # of the directed lanes push over the border while goals are open: with half, these come later
)


@dataclass(frozen=True)
class ExploreSettings:
    """How to explore; defaults are the paper's where it states one."""

    agents: int = 16
    steps: int = 200_000  # [agent steps], over all agents
    time_budget_s: float | None = None
    reset_interval: int = (
        32  # [agent steps] an episode; the paper's 128 takes twice the steps: see the README
    )
    episodes_at_once: int = (
        8  # of each agent, between two looks at the cache: they are simulated side by side
    )
    threshold_m: float = 1.0  # K
    physics_hz: float = 30.0
    action_repeat: int = 4  # [physics steps an agent step]
    heuristics: dict[str, float] = field(
        default_factory=lambda: {"visits": 0.2, "goals": 0.2, "frontier": 0.4, "off_mesh": 0.2}
    )
    power: float = 2.0  # the paper's 1 leaves the last goals to chance: see the README
    goal_spacing_m: float = 4.0
    goal_radius_m: float = 1.0
    expected_within_m: float = 3.0
    directed: float = 0.25  # share of the lanes that push towards open goals and over the nav-mesh's border
    effort: int = 256  # directed attempts from its border before a part of the nav-mesh is called unreached
    stop_when_done: bool = False  # once everything is reached and `gate.max_discovery_probability` is met

    @property
    def directed_at_goals(self) -> float:
        """Share of the lanes that push towards open goals while there are some; the others push over the border."""
        return self.directed * (1.0 - OUTWARDS)

    @property
    def lanes(self) -> int:
        """Episodes simulated side by side: agent a has lanes a * episodes_at_once and following."""
        return self.agents * self.episodes_at_once


@dataclass(frozen=True)
class GateSettings:
    """What makes the run fail, and what a pass needs."""

    fail_on: tuple[str, ...]
    min_goals_reached: float = 1.0
    max_discovery_probability: float | None = None
    baseline: str | None = None  # file of known bugs, relative to level.yaml


@dataclass(frozen=True)
class Level:
    """Everything `level.yaml` names, in level coordinates."""

    name: str
    file: Path
    sha256: str  # of level.yaml and every file it names
    frame: Frame
    collision: Floats  # [F, 3, 3], outward normal by the right-hand rule where the source has one
    solids: tuple[Solid, ...]
    parts: tuple[Part, ...]
    navmesh: NavMesh
    character: Character
    spawns: tuple[Spawn, ...]
    kill_z_m: float
    bounds: tuple[Floats, Floats]  # low [3], high [3]
    zones: tuple[Zone, ...]
    required: tuple[Required, ...]
    explore: ExploreSettings
    gate: GateSettings
    height_fields: tuple[HeightField, ...] = ()  # in `collision` too, unless that was changed since


# --- the exploration ------------------------------------------------------------------------------


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

    cells: Floats  # [n, 3] a standing place in every cell of it
    points: Ints  # [m] cached points in it
    arrival: Fall  # an episode that got into it, as if it fell: it need not have left a cached point there
    stuck: bool  # a few metres and no way out; else a larger region with no way back to a spawn's island
    attempts: int  # directed episodes that tried to leave it
    sim_time_s: float  # of those attempts
    volume_m3: float  # of the cells of side K that they passed through
    reach_m: float  # farthest that any of them got from where it began


@dataclass(frozen=True)
class RiskSample:
    """What a run knew of the risk that remains at one moment; the unit of sampling is one episode."""

    agent_steps: int
    episodes: int  # t
    discovering: int  # of the episodes: found a cell that none before them had been to
    cells_once: int  # Q1: cells visited by exactly one episode
    cells_twice: int  # Q2
    cells_total: int
    recent_episodes: int  # the latest ones
    recent_discovering: int  # likewise, of those
    goals_reached: int
    points: int  # cached

    @property
    def discovery_probability(self) -> float:
        """Bound on the probability that the next episode finds a new cell: min(1, Q1 / t).

        Good-Turing for incidence data (Boehme, STADS, TOSEM 2018); an estimate, since sampling is adaptive.
        """
        return min(1.0, self.cells_once / max(self.episodes, 1))

    @property
    def estimated_cells_total(self) -> float:
        """Lower bound on the cells that exist: Chao2, with the episode as the unit of sampling."""
        once, twice, episodes = self.cells_once, self.cells_twice, max(self.episodes, 1)
        unseen = once**2 / (2 * twice) if twice else once * (once - 1) / 2
        return self.cells_total + (episodes - 1) / episodes * unseen

    @property
    def ten_times_longer(self) -> tuple[float, float]:
        """Between what numbers the cells lie that are likely to be seen after ten times the episodes.

        One is Chao2, usually the lower. The other takes Q1 to stay what it is, though it falls once most is seen:
        then episode u finds Q1 / u new cells, which adds up to Q1 ln 10; with two standard deviations of a count.
        """
        once = self.cells_once + 2 * math.sqrt(self.cells_once)
        steady = self.cells_total + once * math.log(10)
        return min(self.estimated_cells_total, steady), max(self.estimated_cells_total, steady)

    @property
    def recent_share(self) -> float | None:
        """Share of the latest episodes that found a new cell; None before the first."""
        return self.recent_discovering / self.recent_episodes if self.recent_episodes else None

    @property
    def risk(self) -> float:
        """What the gate goes by: the bound, or what the latest episodes did find where that is more.

        Go-Explore goes back to where few have been, so that Q1 is used up faster than by random sampling.
        """
        return max(self.discovery_probability, self.recent_share or 0.0)


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
    headings: NDArray[np.int8] = field(default_factory=lambda: np.zeros((0, 0), dtype=np.int8))
    # [rounds, B] the way each directed lane pushed (1 to 8 by 45 degrees, 9 to 16 jumping more); 0 for the others
    goal_attempts: Ints = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    # [G] directed at it since a goal of the same open part was reached last
    goal_border_m: Floats = field(default_factory=lambda: np.zeros(0))  # [G] nearest place they began at
    required_attempts: Ints = field(default_factory=lambda: np.zeros(0, dtype=np.int64))  # [R] likewise
    required_connected: Bools = field(
        default_factory=lambda: np.ones(0, dtype=np.bool_)
    )  # [R] to a spawn, by
    # the nav-mesh; empty: not known to be otherwise
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


# --- findings and report --------------------------------------------------------------------------

KINDS = (
    "unexpected_area",
    "fell_out_of_world",
    "inside_solid",
    "forbidden_zone",
    "stuck",
    "no_return",
    "unreached_area",
    "required_unreached",
    "navmesh_mismatch",
)
SEVERITIES = ("error", "warning")


@dataclass(frozen=True)
class ReplayPath:
    """The way to a finding, re-simulated: episode by episode from a spawn."""

    start: Floats  # [3]
    episodes: tuple[Origin, ...]
    positions: Floats  # [N, 3] every agent step
    duration_s: float
    attempts: int
    succeeded: int
    state: Floats | None = None  # [S] the simulator's state at the start
    actions: NDArray[np.int8] | None = (
        None  # [N, 2] every agent step; of a cut path no chain of episodes is left
    )
    states: Floats | None = None  # [N, S] after every agent step
    stood: Floats | None = None  # [N, 3] where it stood last during the step; NaN if it did not
    found_s: float | None = None  # how long the way was before it was cut


@dataclass(frozen=True)
class Confirmation:
    """How often a finding came about again, each as (attempts, succeeded)."""

    exact: tuple[int, int]  # bit for bit, from its path
    half_step: tuple[int, int]  # at half the physics time step: the found actions and variations of them
    nearby: tuple[int, int]  # variations at the run's own time step


@dataclass(frozen=True)
class Finding:
    """One bug for one human to look at."""

    id: str  # by name where it has one, else by place on a coarse grid: seeds agree but for places at its lines
    kind: str
    severity: str  # "error" | "warning"
    gating: bool
    title: str
    position: Floats  # [3]
    low: Floats  # [3]
    high: Floats  # [3]
    points: int
    exit_point: Floats | None  # [3]
    nearest_named: str | None
    first_seen_step: int | None
    path: ReplayPath | None
    suppressed_by: str | None
    confirmation: Confirmation | None = None  # None: nothing to re-simulate
    fragile: bool = False  # came about again at the coarse time step only, or not at all
    exits: Floats | None = None  # [n, 3] where paths left the nav-mesh on the way to it, thinned out
    details: tuple[str, ...] = ()  # what else there is to say, a line each


@dataclass(frozen=True)
class Verdict:
    """The outcome of a run."""

    name: str  # "pass" | "fail" | "inconclusive"
    exit_code: int
    reason: str


@dataclass(frozen=True)
class Report:
    """What every report output is written from."""

    level: Level
    exploration: Exploration
    findings: tuple[Finding, ...]
    verdict: Verdict
    tool_version: str
    started_at: str  # ISO 8601
    document: dict[str, Any]  # report.json, as the contract has it
