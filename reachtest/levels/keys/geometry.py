"""The keys `frame` and `geometry` of `level.yaml`: axes, mesh files and shapes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import Field, create_model, model_validator

from reachtest.levels.fields import Name, OneOf, Spec, Units
from reachtest.levels.frames import UP_AXES
from reachtest.levels.shapes.primitives import PRIMITIVES

UpAxis = Annotated[str, OneOf(UP_AXES)]


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
