"""Progress on stderr: a bar on a terminal, a plain line every few seconds elsewhere."""

from __future__ import annotations

import sys
import time
from types import TracebackType
from typing import Protocol, Self, TextIO

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

from reachtest.records import ExploreSettings, RoundRecord

LINE_EVERY_S = 5.0


class ProgressDisplay(Protocol):
    """An observer that is opened and closed around the run."""

    def __enter__(self) -> Self: ...

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None: ...

    def on_round(self, record: RoundRecord) -> None:
        """Show where the run stands."""

    def tell(self, what: str, number: int, total: int) -> None:
        """Show where the work after the exploration stands: see `interfaces.Teller`."""


class BarProgress:
    """A rich progress bar: steps, steps/s, points, goals reached, time left."""

    def __init__(self, settings: ExploreSettings, stream: TextIO) -> None:
        console = Console(file=stream)
        columns = (
            TextColumn("{task.fields[count]}"),
            BarColumn(bar_width=24),
            TextColumn("{task.fields[what]}"),
            TextColumn("left"),
            TimeRemainingColumn(),
        )
        self._progress = Progress(*columns, console=console, transient=True)
        self._task = self._progress.add_task("", total=settings.steps, count="0 steps", what="starting")
        self._began, self._phase = time.monotonic(), ""

    def __enter__(self) -> Self:
        self._progress.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._progress.stop()

    def on_round(self, record: RoundRecord) -> None:
        """Move the bar."""
        what = _what(record, time.monotonic() - self._began)
        steps = f"{record.agent_steps:,} steps"
        self._progress.update(self._task, completed=record.agent_steps, count=steps, what=what)

    def tell(self, what: str, number: int, total: int) -> None:
        """Begin a new bar for each kind of work, and move it."""
        if what != self._phase:
            self._phase = what
            self._progress.reset(self._task, total=total)
        count = f"{number:,} of {total:,}"
        self._progress.update(self._task, total=total, completed=number - 1, count=count, what=what)


class LineProgress:
    """One plain line every few seconds, for logs of a build."""

    def __init__(self, settings: ExploreSettings, stream: TextIO) -> None:
        self._total, self._stream = settings.steps, stream
        self._began = self._last = time.monotonic()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        return None

    def on_round(self, record: RoundRecord) -> None:
        """Print a line when the last one is old enough."""
        if not self._is_time():
            return
        now = time.monotonic()
        left = (now - self._began) * max(self._total - record.agent_steps, 0) / record.agent_steps
        text = f"{record.agent_steps:,} of {self._total:,} steps, {_what(record, now - self._began)}"
        print(f"{text}, about {left:.0f} s left", file=self._stream, flush=True)

    def tell(self, what: str, number: int, total: int) -> None:
        """Print a line when the last one is old enough."""
        if self._is_time():
            print(f"{what}, {number:,} of {total:,}", file=self._stream, flush=True)

    def _is_time(self) -> bool:
        now = time.monotonic()
        due = now - self._last >= LINE_EVERY_S
        if due:
            self._last = now
        return due


class NoProgress(LineProgress):
    """Says nothing."""

    def on_round(self, record: RoundRecord) -> None:
        """Ignore the round."""

    def tell(self, what: str, number: int, total: int) -> None:
        """Ignore the work."""


def progress_for(settings: ExploreSettings, quiet: bool, stream: TextIO | None = None) -> ProgressDisplay:
    """The display that fits where stderr goes."""
    stream = stream or sys.stderr
    if quiet:
        return NoProgress(settings, stream)
    return BarProgress(settings, stream) if stream.isatty() else LineProgress(settings, stream)


def _what(record: RoundRecord, elapsed_s: float) -> str:
    rate = record.agent_steps / max(elapsed_s, 1e-9)
    goals = f"{record.goals_reached} of {record.goals_total} goals"
    falls = f", {record.falls} fall{'s' * (record.falls != 1)}" if record.falls else ""
    share = record.discovery_share
    new = "" if share is None else f", {share:.0%} of episodes find something new"
    return f"{rate:,.0f} steps/s, {record.points:,} points, {goals}{falls}{new}"
