"""The gym (maps/gym): what a character can and cannot do, for every preset and for numbers of one's own."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest

from tests.gym import CHARACTERS, EXERCISES, perform


@cache
def performed(name: str, who: str) -> tuple[Any, Any] | None:
    """The exercise and its track; None where there is nothing to exercise."""
    character = CHARACTERS[who]
    exercise = EXERCISES[name](character)
    return None if exercise is None else (exercise, perform(exercise, character))


@pytest.mark.parametrize("who", CHARACTERS)
@pytest.mark.parametrize("name", EXERCISES)
def test_exercise(name: str, who: str) -> None:
    done = performed(name, who)
    if done is None:
        assert CHARACTERS[who].step_height_m == 0
        pytest.skip("this character has no step-up")
    exercise, track = done
    failed = [
        f"{check.what}: {check.value(track):.3f}, not {check.at_least:.3f} to {check.at_most:.3f}"
        for check in exercise.checks
        if not check.holds(track)
    ]
    assert not failed, "; ".join(failed)


@pytest.mark.parametrize("who", CHARACTERS)
@pytest.mark.parametrize(
    ("narrow", "wide"),
    [
        ("opening of the capsule's width - 5 cm", "opening of the capsule's width + 5 cm"),
        ("ceiling of the capsule's height - 5 cm", "ceiling of the capsule's height + 5 cm"),
        ("gap 3 % wider than jump and overhang", "gap 3 % narrower than the jump carries"),
        ("slope of the limit + 1 degree", "slope of the limit - 1 degree"),
        ("slope of the limit + 1 degree, run-up", "slope of the limit - 1 degree, run-up"),
    ],
)
def test_what_is_not_passed_fails_the_checks_of_what_is(narrow: str, wide: str, who: str) -> None:
    """And so the checks can fail: a track of the one does not pass for the other."""
    (hard, hard_track), (easy, easy_track) = performed(narrow, who), performed(wide, who)
    assert not all(check.holds(hard_track) for check in easy.checks)
    assert not all(check.holds(easy_track) for check in hard.checks)


def test_tracks_are_the_same_every_time() -> None:
    name = "jumping into a corner, jittering"
    again = perform(EXERCISES[name](CHARACTERS["unreal"]), CHARACTERS["unreal"])
    np.testing.assert_array_equal(performed(name, "unreal")[1].path, again.path)
