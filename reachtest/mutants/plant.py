"""The kinds of bugs that are planted. To add one: write a planter and name it in KINDS."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from reachtest.mutants.barriers import doors, steps
from reachtest.mutants.decide import Change, cut_off, opened
from reachtest.mutants.ground import Ground
from reachtest.mutants.openings import bare_solids, drawn, hole, pit
from reachtest.mutants.records import Judge, Planted, Planter
from reachtest.mutants.walls import gap, lowered

KINDS: dict[str, tuple[Planter, Judge]] = {
    "hole": (drawn(hole), opened),
    "missing wall": (drawn(gap), opened),
    "lowered wall": (drawn(lowered), opened),
    "bare solid": (bare_solids, opened),
    "blocked door": (doors, cut_off),
    "raised step": (steps, cut_off),
    "pit": (drawn(pit), opened),
}
_IN_VAIN: dict[Judge, int] = {
    opened: 25,
    cut_off: 10,
}  # planted, before a level is taken to have no (further) place for a kind
_APART_M = 2.0  # mutants of one kind


def plant(ground: Ground, kind: str, seed: int) -> Iterator[tuple[Planted, Change]]:
    """Bugs of one kind, one at a time, each with what it changes: nothing, where it does not count.

    Ends when the level seems to have no further place for one. The same for the same seed.
    """
    planter, judge = KINDS[kind]
    rng = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(list(KINDS).index(kind),)))
    taken, in_vain = np.zeros((0, 3)), 0
    for planted in planter(ground, rng):
        at = planted.mutant.position
        if len(taken) and np.linalg.norm(taken - at, axis=1).min() < _APART_M:
            continue
        taken = np.concatenate([taken, at[None]])
        change = judge(ground, planted.level, planted.mutant.box)
        yield planted, change
        in_vain = 0 if change.reasons else in_vain + 1
        if in_vain == _IN_VAIN[judge]:
            return
