"""From a primitive in `level.yaml` to its triangles, with the file that it names."""

from __future__ import annotations

from pathlib import Path

from reachtest.errors import BadInput, Problem
from reachtest.levels.fields import Spec
from reachtest.levels.meshes.paths import file_problem
from reachtest.levels.meshes.scene import Unreadable
from reachtest.levels.shapes.grids import MOST_SAMPLES
from reachtest.levels.shapes.primitives import PRIMITIVES
from reachtest.records import Floats, Frame, HeightField

MOST_BYTES = 16 * MOST_SAMPLES + 2**20  # the widest numbers there are, and room for a header


def build_primitive(
    kind: str, spec: Spec, folder: Path, frame: Frame, where: str
) -> tuple[Floats | HeightField, bytes]:
    """Triangles [F, 3, 3] or grid of a primitive, and what its file holds (nothing without one). Raises BadInput."""
    primitive = PRIMITIVES[kind]
    if not primitive.files:
        try:
            return primitive.build(spec, frame), b""
        except ValueError as error:
            raise BadInput([Problem(f"{where}.{kind}", "has no extent", str(error))]) from error
    where = f"{where}.{kind}.file"
    name = str(spec.model_dump()["file"])
    if problem := file_problem(name, folder, primitive.files, kind):
        raise BadInput([Problem(where, *problem)])
    try:
        size = (folder / name).stat().st_size
        if size > MOST_BYTES:
            raise Unreadable(f"has {size:,} bytes", f"reduce it to {MOST_BYTES:,} bytes or cut it into tiles")
        data = (folder / name).read_bytes()
        return primitive.build(spec, frame, data), data
    except Unreadable as error:
        raise BadInput([Problem(where, f"{name} {error.found}", error.remedy)]) from error
    except Exception as error:  # readers of other people's formats raise anything
        found = f"{name} cannot be read: {type(error).__name__}: {error}".rstrip(": ")
        raise BadInput([Problem(where, found, "the file is damaged or cut off: export it again")]) from error
