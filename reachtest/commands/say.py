"""Results on stdout."""

from __future__ import annotations

import os
import sys


def say(text: str, end: str = "\n") -> None:
    """Print; once the reader has closed the pipe, as `head` does, go on in silence: the exit status is what counts."""
    try:
        print(text, end=end, flush=True)
    except BrokenPipeError:
        nothing = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nothing, sys.stdout.fileno())
        os.close(nothing)
