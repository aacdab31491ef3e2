"""Reset heuristics: which cached point is worth restarting from.

To add one: write the function and name it in HEURISTICS. Level files name them with weights.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from reachtest.errors import BadInput, Problem
from reachtest.interfaces import ResetHeuristic
from reachtest.records import Candidates, Floats, Level

NEAREST_M = 0.5  # a goal's last metre is no reason to restart from one point for ever


def visits(candidates: Candidates) -> Floats:
    """1 / n(s): seldom visited places first (paper, "Visitation-Based")."""
    return 1.0 / np.maximum(candidates.visits, 1)


def goals(candidates: Candidates) -> Floats:
    """1 / d(S_nav-mesh, s): near goals that are still open (paper, "Nav-Mesh Goal Guided")."""
    return 1.0 / np.maximum(candidates.goal_distance, NEAREST_M)


def frontier(candidates: Candidates) -> Floats:
    """1 / (n(s) d): seldom visited places near goals that are still open.

    The ground beneath an unreached platform is near it but visited often; the ramp up is not.
    """
    return visits(candidates) * goals(candidates)


def off_mesh(candidates: Candidates) -> Floats:
    """1 / n(s), the more the farther from the nav-mesh: bugs are sought, and getting off it is how they begin.

    Full weight where the nav-mesh is out of reach, none on it.
    """
    away = np.minimum(candidates.off_mesh_m / candidates.expected_within_m, 1.0)
    return away * visits(candidates)


def uniform(candidates: Candidates) -> Floats:
    """Every cached point alike: the paper's ablation."""
    return np.ones(len(candidates.visits))


HEURISTICS: dict[str, ResetHeuristic] = {
    "visits": visits,
    "goals": goals,
    "frontier": frontier,
    "off_mesh": off_mesh,
    "uniform": uniform,
}


def check_heuristics(level: Level, config: Path | None = None) -> None:
    """That every heuristic which the level, under a configuration, names is one. Raises BadInput."""
    files = " under ".join(file.name for file in (level.file, config) if file)
    where, remedy = f"{files}: explore.heuristics", f"known heuristics are {', '.join(HEURISTICS)}"
    unknown = sorted(set(level.explore.heuristics) - set(HEURISTICS))
    if unknown:
        raise BadInput([Problem(where, f"'{name}' is no reset heuristic", remedy) for name in unknown])


def mixture(weights: Mapping[str, float], power: float) -> ResetHeuristic:
    """Each heuristic to the power p, normalised, and mixed: a weight is a share of the restarts.

    A heuristic without an opinion (no goal is left) leaves its share to the others; if none has one, every
    point counts alike. Raises KeyError for a name that is not in HEURISTICS.
    """
    parts = [(weight, HEURISTICS[name]) for name, weight in weights.items() if weight > 0]

    def eta(candidates: Candidates) -> Floats:
        total = np.zeros(len(candidates.visits))
        for weight, heuristic in parts:
            value = heuristic(candidates) ** power
            norm = value.sum()
            if norm > 0:
                total += weight * value / norm
        return total if total.any() else np.ones(len(total))

    return eta
