"""Ways to misread a nav-mesh: units, axes, a mirror; and what to write to put each of them right."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np

from reachtest.levels.frames import UP_AXES, unit_name
from reachtest.levels.reading import ReadLevel
from reachtest.records import Floats, Level

UNIT_SLIPS = (0.01, 100.0, 0.0254, 1 / 0.0254, 0.3048, 1 / 0.3048)
EXCHANGE_SIGN = "export (x, y, z) as (x, z, -y), or as (x, -z, y)"
_UNIT_WORDS = {"m": "metres", "cm": "centimetres", "mm": "millimetres", "in": "inches", "ft": "feet"}


@dataclass(frozen=True)
class Slip:
    """One way to misread a mesh: what turns its level coordinates right, what it is, and what to write."""

    matrix: Floats  # [3, 3]
    words: tuple[str, ...] = ()
    keys: tuple[str, ...] = ()
    export: tuple[str, ...] = ()  # what no key can put right

    @property
    def cost(self) -> int:
        """How much is wrong at once."""
        return len(self.keys) + len(self.export)

    @property
    def remedy(self) -> str:
        """What it looks like, and what to do."""
        ways = [f"write {' and '.join(self.keys)}"] if self.keys else []
        return f"it looks like {' and '.join(self.words)}: {', and '.join([*ways, *self.export])}"

    @property
    def keeps_size(self) -> bool:
        """Whether no unit is mistaken."""
        return bool(np.isclose(abs(np.linalg.det(self.matrix)), 1.0))

    def then(self, other: Slip) -> Slip:
        """Both at once."""
        words, keys = self.words + other.words, self.keys + other.keys
        return Slip(other.matrix @ self.matrix, words, keys, self.export + other.export)


def slips(level: Level) -> list[Slip]:
    """Ways to misread the nav-mesh, the simple ones first."""
    reading = level.reading if isinstance(level, ReadLevel) else None
    frame, scale = (reading.navmesh_frame, reading.navmesh_scale) if reading else (level.frame, 1.0)
    none = Slip(np.eye(3))
    other = "z" if frame.up_axis == "y" else "y"
    upright = np.array(UP_AXES["y"], dtype=np.float64)
    turned = Slip(upright if other == "y" else upright.T, (f"{other} up",), (f"navmesh.up_axis: {other}",))
    flip = str(np.linalg.det(frame.matrix) > 0).lower()
    mirrored = Slip(np.diag([-1.0, 1.0, 1.0]), ("mirrored x",), (f"navmesh.flip_x: {flip}",))
    scaled = [_scaled(frame.unit_m, factor, scale) for factor in UNIT_SLIPS]
    swap, own = np.eye(3)[[0, 2, 1]], np.array(UP_AXES[frame.up_axis], dtype=np.float64)
    exchanged = [
        Slip(matrix, ("y and z exchanged without a change of sign",), (), (EXCHANGE_SIGN,))
        for matrix in (own @ swap @ own.T, swap @ own.T)  # of a file with this up axis, and of one with z up
    ]
    every = product([none, *scaled], [none, turned, *exchanged], [none, mirrored])
    ways = [unit.then(turn).then(mirror) for unit, turn, mirror in every]
    return sorted((slip for slip in ways if slip.words), key=lambda slip: slip.cost)


def _scaled(now_m: float, factor: float, scale: float) -> Slip:
    unit = unit_name(now_m * factor)
    keys = (f"navmesh.units: {unit}",) + (("navmesh.scale: 1",) if scale != 1 else ())
    words = f"{_UNIT_WORDS.get(unit, f'units of {unit} m')} (scale {factor:.4g})"
    return Slip(np.eye(3) * factor, (words,), keys)
