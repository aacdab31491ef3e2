"""Errors a user can cause, each with the exit status it ends the program with."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

EXIT_PASS, EXIT_FAIL, EXIT_BAD_INPUT, EXIT_INTERNAL, EXIT_INCONCLUSIVE = 0, 1, 2, 3, 4
EXIT_SIGINT, EXIT_SIGTERM = 130, 143


@dataclass(frozen=True)
class Problem:
    """One mistake in the input: where it is, what was found, what would be right."""

    where: str  # "level.yaml: geometry[0].mesh" or "nav.glb"
    found: str
    remedy: str

    def __str__(self) -> str:
        return f"{self.where}: {self.found}; {self.remedy}"


class ReachtestError(Exception):
    """Base of every error that the command line turns into a message and an exit status."""

    exit_status = EXIT_INTERNAL


class BadInput(ReachtestError):
    """The level, its files or the options are wrong; carries *all* mistakes found."""

    exit_status = EXIT_BAD_INPUT

    def __init__(self, problems: Sequence[Problem], source: Path | str | None = None) -> None:
        self.problems = tuple(problems)
        self.source = source
        super().__init__("\n".join(str(problem) for problem in self.problems))


class InternalError(ReachtestError):
    """An invariant of the program does not hold: never the level's fault."""
