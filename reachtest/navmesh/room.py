"""Where a character could stand: the floor at a place, how steep it is, the head room and the width above it.

Shape legend: F triangles, n places.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from reachtest.columns import ColumnIndex, Columns
from reachtest.geometry import point_triangle_distance, triangle_normals
from reachtest.records import Bools, Character, Floats, Ints

FLOOR_UP_M = 0.3  # a nav-mesh may lie this much below the floor it stands for
SLOPE_SLACK_DEG = 1.0  # floors built at the limit are walkable, whatever float32 makes of them
OVERLAP_M = 0.02  # what a capsule may reach into a wall: rounding, and what a simulator pushes out
_LIFT_M = 0.005  # feet rest this much above their floor
_AXIS_SAMPLES = 7  # 0.18 m apart on a 1.76 m capsule: the distance is at most 1.2 cm off


@dataclass(frozen=True)
class Standing:
    """What was found at n places."""

    floor: Floats  # [n] z of the floor; NaN for none
    slope_deg: Floats  # [n]
    head_m: Floats  # [n] from the floor to the ceiling straight above; infinite beyond the character's height
    clear_m: Floats  # [n] from the capsule's axis to the nearest wall or ceiling; infinite beyond its radius
    fits: Bools  # [n] walkable floor, and room for the capsule on it
    buried: Bools  # [n] inside of something closed that stands there: a crate, a wall


class Room:
    """Room for one character in one level's collision geometry."""

    def __init__(self, collision: Floats, character: Character) -> None:
        """`collision` [F, 3, 3]."""
        self._triangles, self._who = collision, character
        self._normals = triangle_normals(collision)[0]
        self._floors = ColumnIndex(collision)
        mirrored = collision * [1.0, 1.0, -1.0]  # the highest there is the lowest here
        self._ceilings = ColumnIndex(mirrored[self._normals[:, 2] < 0])
        self._tops = ColumnIndex(mirrored[self._normals[:, 2] > 0])
        self._columns = Columns(collision, character.radius_m, 1.0)
        self._low, self._high = collision.min(axis=1), collision.max(axis=1)
        self.limit_deg = character.slope_limit_deg + SLOPE_SLACK_DEG
        self._flat = np.abs(self._normals[:, 2]) >= np.cos(np.radians(self.limit_deg))

    def floors(self, places: Floats, down_m: float) -> tuple[Floats, Floats]:
        """The highest floor [n] no lower than `down_m` below each place [n, 3], and its slope [n] [deg]."""
        floor, slope = self._floors.highest(places, down_m, FLOOR_UP_M)
        return floor, np.degrees(np.arccos(np.clip(slope, 0.0, 1.0)))

    def standing(self, places: Floats, down_m: float) -> Standing:
        """Stand the character at the (x, y) of `places` [n, 3], on the floor found there."""
        who = self._who
        floor, slope_deg = self.floors(places, down_m)
        known = np.isfinite(floor)
        walkable = known & (slope_deg <= self.limit_deg)
        feet = places.copy()
        hang = who.radius_m * (1 / np.cos(np.radians(np.minimum(slope_deg, 80.0))) - 1)
        feet[:, 2] = np.where(known, floor + hang + _LIFT_M, 0.0)
        above = np.where(known, floor, 0.0)
        head, top = (
            self._lowest(index, places, np.where(known, above, np.nan))
            for index in (self._ceilings, self._tops)
        )
        clear, behind = np.full(len(places), np.inf), np.zeros(len(places), dtype=np.bool_)
        ask = np.flatnonzero(walkable)
        clear[ask], behind[ask] = self._clearance(feet[ask])
        fits = walkable & (head >= who.height_m - OVERLAP_M) & (clear >= who.radius_m - OVERLAP_M)
        buried = behind | (top < head - _LIFT_M)
        return Standing(floor, slope_deg, head, clear, fits & ~buried, buried)

    def _lowest(self, mirrored: ColumnIndex, places: Floats, floor: Floats) -> Floats:
        """Height above the floor [n] of the lowest surface there; infinite beyond the character's height."""
        start = np.stack([places[:, 0], places[:, 1], -np.nan_to_num(floor)], axis=1)
        found, _ = mirrored.highest(start, self._who.height_m, -4 * _LIFT_M)
        return np.where(np.isfinite(found), -found - floor, np.inf)

    def _clearance(self, feet: Floats) -> tuple[Floats, Bools]:
        """Distance [n] of the capsules' axes to what is no floor underfoot [m]; infinite beyond the radius.

        As a simulator has it: steps up to the step height do not count, nor walkable floors near the feet.
        And whether the nearest of it is seen from behind [n].
        """
        who = self._who
        result, behind = np.full(len(feet), np.inf), np.zeros(len(feet), dtype=np.bool_)
        bottom, top = who.radius_m, who.height_m - who.radius_m
        lift = min(bottom + who.radius_m, top)
        heights = np.linspace(bottom, top, _AXIS_SAMPLES)
        for begin, end, row, member in self._columns.pairs(feet):
            some = feet[begin:end]
            row, member = self._beside(some, row, member)
            for height in heights:
                counts = np.flatnonzero(~self._flat[member] | (height >= lift))
                axis = some[row[counts]] + [0.0, 0.0, height]
                near = point_triangle_distance(axis, self._triangles[member[counts]])
                near[near > who.radius_m] = np.inf
                here, faces = begin + row[counts], member[counts]
                front = ((axis - self._triangles[faces, 0]) * self._normals[faces]).sum(axis=1) >= 0
                nearest = result.copy()
                np.minimum.at(nearest, here, near)
                # Of faces equally near, as at an edge, one that is seen from the front decides.
                behind[nearest < result] = True
                result = nearest
                behind[here[front & (near <= result[here] + 1e-9)]] = False
        return result, behind

    def _beside(self, feet: Floats, row: Ints, member: Ints) -> tuple[Ints, Ints]:
        """The pairs whose triangle comes into the box around the capsule, above what it steps over."""
        who, at = self._who, feet[row]
        reach = who.radius_m
        near = (self._high[member, 2] > at[:, 2] + who.step_height_m) & (
            self._low[member, 2] < at[:, 2] + who.height_m
        )
        for axis in (0, 1):
            near &= self._low[member, axis] < at[:, axis] + reach
            near &= self._high[member, axis] > at[:, axis] - reach
        return row[near], member[near]
