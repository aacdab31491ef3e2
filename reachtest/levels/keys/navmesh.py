"""The key `navmesh` of `level.yaml`: the game's nav-mesh, or how to build one."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from reachtest.levels.fields import Name, OneOf, Spec, optional_number
from reachtest.levels.keys.geometry import MeshSpec
from reachtest.levels.navmeshes.formats import AUTO, NAVMESH_FORMATS

NavMeshFormat = Annotated[str, OneOf((AUTO, *NAVMESH_FORMATS))]


class BuildSpec(Spec):
    """How to build a nav-mesh; by default for the level's own character."""

    cell_m: float | None = optional_number(
        "Width of a voxel [m]. Default: half the radius; a third is finer.", above=0, most=10
    )
    cell_height_m: float | None = optional_number(
        "Height of a voxel [m]. Default: about half its width, so that the climb is whole voxels.",
        above=0,
        most=10,
    )
    radius_m: float | None = optional_number(
        "How far to stay off walls and edges [m]. Default: the character's radius.", least=0, most=100
    )
    height_m: float | None = optional_number(
        "Head room [m]. Default: the character's height.", above=0, most=1000
    )
    climb_m: float | None = optional_number("Highest step [m]. Default: the character's.", least=0, most=100)
    slope_deg: float | None = optional_number(
        "Steepest slope [deg]. Default: the character's.", above=0, most=89
    )
    min_island_m2: float | None = optional_number(
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
