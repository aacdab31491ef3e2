"""What a run shows of its nav-mesh, worked out once for the findings, the verdict and the report.

Shape legend: F faces, I islands, G goals, P cached points.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from reachtest.navmesh.coverage import GoalIslands, goal_islands, stood_on
from reachtest.navmesh.explained import explained_goals, without_visited
from reachtest.navmesh.islands import Islands
from reachtest.navmesh.promises import Promises, check_promises
from reachtest.records import Bools, Exploration, Floats, Level


@dataclass(frozen=True)
class Survey:
    """The nav-mesh of one level after one exploration."""

    level: Level
    exploration: Exploration
    known: Islands | None = None  # of the level's nav-mesh, where they were worked out before

    @cached_property
    def stood(self) -> Floats:
        """Where somebody stood [n, 3]: the spawns, and what of the cached points was on the ground."""
        points = self.exploration.points
        return np.concatenate([self._spawns, points.positions[points.grounded]])

    @cached_property
    def islands(self) -> GoalIslands:
        """The islands, and which goals are on which."""
        return goal_islands(self.known or Islands(self.level.navmesh), self._spawns, self.exploration.goals)

    @cached_property
    def visited(self) -> Bools:
        """The islands [I] that somebody stood on, or came near a goal of."""
        islands = self.islands
        result = stood_on(self.level.navmesh, islands.labels, self.stood)
        near = islands.goal_island[self.exploration.goal_step >= 0]
        result[near[near >= 0]] = True
        return result

    @cached_property
    def promises(self) -> Promises:
        """What the nav-mesh promises in vain; what somebody did all the same is possible."""
        level = self.level
        found = check_promises(level.navmesh, self.islands.labels, level.collision, level.character)
        return without_visited(found, self.stood, level.character.radius_m)

    @cached_property
    def explained(self) -> Bools:
        """The unreached goals [G] that `promises` explain: on impossible places, or behind them."""
        who, exploration = self.level.character, self.exploration
        result = exploration.goal_step < 0
        result &= self.islands.goals_count
        jump_m = max(who.jump_speed_mps**2 / (2 * who.gravity_mps2), who.step_height_m)
        missing = exploration.goals[result]
        result[result] = explained_goals(
            self.promises, self.stood, missing, exploration.settings.goal_radius_m, jump_m
        )
        return result

    @cached_property
    def counts(self) -> Bools:
        """The goals [G] that a pass needs: on connected islands, and not explained by a mismatch."""
        return self.islands.goals_count & ~self.explained

    @property
    def _spawns(self) -> Floats:
        return np.array([spawn.position for spawn in self.level.spawns]).reshape(-1, 3)
