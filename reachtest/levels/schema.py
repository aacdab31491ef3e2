"""`level.yaml`, version 1, as pydantic models: every key with its meaning, unit and limits."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import (
    Field,
    GetJsonSchemaHandler,
    ValidationInfo,
    create_model,
    field_validator,
    model_validator,
)
from pydantic_core import CoreSchema

from reachtest.levels.fields import Name, Number, OneOf, Point, Spec, Units
from reachtest.levels.frames import UP_AXES
from reachtest.levels.navmesh_formats import AUTO, NAVMESH_FORMATS
from reachtest.levels.presets import DEFAULTS, PRESETS
from reachtest.levels.primitives import PRIMITIVES, AlignedBox
from reachtest.levels.schema_settings import ExploreSpec, GateSpec
from reachtest.records import Character

UpAxis = Annotated[str, OneOf(UP_AXES)]
PresetName = Annotated[str, OneOf(PRESETS)]
NavMeshFormat = Annotated[str, OneOf((AUTO, *NAVMESH_FORMATS))]
ZoneKind = Annotated[str, OneOf(("forbidden", "allowed_off_mesh"))]


def _either(shorthand: dict[str, Any], schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
    return {"anyOf": [shorthand, handler(schema)]}


class FrameSpec(Spec):
    """Axes and units of every position in this file; the default for its meshes."""

    up_axis: UpAxis = Field("z", description="The axis that points up: y or z. Right-handed.")
    units: Units = Field("m", description="m, cm, mm, in, ft, or the length of one unit in metres.")


class MeshSpec(Spec):
    """A mesh file and how to read its numbers."""

    mesh: Name | None = Field(None, description="Mesh file, relative to this file.")
    up_axis: UpAxis | None = Field(
        None,
        description=(
            "The axis that points up in the mesh. Default: y for glTF and Detour, z for MJCF, else the frame's."
        ),
    )
    units: Units | None = Field(None, description="Units of the mesh. Default: m for MJCF, else the frame's.")
    scale: float = Field(1.0, gt=0, le=1e6, description="Factor on the mesh's numbers.")
    flip_x: bool = Field(False, description="Mirror x: for meshes from left-handed exporters.")
    nodes: tuple[Name, ...] | None = Field(
        None, min_length=1, description="Names of the scene nodes to use, with * and ?. Default: all."
    )


class GeometryBase(MeshSpec):
    """One piece of the level: a mesh file or one primitive."""

    name: Name | None = Field(None, description="What reports call the place.")
    role: Literal["collision", "solid", "both"] = Field(
        "collision",
        description="collision: stops the character; solid: a closed volume nobody may get into; both.",
    )

    @property
    def shape(self) -> str:
        """`mesh` or the kind of primitive."""
        return next(kind for kind in ("mesh", *PRIMITIVES) if getattr(self, kind) is not None)

    @model_validator(mode="after")
    def _one_shape(self) -> GeometryBase:
        kinds = ("mesh", *PRIMITIVES)
        given = [kind for kind in kinds if getattr(self, kind) is not None]
        if len(given) != 1:
            raise ValueError(f"must have exactly one of {', '.join(kinds)}; has {', '.join(given) or 'none'}")
        if (
            extra := (self.model_fields_set & MeshSpec.model_fields.keys()) - {"mesh"}
            if given != ["mesh"]
            else None
        ):
            raise ValueError(f"{', '.join(sorted(extra))} can only go with 'mesh'; {given[0]} uses the frame")
        return self


if TYPE_CHECKING:
    GeometrySpec = GeometryBase
else:
    GeometrySpec = create_model(
        "GeometrySpec",
        __base__=GeometryBase,
        __doc__=GeometryBase.__doc__,
        **{
            kind: (primitive.spec | None, Field(None, description=primitive.description))
            for kind, primitive in PRIMITIVES.items()
        },
    )


def _number(text: str, *, above: float | None = None, least: float | None = None, most: float) -> Any:
    return Field(None, gt=above, ge=least, le=most, description=text)


class BuildSpec(Spec):
    """How to build a nav-mesh; by default for the level's own character."""

    cell_m: float | None = _number(
        "Width of a voxel [m]. Default: half the radius; a third is finer.", above=0, most=10
    )
    cell_height_m: float | None = _number(
        "Height of a voxel [m]. Default: about half its width, so that the climb is whole voxels.",
        above=0,
        most=10,
    )
    radius_m: float | None = _number(
        "How far to stay off walls and edges [m]. Default: the character's radius.", least=0, most=100
    )
    height_m: float | None = _number("Head room [m]. Default: the character's height.", above=0, most=1000)
    climb_m: float | None = _number("Highest step [m]. Default: the character's.", least=0, most=100)
    slope_deg: float | None = _number("Steepest slope [deg]. Default: the character's.", above=0, most=89)
    min_island_m2: float | None = _number(
        "Smaller islands are left out [m2]. Default: 64 voxels.", least=0, most=1e6
    )
    faces: Literal["up", "any"] = Field(
        "up", description="Which faces can be floors: those that face up, or, in levels inside out, any."
    )


class NavMeshSpec(MeshSpec):
    """The game's navigation mesh: its file, or how to build one."""

    mesh: Name | None = Field(None, description="Nav-mesh file, relative to this file.")
    format: NavMeshFormat = Field(AUTO, description="Format of the file; auto: what its content says.")
    build: BuildSpec | None = Field(
        None, description="Build it from the geometry instead; {} takes the character's numbers."
    )

    @model_validator(mode="after")
    def _one_source(self) -> NavMeshSpec:
        given = [key for key in ("mesh", "build") if getattr(self, key) is not None]
        if len(given) != 1:
            raise ValueError(f"must have exactly one of mesh, build; has {' and '.join(given) or 'none'}")
        extra = sorted(self.model_fields_set - {"mesh", "build"})
        if extra and given == ["build"]:
            raise ValueError(f"{', '.join(extra)} can only go with 'mesh'")
        return self


class CharacterSpec(Spec):
    """The capsule and its movement rules: a preset, single numbers over a preset, or all numbers."""

    preset: PresetName | None = Field(None, description="Start from an engine's defaults.")
    radius_m: float | None = _number("Radius of the capsule [m].", above=0, most=100)
    height_m: float | None = _number("Full height of the capsule [m].", above=0, most=1000)
    walk_speed_mps: float | None = _number("Fastest speed on the ground [m/s].", above=0, most=100)
    jump_speed_mps: float | None = _number("Upward speed of a jump [m/s]; 0: no jump.", least=0, most=100)
    step_height_m: float | None = _number("Highest step walked up [m].", least=0, most=100)
    slope_limit_deg: float | None = _number("Steepest slope walked up [deg].", above=0, most=89)
    gravity_mps2: float | None = _number("Gravity [m/s2], downwards.", above=0, most=1000)
    terminal_speed_mps: float | None = _number("Fastest fall [m/s].", above=0, most=1000)
    acceleration_mps2: float | None = _number("Acceleration on the ground [m/s2].", above=0, most=10_000)
    braking_mps2: float | None = _number("Deceleration without input [m/s2].", above=0, most=10_000)
    ground_friction: float | None = _number(
        "How fast the velocity turns to the input [1/s].", least=0, most=1000
    )
    air_control: float | None = _number("Share of the acceleration available in the air.", least=0, most=1)

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
        return _either({"type": "string", "enum": list(PRESETS)}, schema, handler)


class SpawnSpec(Spec):
    """Where the player starts."""

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
        return _either(numbers, schema, handler)


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
