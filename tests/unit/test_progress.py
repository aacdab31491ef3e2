"""Progress on stderr, and signals: what a person or a build log sees of a run."""

from __future__ import annotations

import io
import os
import signal
from dataclasses import replace

import numpy as np
import pytest

from reachtest import progress
from reachtest.progress import progress_for
from reachtest.records import ExploreSettings, RoundRecord, StopReason
from reachtest.signals import StopOnSignal

SETTINGS = ExploreSettings(steps=200_000)


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def record(steps: int, falls: int = 0) -> RoundRecord:
    none = np.empty((0, 3))
    return RoundRecord(0, steps, 1.0, np.empty((0, 16, 3)), none, np.empty(0, dtype=bool), 1_234, 5, 9, falls)


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """The time in seconds, as its only item."""
    now = [100.0]
    monkeypatch.setattr(progress.time, "monotonic", lambda: now[0])
    return now


def test_a_build_log_gets_a_line_every_few_seconds(clock) -> None:
    stream = io.StringIO()
    with progress_for(SETTINGS, quiet=False, stream=stream) as display:
        for second in range(20):
            clock[0] += 1.0
            display.on_round(record(2_000 * (second + 1), falls=second // 10))
    lines = stream.getvalue().splitlines()
    assert len(lines) == 4
    assert "\x1b" not in stream.getvalue()  # no escape codes in a log
    for fact in ("10,000 of 200,000 steps", "2,000 steps/s", "1,234 points", "5 of 9 goals", "95 s left"):
        assert fact in lines[0]
    assert "falls" not in lines[0]
    assert "1 fall" in lines[-1]


def test_it_shows_how_much_there_still_is_to_find(clock) -> None:
    stream = io.StringIO()
    with progress_for(SETTINGS, quiet=False, stream=stream) as display:
        for share in (None, 0.42):
            clock[0] += 6.0
            display.on_round(replace(record(2_000), discovery_share=share))
    first, second = stream.getvalue().splitlines()
    assert "something new" not in first
    assert "42% of episodes find something new" in second


def test_a_terminal_gets_a_bar(clock) -> None:
    stream = Terminal()
    with progress_for(SETTINGS, quiet=False, stream=stream) as display:
        clock[0] += 10.0
        display.on_round(record(20_000))
        display._progress.refresh()  # the bar is drawn ten times a second by a thread of its own
    for fact in ("20,000 steps", "2,000 steps/s", "1,234 points", "5 of 9 goals"):
        assert fact in stream.getvalue()


def test_the_work_after_the_exploration_is_told_too(clock) -> None:
    log, terminal = io.StringIO(), Terminal()
    with progress_for(SETTINGS, quiet=False, stream=log) as display:
        for second in range(12):
            clock[0] += 1.0
            display.tell("looking for pockets", second + 1, 12)
    assert log.getvalue().splitlines() == ["looking for pockets, 5 of 12", "looking for pockets, 10 of 12"]
    with progress_for(SETTINGS, quiet=False, stream=terminal) as display:
        display.on_round(record(20_000))
        display.tell("confirming findings", 2, 5)
        display._progress.refresh()
    assert "2 of 5" in terminal.getvalue()
    assert "confirming findings" in terminal.getvalue()


@pytest.mark.parametrize("stream", [io.StringIO(), Terminal()], ids=["log", "terminal"])
def test_quiet_says_nothing(clock, stream) -> None:
    with progress_for(SETTINGS, quiet=True, stream=stream) as display:
        clock[0] += 60.0
        display.on_round(record(20_000))
        display.tell("confirming findings", 2, 5)
    assert stream.getvalue() == ""


@pytest.mark.parametrize(
    ("number", "reason"),
    [(signal.SIGINT, StopReason.INTERRUPTED), (signal.SIGTERM, StopReason.TERMINATED)],
)
def test_a_signal_is_remembered_and_the_second_one_acts_as_usual(number, reason) -> None:
    seen: list[int] = []
    before = signal.signal(number, lambda n, _: seen.append(n))
    try:
        with StopOnSignal() as stop:
            assert stop() is None
            os.kill(os.getpid(), number)
            assert stop() is reason
            assert seen == []
            os.kill(os.getpid(), number)
            assert seen == [number]
            assert stop() is reason
        os.kill(os.getpid(), number)
        assert seen == [number, number]
    finally:
        signal.signal(number, before)


def test_without_a_signal_everything_is_as_before() -> None:
    before = signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGTERM)
    with StopOnSignal() as stop:
        assert signal.getsignal(signal.SIGINT) != before[0]
    assert (signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGTERM)) == before
    assert stop() is None
