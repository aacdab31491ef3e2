"""How to explore, and what fails a run."""

from __future__ import annotations

from dataclasses import dataclass, field

# Of the directed lanes, to push over the border while goals are open: with half, these are reached later.
OUTWARDS = 0.25


@dataclass(frozen=True)
class ExploreSettings:
    """How to explore; defaults are the paper's where it states one."""

    agents: int = 16
    steps: int = 200_000  # [agent steps], over all agents
    time_budget_s: float | None = None
    reset_interval: int = (
        32  # [agent steps] an episode; the paper's 128 takes twice the steps: see the README
    )
    episodes_at_once: int = (
        8  # of each agent, between two looks at the cache: they are simulated side by side
    )
    threshold_m: float = 1.0  # K
    physics_hz: float = 30.0
    action_repeat: int = 4  # [physics steps an agent step]
    heuristics: dict[str, float] = field(
        default_factory=lambda: {"visits": 0.2, "goals": 0.2, "frontier": 0.4, "off_mesh": 0.2}
    )
    power: float = 2.0  # the paper's 1 leaves the last goals to chance: see the README
    goal_spacing_m: float = 4.0
    goal_radius_m: float = 1.0
    expected_within_m: float = 3.0
    directed: float = 0.25  # share of the lanes that push towards open goals and over the nav-mesh's border
    effort: int = 256  # directed attempts from its border before a part of the nav-mesh is called unreached
    stop_when_done: bool = False  # once everything is reached and `gate.max_discovery_probability` is met

    @property
    def directed_at_goals(self) -> float:
        """Share of the lanes that push towards open goals while there are some; the others push over the border."""
        return self.directed * (1.0 - OUTWARDS)

    @property
    def lanes(self) -> int:
        """Episodes simulated side by side: agent a has lanes a * episodes_at_once and following."""
        return self.agents * self.episodes_at_once


@dataclass(frozen=True)
class GateSettings:
    """What makes the run fail, and what a pass needs."""

    fail_on: tuple[str, ...]
    min_goals_reached: float = 1.0
    max_discovery_probability: float | None = None
    baseline: str | None = None  # file of known bugs, relative to level.yaml
