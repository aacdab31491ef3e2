"""All exercises by their names."""

from __future__ import annotations

from collections.abc import Callable

from gym import air, ground, walls
from gym.exercise import Character, Exercise

EXERCISES: dict[str, Callable[[Character], Exercise | None]] = {
    **ground.EXERCISES,
    **air.EXERCISES,
    **walls.EXERCISES,
}
"""A builder each; None: nothing to exercise for this character. One line to add one."""
