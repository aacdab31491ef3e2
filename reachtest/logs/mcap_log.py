"""`McapLog`: follows a run and writes `run.mcap` for Foxglove, Lichtblick and Rerun."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from types import TracebackType
from typing import BinaryIO, Self

import numpy as np

from reachtest.errors import BadInput, Problem
from reachtest.logs.channels import Channels
from reachtest.records import Finding, Level, RoundRecord

AGENT_INSTANTS = (
    8  # pose messages a round: enough to see the agents move, a sixteenth of the bytes of all steps
)
PROGRESS_ROUNDS = 10


class McapLog:
    """An observer that writes each round to an MCAP file, stamped with simulated time only.

    The file grows under a temporary name (`.run.mcap.part` beside `run.mcap`) and gets its own when it is
    closed, also after an exception in the with-block. A process that is killed leaves the `.part` file,
    complete up to its last whole chunk: what is lost is at most 32 KiB of messages before compression, which
    is the last 5 rounds of 16 agents (measured). `recover` or the `mcap recover` command makes a whole file.

    Topics: `/tf`, `/level`, `/navmesh`, `/coverage` (the *new* points of each round: let the viewer
    accumulate them), `/agents`, `/findings`, `/findings/points` (for viewers without scenes), `/log`.
    """

    def __init__(self, path: Path, level: Level, round_s: float) -> None:
        """Start the file for `path`; `round_s` is the simulated time of one round [s]. Raises OSError."""
        self._path = path
        self._part = path.with_name(f".{path.name}.part")
        self._level = level
        self._round_s = round_s
        self._started = False
        path.parent.mkdir(parents=True, exist_ok=True)
        self._stream = _alone(self._part)
        self._channels = Channels(self._stream)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def on_round(self, record: RoundRecord) -> None:
        """Write the agents' poses, the new points and now and then a line of progress."""
        from reachtest.logs.clouds import cloud, log_line

        begin_ns = _ns(record.sim_time_s - self._round_s)
        end_ns = _ns(record.sim_time_s)
        self._start(begin_ns)
        self._write_agents(record, begin_ns, end_ns)
        if len(record.new_points):
            self._channels.write("/coverage", cloud(record.new_points, record.new_expected, end_ns), end_ns)
        if (record.round + 1) % PROGRESS_ROUNDS == 0:
            self._channels.write("/log", log_line(_progress(record), "info", end_ns), end_ns)
        self._channels.flush()

    def finish(self, findings: tuple[Finding, ...]) -> None:
        """Write the findings, at the simulated time at which the run ended."""
        from reachtest.logs.clouds import cloud, log_line
        from reachtest.logs.scene import findings_scene

        self._start(0)
        now = self._channels.time_ns
        self._channels.write("/findings", findings_scene(findings, now), now)
        places = np.array([finding.position for finding in findings], dtype=np.float64).reshape(-1, 3)
        on_mesh = np.zeros(len(findings), dtype=np.bool_)
        self._channels.write("/findings/points", cloud(places, on_mesh, now), now)
        for finding in findings:
            line = f"{finding.kind} [{finding.id}]: {finding.title}"
            self._channels.write("/log", log_line(line, finding.severity, now), now)
        self._channels.flush()

    def close(self) -> None:
        """Finish the file and give it its name. Closing twice does nothing."""
        if self._stream.closed:
            return
        with self._stream:
            self._start(0)
            self._channels.finish()
        os.replace(self._part, self._path)

    def _start(self, time_ns: int) -> None:
        """The level and its nav-mesh, once, when the time is known: a resumed run does not begin at zero."""
        if self._started:
            return
        from reachtest.logs import scene
        from reachtest.logs.clouds import transform

        self._started = True
        level, navmesh = self._level.collision, self._level.navmesh.triangles
        self._channels.write("/tf", transform(time_ns), time_ns)
        self._channels.write(
            "/level", scene.triangles("level", level, scene.LEVEL_COLOUR, 0.0, time_ns), time_ns
        )
        green = scene.triangles("navmesh", navmesh, scene.NAVMESH_COLOUR, scene.NAVMESH_LIFT_M, time_ns)
        self._channels.write("/navmesh", green, time_ns)

    def _write_agents(self, record: RoundRecord, begin_ns: int, end_ns: int) -> None:
        from reachtest.logs.clouds import poses

        steps = len(record.trajectories)
        instants = np.linspace(0, steps, min(steps, AGENT_INSTANTS) + 1)[1:].round().astype(np.int64)
        for instant in instants.tolist():
            time_ns = begin_ns + (end_ns - begin_ns) * instant // steps
            self._channels.write("/agents", poses(record.trajectories[instant - 1], time_ns), time_ns)


def _alone(part: Path) -> BinaryIO:
    """The file, empty and open for writing. Raises BadInput while another run has it open."""
    stream = os.fdopen(os.open(part, os.O_RDWR | os.O_CREAT | getattr(os, "O_BINARY", 0), 0o666), "wb")
    if sys.platform != "win32":
        import fcntl

        try:
            fcntl.flock(stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as error:
            stream.close()
            found = "another run is writing there"
            raise BadInput(
                [Problem(f"{part.parent}", found, "give each run a folder of its own with --out")]
            ) from error
        except OSError:  # some network drives know no locks
            pass
    stream.truncate(0)
    return stream


def _ns(time_s: float) -> int:
    return max(0, round(time_s * 1e9))


def _progress(record: RoundRecord) -> str:
    return (
        f"{record.round + 1} rounds: {record.points} positions, "
        f"{record.goals_reached} of {record.goals_total} goals, {record.falls} falls"
    )
