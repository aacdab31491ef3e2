"""Reset heuristics: which cached point is worth restarting from.

To add one: write the function and name it in HEURISTICS. Level files name them with weights.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial

import numpy as np

from reachtest.interfaces import ResetHeuristic
from reachtest.records import Floats, Ints


def visits(visits: Ints, goal_distance: Floats) -> Floats:
    """1 / n(s): seldom visited places first (paper, "Visitation-Based")."""
    return np.asarray(1.0 / np.maximum(visits, 1), dtype=np.float64)


def goals(visits: Ints, goal_distance: Floats, radius_m: float) -> Floats:
    """1 / d(S_nav-mesh, s): near goals that are still open (paper, "Nav-Mesh Goal Guided").

    A point can be nearer than the radius at which goals drain (a later position drained the goal's
    neighbour), so the distance is bounded below by it.
    """
    return np.asarray(1.0 / np.maximum(goal_distance, radius_m), dtype=np.float64)


def uniform(visits: Ints, goal_distance: Floats) -> Floats:
    """Every cached point alike: the paper's ablation."""
    return np.ones(len(visits))


HEURISTICS: dict[str, Callable[[float], ResetHeuristic]] = {
    "visits": lambda radius_m: visits,
    "goals": lambda radius_m: partial(goals, radius_m=radius_m),
    "uniform": lambda radius_m: uniform,
}


def mixture(weights: Mapping[str, float], power: float, radius_m: float) -> ResetHeuristic:
    """The weighted mixture of normalised heuristics, to the power p.

    A heuristic that is zero everywhere (no goal is left) drops out; if all do, every point counts alike.
    Raises KeyError for a name that is not in HEURISTICS.
    """
    parts = [(weight, HEURISTICS[name](radius_m)) for name, weight in weights.items() if weight > 0]

    def eta(visits: Ints, goal_distance: Floats) -> Floats:
        total = np.zeros(len(visits))
        for weight, heuristic in parts:
            value = heuristic(visits, goal_distance)
            norm = value.sum()
            if norm > 0:
                total += weight * value / norm
        return total**power if total.any() else np.ones(len(visits))

    return eta
