"""What only the reader knows about a level, kept beside it for the checks."""

from __future__ import annotations

from dataclasses import dataclass, field

from reachtest.records import Frame, Level


@dataclass(frozen=True)
class Reading:
    """How the files were read."""

    degenerate_collision: int  # triangles left out
    degenerate_navmesh: int
    navmesh_frame: Frame
    navmesh_scale: float


@dataclass(frozen=True)
class ReadLevel(Level):
    """A level that was read from files."""

    reading: Reading = field(kw_only=True)
