"""Axes and units: from what a file states to level coordinates (metres, z up, right-handed)."""

from __future__ import annotations

import numpy as np

from reachtest.records import Frame

UNITS: dict[str, float] = {"m": 1.0, "cm": 0.01, "mm": 0.001, "in": 0.0254, "ft": 0.3048}
"""Length of one unit [m], by name."""

UP_AXES: dict[str, tuple[tuple[float, ...], ...]] = {
    "z": ((1, 0, 0), (0, 1, 0), (0, 0, 1)),
    "y": ((1, 0, 0), (0, 0, -1), (0, 1, 0)),  # (x, y, z) -> (x, -z, y), a rotation
}
"""Rotation to z up [3, 3], by the axis that points up."""


def unit_m(units: str | float) -> float:
    """Length of one unit [m] of a unit's name or of a number of metres."""
    return UNITS[units] if isinstance(units, str) else float(units)


def unit_name(length_m: float) -> str:
    """What to write after `units:` for a unit of this length [m]."""
    for name, length in UNITS.items():
        if abs(length_m / length - 1) < 1e-6:
            return name
    return f"{length_m:g}"


def make_frame(up_axis: str, units: str | float, scale: float = 1.0, flip_x: bool = False) -> Frame:
    """The frame of a file with this up axis and these units, its numbers multiplied by `scale`.

    `flip_x` mirrors x first: for exports from left-handed tools.
    """
    matrix = np.array(UP_AXES[up_axis], dtype=np.float64) * (unit_m(units) * scale)
    if flip_x:
        matrix = matrix @ np.diag([-1.0, 1.0, 1.0])
    return Frame(matrix, up_axis, units if isinstance(units, str) else f"{units:g} m")
