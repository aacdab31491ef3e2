"""For whom a nav-mesh is built, and how finely."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from reachtest.navmesh.filters import VoxelAgent
from reachtest.records import Character

CELLS_PER_RADIUS = 2  # Recast's rule of thumb outdoors; indoors it is 3
LEAST_CLIMB = 0.125  # [cell widths] less is none: cells as low as that would be too many
ISLAND_CELLS = 64  # the Recast demo's minimum region size is 8 x 8 cells
WHOLE = 1e-6  # [cells] a measure of 6.0000001 cells is 6: rounding of decimal fractions


@dataclass(frozen=True)
class BuildSettings:
    """For whom to build, and how finely."""

    cell_m: float
    cell_height_m: float
    radius_m: float
    height_m: float
    climb_m: float
    slope_deg: float
    min_island_m2: float  # smaller islands are left out
    both_sides: bool = False  # floors may face down, too: for levels with faces turned inside out

    @property
    def agent(self) -> VoxelAgent:
        """The same in cells, rounded as rcConfig asks: height and radius up, climb down."""
        rise_m = self.cell_m * float(np.tan(np.radians(self.slope_deg)))
        # Over two cells, stairs no steeper than the slope limit have one step more than a slope would rise.
        stairs_m = 2 * rise_m + min(2 * rise_m, self.climb_m)
        spread_m = max(self.climb_m, stairs_m)
        return VoxelAgent(
            height=int(np.ceil(self.height_m / self.cell_height_m - WHOLE)),
            climb=int(np.floor(self.climb_m / self.cell_height_m + WHOLE)),
            radius=int(np.ceil(self.radius_m / self.cell_m - WHOLE)),
            rise=int(np.ceil(rise_m / self.cell_height_m - WHOLE)),
            spread=int(np.ceil(spread_m / self.cell_height_m - WHOLE)),
            rise_m=rise_m,
            rolls_m=self.radius_m * (1.0 - float(np.cos(np.radians(self.slope_deg)))),
        )


def settings_for(character: Character, *, both_sides: bool = False, **given: float | None) -> BuildSettings:
    """Settings with the character's own numbers where `given` has none.

    Cells are half a radius wide and half as high as wide, or a little less, so that the climb is whole cells:
    a step just as high as the climb is then climbed.
    """
    known = {name: value for name, value in given.items() if value is not None}
    radius, climb = known.get("radius_m", character.radius_m), known.get("climb_m", character.step_height_m)
    cell = known.get("cell_m", (radius or character.radius_m) / CELLS_PER_RADIUS)
    cell_height = climb / np.ceil(climb / (cell / 2)) if climb > cell * LEAST_CLIMB else cell / 2
    default = {
        "cell_m": cell,
        "cell_height_m": float(cell_height),
        "radius_m": radius,
        "height_m": character.height_m,
        "climb_m": climb,
        "slope_deg": character.slope_limit_deg,
        "min_island_m2": ISLAND_CELLS * cell**2,
    }
    return BuildSettings(**{**default, **known}, both_sides=both_sides)
