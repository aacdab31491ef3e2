"""The primitive `heightmap`: a terrain from a grey PNG or a NumPy array."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
from pydantic import Field, model_validator

from reachtest.levels.fields import FARTHEST, Length, Name, Point, Spec
from reachtest.levels.meshes.scene import Unreadable
from reachtest.levels.shapes.grids import too_large
from reachtest.records import Floats, Frame, HeightField

_WHITE = {"L": 255, "I;16": 65_535, "I": 65_535}  # by Pillow's mode; older ones call 16 bits "I"
_PIXELS = {"1": "black and white", "LA": "grey with alpha", "P": "palette colours"}


class Heightmap(Spec):
    """A terrain sampled on a grid."""

    file: Name = Field(description="Grey PNG of 8 or 16 bits, or NPY of 2 dimensions, relative to this file.")
    size_m: tuple[Length, Length] = Field(
        description="Length along x and y between the outermost samples [m], level axes: z up."
    )
    height_m: Length | None = Field(
        None,
        description="PNG: height of full white above black [m]. NPY: factor on its numbers [m]. Default: 1.",
    )
    position: Point = Field(
        description="Where height 0 is at the lowest x and y of the level, in the frame's axes and units."
    )

    @model_validator(mode="after")
    def _png_has_a_height(self) -> Heightmap:
        if self.height_m is None and Path(self.file).suffix.lower() == ".png":
            raise ValueError("a PNG needs height_m, the height of full white [m]")
        return self


def build_heightmap(spec: Heightmap, frame: Frame, data: bytes) -> HeightField:
    """The grid of the surface, along the level's x and y; the first row of `data` lies at +y of the level.

    The frame's axes and units are those of `position` alone: no height map is ever turned. It is open: no walls at
    its borders and nothing underneath. A NaN, a wrong kind of pixel or a grid that is too large raises Unreadable,
    the last before any memory is taken for it.
    """
    shares = _read_png(data) if Path(spec.file).suffix.lower() == ".png" else _read_npy(data)
    with np.errstate(over="ignore"):
        heights = shares * (spec.height_m or 1.0)
    bad = ~(np.abs(heights) <= FARTHEST)  # also NaN
    if bad.any():
        row, column = np.argwhere(bad)[0].tolist()
        found = f"has {bad.sum()} heights that are NaN, infinite or beyond {FARTHEST:g} m"
        first = f"the first at row {row}, column {column}: {heights[row, column]:g} m"
        raise Unreadable(f"{found}, {first}", "fill the gaps and check height_m")
    x, y, z = frame.to_level(np.array(spec.position))
    low = np.array([x, y])
    return HeightField(low, low + spec.size_m, heights[::-1] + z)


def _read_png(data: bytes) -> Floats:
    """Share of full white [R, C]."""
    # Not Image.open: its guard against large pictures comes before ours, with less of a remedy.
    from PIL.PngImagePlugin import PngImageFile

    with PngImageFile(io.BytesIO(data)) as image:
        if image.mode not in _WHITE:
            pixels = _PIXELS.get(image.mode, f"{image.mode} pixels")
            raise Unreadable(f"holds {pixels}", "save it as grey with 8 or 16 bits, without alpha")
        if problem := too_large(image.height, image.width):
            raise Unreadable(*problem)
        shares: Floats = np.asarray(image, dtype=np.float64) / _WHITE[image.mode]
        return shares


def _read_npy(data: bytes) -> Floats:
    """The numbers [R, C] of a NumPy array."""
    stream = io.BytesIO(data)
    if np.lib.format.read_magic(stream) == (1, 0):
        shape, _, dtype = np.lib.format.read_array_header_1_0(stream)
    else:  # written only for headers above 64 KiB or with names, and so not for a plain array
        raise Unreadable("is an NPY file of a version other than 1.0", "save a plain array with numpy.save")
    if dtype.kind not in "iuf" or len(shape) != 2:
        found = f"holds {len(shape)} dimensions of {dtype}"
        raise Unreadable(found, "save a 2-dimensional array of numbers, rows along y")
    if problem := too_large(*shape):
        raise Unreadable(*problem)
    return np.asarray(np.load(io.BytesIO(data), allow_pickle=False), dtype=np.float64)
