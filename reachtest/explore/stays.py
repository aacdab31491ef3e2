"""Stays: where characters stood, or came to rest (a wedge gives no footing).

Shape legend: B lanes, T agent steps of a round.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from reachtest.explore.rollout import Trajectories
from reachtest.geometry import at_rest
from reachtest.records import Bools, Floats


@dataclass(frozen=True)
class Stays:
    """Where characters stood, or lay still without standing."""

    places: Floats  # [..., 3] NaN where they did neither
    lying: Bools  # [...]


def stays_of(rolled: Trajectories) -> Stays:
    """Where the characters stood or lay still [T, B]."""
    stood = np.isfinite(rolled.stood)
    places = np.where(stood, rolled.stood, _resting(rolled))
    return Stays(places, ~stood[:, :, 0])


def _resting(rolled: Trajectories) -> Floats:
    """Positions [T, B, 3] of characters that do not move although they may not stand; else NaN."""
    moved = np.full(rolled.ended.shape, np.inf)
    moved[1:] = np.linalg.norm(rolled.positions[1:] - rolled.positions[:-1], axis=2)
    moved[rolled.start == np.arange(len(moved))[:, None]] = np.inf
    return np.where(at_rest(moved)[:, :, None], rolled.positions, np.nan)
