"""The keys `explore` and `gate` of `level.yaml`: how to explore, and what fails a run."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, field_validator, model_validator

from reachtest.levels.fields import Duration, Name, OneOf, Spec
from reachtest.records import KINDS, SEVERITIES, ExploreSettings

FAIL_ON = (
    "unexpected_area",
    "fell_out_of_world",
    "inside_solid",
    "forbidden_zone",
    "stuck",
    "required_unreached",
    "unreached_area",
)
_EXPLORE = ExploreSettings()
# A run of fewer steps needs its looks at the cache more than numpy needs long rows: 600,000 steps on the dungeon found
# its way out with 128 lanes in seeds where 256 did not.
LONG_RUN_STEPS, LONG_RUN_EPISODES = 1_000_000, 16
Gated = Annotated[str, OneOf((*KINDS, *SEVERITIES))]


class ExploreSpec(Spec):
    """How to explore."""

    agents: int = Field(_EXPLORE.agents, ge=1, le=4096, description="Characters simulated side by side.")
    steps: int = Field(_EXPLORE.steps, ge=1, le=10**11, description="Budget [agent steps], over all agents.")
    time_budget: Duration = Field(
        None, description="Budget of wall-clock time: 90, 90s, 30m, 2h. Default: none."
    )
    time_budget_s: float | None = Field(None, gt=0, le=30 * 86_400, description="The same [s].")
    # Steps of a round are kept as 16-bit numbers.
    episodes_at_once: int | None = Field(
        None,
        ge=1,
        le=64,
        description=(
            "Episodes of each agent between two looks at the cache; simulated side by side. Default: "
            f"{_EXPLORE.episodes_at_once}, and {LONG_RUN_EPISODES} from {LONG_RUN_STEPS:,} steps on."
        ),
    )
    reset_interval: int = Field(
        _EXPLORE.reset_interval, ge=1, le=32_767, description="Episode [agent steps]."
    )
    threshold_m: float = Field(
        _EXPLORE.threshold_m, gt=0, le=100, description="K: distance of cached points [m]."
    )
    physics_hz: float = Field(
        _EXPLORE.physics_hz, ge=10, le=10_000, description="Physics steps a second [Hz]."
    )
    action_repeat: int = Field(
        _EXPLORE.action_repeat, ge=1, le=1000, description="Physics steps an action is held."
    )
    heuristics: dict[str, float] = Field(
        _EXPLORE.heuristics, min_length=1, description="Weights >= 0 of the reset heuristics, by name."
    )
    power: float = Field(_EXPLORE.power, ge=0, le=100, description="Exponent on the priorities; 0: uniform.")
    goal_spacing_m: float = Field(
        _EXPLORE.goal_spacing_m, gt=0, le=1000, description="Distance of goals [m]."
    )
    goal_radius_m: float = Field(
        _EXPLORE.goal_radius_m, gt=0, le=1000, description="How near drains a goal [m]."
    )
    expected_within_m: float = Field(
        _EXPLORE.expected_within_m,
        gt=0,
        le=1000,
        description="Beyond this from the nav-mesh is unexpected [m].",
    )
    directed: float = Field(
        _EXPLORE.directed,
        ge=0,
        le=1,
        description="Share of the episodes that push towards open goals and over the nav-mesh's border; "
        "twice that once all goals are reached.",
    )
    effort: int = Field(
        _EXPLORE.effort,
        ge=0,
        le=1_000_000,
        description="Directed attempts from its border before a part of the nav-mesh counts as unreached.",
    )
    stop_when_done: bool = Field(
        _EXPLORE.stop_when_done,
        description=(
            "Stop before the budget's end once every goal that counts and every required point is reached and the "
            "risk is within gate.max_discovery_probability, which must be set."
        ),
    )

    @field_validator("heuristics")
    @classmethod
    def _weights(cls, value: dict[str, float]) -> dict[str, float]:
        if not all(0 <= weight <= 1e6 for weight in value.values()) or not sum(value.values()):
            raise ValueError("every weight must be between 0 and 1e6, and not all of them 0")
        return value

    @model_validator(mode="after")
    def _one_budget(self) -> ExploreSpec:
        if self.time_budget is not None and self.time_budget_s is not None:
            raise ValueError("give either time_budget or time_budget_s")
        return self

    def settings(self) -> ExploreSettings:
        """The settings these values mean."""
        values = self.model_dump(exclude={"time_budget", "time_budget_s", "episodes_at_once"})
        budget = self.time_budget if self.time_budget is not None else self.time_budget_s
        usual = LONG_RUN_EPISODES if self.steps >= LONG_RUN_STEPS else _EXPLORE.episodes_at_once
        return ExploreSettings(
            **values, time_budget_s=budget, episodes_at_once=self.episodes_at_once or usual
        )


class GateSpec(Spec):
    """What fails the run, and what a pass needs."""

    fail_on: tuple[Gated, ...] = Field(
        FAIL_ON,
        description=(
            "What fails the run: kinds of findings, 'error' for all errors, 'warning' for errors and warnings; "
            "[] for none."
        ),
    )
    min_goals_reached: float = Field(1.0, ge=0, le=1, description="Share of the goals a pass needs.")
    max_discovery_probability: float | None = Field(
        None,
        ge=0,
        le=1,
        description="A pass needs the probability of finding something new at or below this.",
    )
    baseline: Name | None = Field(
        None, description="File of known bugs, relative to this file; 'reachtest baseline update' writes it."
    )
