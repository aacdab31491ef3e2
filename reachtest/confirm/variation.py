"""Other random actions around found ones."""

from __future__ import annotations

import numpy as np

from reachtest.confirm.trials import Actions

EDITS = (1, 2, 3)  # of a variation: few, or a long script is lost
EDIT_STEPS = 6  # [agent steps] that a replaced piece has, as long as a hold


def vary(actions: Actions, steps: int, rng: np.random.Generator) -> Actions:
    """`actions` [t, 2], some of them doubled, left out or replaced, and the last one held to `steps` in all."""
    result = actions.copy()
    for _ in range(int(rng.choice(EDITS))):
        at, what = int(rng.integers(len(result))), int(rng.integers(3))
        if what == 0:
            result = np.insert(result, at, result[at], axis=0)
        elif what == 1 and len(result) > 1:
            result = np.delete(result, at, axis=0)
        else:
            result[at : at + int(rng.integers(1, EDIT_STEPS + 1))] = rng.integers(0, 9), rng.integers(0, 2)
    return held(result, steps)


def held(actions: Actions, steps: int) -> Actions:
    """`actions` [t, 2], the last one held to `steps` in all."""
    rest = np.repeat(actions[-1:], max(steps - len(actions), 0), axis=0)
    return np.concatenate([actions, rest])[:steps]
