"""What is known of the risk that remains: how likely one more episode finds something new."""

from __future__ import annotations

import math
from dataclasses import dataclass

# At or below it one more episode hardly finds a new place, so that what was not seen is hardly there.
SATURATED_RISK = 0.05


@dataclass(frozen=True)
class RiskSample:
    """What a run knew of the risk that remains at one moment; the unit of sampling is one episode."""

    agent_steps: int
    episodes: int  # t
    discovering: int  # of the episodes: found a cell that none before them had been to
    cells_once: int  # Q1: cells visited by exactly one episode
    cells_twice: int  # Q2
    cells_total: int
    recent_episodes: int  # the latest ones
    recent_discovering: int  # likewise, of those
    goals_reached: int
    points: int  # cached

    @property
    def discovery_probability(self) -> float:
        """Bound on the probability that the next episode finds a new cell: min(1, Q1 / t).

        Good-Turing for incidence data (Boehme, STADS, TOSEM 2018); an estimate, since sampling is adaptive.
        """
        return min(1.0, self.cells_once / max(self.episodes, 1))

    @property
    def estimated_cells_total(self) -> float:
        """Lower bound on the cells that exist: Chao2, with the episode as the unit of sampling."""
        once, twice, episodes = self.cells_once, self.cells_twice, max(self.episodes, 1)
        unseen = once**2 / (2 * twice) if twice else once * (once - 1) / 2
        return self.cells_total + (episodes - 1) / episodes * unseen

    @property
    def ten_times_longer(self) -> tuple[float, float]:
        """Between what numbers the cells lie that are likely to be seen after ten times the episodes.

        One is Chao2, usually the lower. The other takes Q1 to stay what it is, though it falls once most is seen:
        then episode u finds Q1 / u new cells, which adds up to Q1 ln 10; with two standard deviations of a count.
        """
        once = self.cells_once + 2 * math.sqrt(self.cells_once)
        steady = self.cells_total + once * math.log(10)
        return min(self.estimated_cells_total, steady), max(self.estimated_cells_total, steady)

    @property
    def recent_share(self) -> float | None:
        """Share of the latest episodes that found a new cell; None before the first."""
        return self.recent_discovering / self.recent_episodes if self.recent_episodes else None

    @property
    def risk(self) -> float:
        """What the gate goes by: the bound, or what the latest episodes did find where that is more.

        Go-Explore goes back to where few have been, so that Q1 is used up faster than by random sampling.
        """
        return max(self.discovery_probability, self.recent_share or 0.0)
