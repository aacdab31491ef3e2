"""The level as it was loaded.

Shape legend: F triangles.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from reachtest.records.arrays import Bools, Floats, Ints
from reachtest.records.settings import ExploreSettings, GateSettings

SINK_M = 0.1  # feet sink a little into the floor, and a zone may begin right on it


@dataclass(frozen=True)
class Frame:
    """The axes and units in which a file states its positions.

    `matrix` [3, 3] takes source coordinates to level coordinates (metres, z up).
    """

    matrix: Floats
    up_axis: str
    units: str

    @property
    def unit_m(self) -> float:
        """Metres a unit."""
        return float(np.linalg.norm(self.matrix[:, 0]))

    def size_m(self, low: Floats, high: Floats) -> Floats:
        """The sides [3] [m] of a box from `low` [3] to `high` [3], along the source's axes."""
        return np.asarray(np.abs(self.to_source(high) - self.to_source(low)) * self.unit_m, dtype=np.float64)

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

    def holds(self, feet: Floats) -> Bools:
        """Which of positions [n, 3] are in it: also who stands on the floor that it begins on."""
        low, high = self.box
        return np.asarray(((feet >= low) & (feet <= high)).all(axis=1), dtype=np.bool_)

    @property
    def box(self) -> tuple[Floats, Floats]:
        """Where the feet [3] to [3] of somebody in it are."""
        return self.low - [0, 0, SINK_M], self.high


@dataclass(frozen=True)
class Required:
    """A place that must be reached for the level to pass."""

    name: str
    position: Floats  # [3]
    within_m: float


@dataclass(frozen=True)
class Level:
    """Everything `level.yaml` names, in level coordinates."""

    name: str
    file: Path
    sha256: str  # of what level.yaml says but for explore and gate, and of every file it names
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
