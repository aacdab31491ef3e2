"""Results on stdout."""

from __future__ import annotations

import os
import sys


def say(text: str, end: str = "\n") -> None:
    """Print; once the reader has closed the pipe, as `head` does, go on in silence: the exit status is what counts.

    Raises OSError where it cannot be written, to a full disk. What was not written is forgotten then: Python would try
    again at its end, and leave with a status of its own.
    """
    try:
        print(text, end=end, flush=True)
    except OSError as error:
        nothing = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nothing, sys.stdout.fileno())
        os.close(nothing)
        if not isinstance(error, BrokenPipeError):
            raise
