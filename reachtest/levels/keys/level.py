"""`level.yaml`, version 1, as pydantic models: every key with its meaning, unit and limits."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Literal

from pydantic import (
    Field,
    GetJsonSchemaHandler,
    ValidationInfo,
    field_validator,
    model_validator,
)
from pydantic_core import CoreSchema

from reachtest.levels.fields import Name, Number, OneOf, Point, Spec, either
from reachtest.levels.keys.character import CharacterSpec
from reachtest.levels.keys.geometry import FrameSpec, GeometrySpec
from reachtest.levels.keys.navmesh import NavMeshSpec
from reachtest.levels.keys.settings import ExploreSpec, GateSpec
from reachtest.levels.shapes.primitives import AlignedBox

ZoneKind = Annotated[str, OneOf(("forbidden", "allowed_off_mesh"))]


class SpawnSpec(Spec):
    """Where the player starts."""

    short: ClassVar[str] = "its position: [x, y, z]"
    name: Name | None = Field(None, description="What reports call the spawn.")
    position: Point = Field(description="Position of the feet, in the frame's axes and units.")

    @model_validator(mode="before")
    @classmethod
    def _bare(cls, value: Any) -> Any:
        return {"position": value} if isinstance(value, (list, tuple)) else value

    @classmethod
    def __get_pydantic_json_schema__(
        cls, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        numbers = {"type": "array", "items": {"type": "number"}, "minItems": 3, "maxItems": 3}
        return either(numbers, schema, handler)


class BoundsSpec(Spec):
    """Outside of this box the character has left the world. Level axes: z up, metres."""

    low: Point = Field(description="Lowest corner [m].")
    high: Point = Field(description="Highest corner [m].")

    @model_validator(mode="after")
    def _ordered(self) -> BoundsSpec:
        if not all(low < high for low, high in zip(self.low, self.high, strict=True)):
            raise ValueError("low must be below high in x, y and z")
        return self


class ZoneSpec(Spec):
    """A box with a meaning."""

    name: Name = Field(description="What reports call the zone.")
    kind: ZoneKind = Field(
        description="forbidden: getting in is a finding; allowed_off_mesh: leaving the nav-mesh here is none."
    )
    box: AlignedBox = Field(description="The zone's box.")


class RequiredSpec(Spec):
    """A place that must be reached."""

    name: Name = Field(description="What reports call the place.")
    position: Point = Field(description="Position, in the frame's axes and units.")
    within_m: float = Field(1.0, gt=0, le=1000, description="How near counts as reached [m].")


class LevelSpec(Spec):
    """A level and how to test it."""

    version: Literal[1] = Field(description="Version of this format: 1.")
    name: str | None = Field(
        None,
        min_length=1,
        max_length=100,
        pattern=r"^\.*[^/\\\x00.][^/\\\x00]*$",  # a folder gets this name: not the one above
        description="Default: the folder's name.",
    )
    frame: FrameSpec = Field(
        default_factory=lambda: FrameSpec.model_validate({}),
        description="Axes and units of every position in this file.",
    )
    geometry: tuple[GeometrySpec, ...] = Field(min_length=1, description="What the level is made of.")
    navmesh: NavMeshSpec = Field(description="Where the game thinks the character can walk.")
    character: CharacterSpec = Field(description="Who explores: a preset's name, or numbers.")
    spawns: tuple[SpawnSpec, ...] = Field(min_length=1, description="Where the player starts.")
    kill_z_m: Number | None = Field(
        None, description="Below this level z [m] the character fell out. Default: 10 m below the geometry."
    )
    bounds_m: BoundsSpec | None = Field(None, description="Default: the geometry's box grown by 50 m.")
    zones: tuple[ZoneSpec, ...] = Field((), description="Boxes with a meaning.")
    required: tuple[RequiredSpec, ...] = Field((), description="Places that must be reached.")
    explore: ExploreSpec = Field(
        default_factory=lambda: ExploreSpec.model_validate({}), description="How to explore."
    )
    gate: GateSpec = Field(
        default_factory=lambda: GateSpec.model_validate({}),
        validate_default=True,
        description="What fails the run.",
    )

    @field_validator("gate")
    @classmethod
    def _has_a_limit_to_stop_at(cls, value: GateSpec, info: ValidationInfo) -> GateSpec:
        explore = info.data.get("explore")  # absent where it is wrong itself
        if explore is not None and explore.stop_when_done and value.max_discovery_probability is None:
            raise ValueError("explore.stop_when_done needs a max_discovery_probability to stop at")
        return value


def json_schema() -> dict[str, Any]:
    """JSON schema of `level.yaml` version 1, for editors."""
    schema = LevelSpec.model_json_schema(by_alias=True)
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        **schema,
        "title": "reachtest level.yaml",
    }
