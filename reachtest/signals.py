"""SIGINT and SIGTERM end a run at the next round, with what was found so far."""

from __future__ import annotations

import signal
from types import FrameType, TracebackType
from typing import Self

from reachtest.records import StopReason

_REASONS = {signal.SIGINT: StopReason.INTERRUPTED, signal.SIGTERM: StopReason.TERMINATED}


class StopOnSignal:
    """While open, remembers the first signal; a second one of the kind ends the process as usual."""

    def __init__(self) -> None:
        self._reason: StopReason | None = None
        self._before: dict[signal.Signals, signal.Handlers] = {}

    def __call__(self) -> StopReason | None:
        """Why the run should stop, if it should."""
        return self._reason

    def __enter__(self) -> Self:
        for number in _REASONS:
            self._before[number] = signal.signal(number, self._note)  # type: ignore[assignment]
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._restore()

    def _note(self, number: int, frame: FrameType | None) -> None:
        self._reason = _REASONS[signal.Signals(number)]
        self._restore()

    def _restore(self) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)
