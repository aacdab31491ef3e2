"""The exercises of maps/gym, and somebody who does them."""

from __future__ import annotations

import importlib
import sys
from pathlib import Path
from typing import Any

import numpy as np

from reachtest.records import Character
from tests.levels import Walk

MAPS = Path(__file__).parents[1] / "maps"


def _gym(module: str) -> Any:
    sys.path.insert(0, str(MAPS))
    try:
        return importlib.import_module(f"gym.{module}")
    finally:
        sys.path.remove(str(MAPS))


EXERCISES = _gym("table").EXERCISES
CHARACTERS: dict[str, Character] = _gym("characters").CHARACTERS
Track, triangles_of = _gym("exercise").Track, _gym("shapes").triangles_of
EDGE_M = 0.002  # this near to an edge is at the edge


def perform(exercise: Any, character: Character) -> Any:
    """The track of a character that follows the exercise's script."""
    start = np.array(exercise.start) + [0, 0, exercise.drop_m]
    track = _walk(exercise, start, character)
    for hold, mark in zip(exercise.script, track.marks, strict=True):
        if hold.until_x is not None:  # again, moved so that a tick ends right there
            start[0] += hold.until_x - EDGE_M - track.path[mark, 0]
            return _walk(exercise, start, character)
    return track


def _walk(exercise: Any, start: np.ndarray, character: Character) -> Any:
    solid = [triangles_of(piece) for piece in exercise.pieces]
    walk = Walk(*solid, exercise.triangles, start=start, character=character)
    marks = []
    for hold in exercise.script:
        if hold.until_x is None:
            walk.go(hold.seconds, hold.stick, hold.jump)
        else:
            _walk_up_to(walk, hold)
        marks.append(len(walk.path) - 1)
    return Track(walk.path, np.array(walk.grounded), walk.dt, tuple(marks))


def _walk_up_to(walk: Walk, hold: Any) -> None:
    tick = 0.0
    for _ in range(round(hold.seconds / walk.dt)):
        if walk.here[0] + tick >= hold.until_x:
            return
        before = walk.here[0]
        walk.go(walk.dt, hold.stick, hold.jump)
        tick = walk.here[0] - before
