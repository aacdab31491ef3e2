"""The key `character` of `level.yaml`: who explores."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar

from pydantic import Field, GetJsonSchemaHandler, model_validator
from pydantic_core import CoreSchema

from reachtest.levels.fields import OneOf, Spec, either, optional_number
from reachtest.levels.keys.presets import DEFAULTS, PRESETS
from reachtest.records import Character

PresetName = Annotated[str, OneOf(PRESETS)]


class CharacterSpec(Spec):
    """The capsule and its movement rules: a preset, single numbers over a preset, or all numbers."""

    short: ClassVar[str] = "a preset's name"
    preset: PresetName | None = Field(None, description="Start from an engine's defaults.")
    radius_m: float | None = optional_number("Radius of the capsule [m].", above=0, most=100)
    height_m: float | None = optional_number("Full height of the capsule [m].", above=0, most=1000)
    walk_speed_mps: float | None = optional_number("Fastest speed on the ground [m/s].", above=0, most=100)
    jump_speed_mps: float | None = optional_number(
        "Upward speed of a jump [m/s]; 0: no jump.", least=0, most=100
    )
    step_height_m: float | None = optional_number("Highest step walked up [m].", least=0, most=100)
    slope_limit_deg: float | None = optional_number("Steepest slope walked up [deg].", above=0, most=89)
    gravity_mps2: float | None = optional_number("Gravity [m/s2], downwards.", above=0, most=1000)
    terminal_speed_mps: float | None = optional_number("Fastest fall [m/s].", above=0, most=1000)
    acceleration_mps2: float | None = optional_number(
        "Acceleration on the ground [m/s2].", above=0, most=10_000
    )
    braking_mps2: float | None = optional_number("Deceleration without input [m/s2].", above=0, most=10_000)
    ground_friction: float | None = optional_number(
        "How fast the velocity turns to the input [1/s].", least=0, most=1000
    )
    air_control: float | None = optional_number(
        "Share of the acceleration available in the air.", least=0, most=1
    )

    @model_validator(mode="before")
    @classmethod
    def _by_name(cls, value: Any) -> Any:
        return {"preset": value} if isinstance(value, str) else value

    @model_validator(mode="after")
    def _complete(self) -> CharacterSpec:
        numbers = self._numbers()
        if missing := [key for key in Character.__dataclass_fields__ if key not in numbers]:
            raise ValueError(f"without a preset it must also have {', '.join(missing)}")
        if numbers["height_m"] < 2 * numbers["radius_m"]:
            raise ValueError("a capsule's height_m must be at least twice its radius_m")
        return self

    def _numbers(self) -> dict[str, float]:
        base = vars(PRESETS[self.preset]) if self.preset else DEFAULTS
        return {**base, **self.model_dump(exclude={"preset"}, exclude_none=True)}

    def character(self) -> Character:
        """The character these numbers describe."""
        return Character(**self._numbers())

    @classmethod
    def __get_pydantic_json_schema__(
        cls, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        return either({"type": "string", "enum": list(PRESETS)}, schema, handler)
