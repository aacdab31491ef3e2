"""Does the nav-mesh lie on the geometry? If not, which slip of units or axes would explain it?

Shape legend: N sample points.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np

from reachtest.errors import Problem
from reachtest.geometry import ColumnIndex, triangle_normals
from reachtest.levels.frames import UP_AXES, unit_name
from reachtest.levels.reading import ReadLevel
from reachtest.records import Floats, Frame, Level

SAMPLES = 1000  # the share is then known to within 0.03
FLOOR_WITHIN_M = 1.0  # quantisation and erosion move a nav-mesh by less than its climb height, 0.9 m at most
LEAST_SHARE = 0.5  # below it the nav-mesh is some other level's, or lies elsewhere
ODD_SHARE = 0.9
GOOD_SHARE = 0.7  # of a hypothesis that is worth naming
UNIT_SLIPS = (0.01, 100.0, 0.0254, 1 / 0.0254, 0.3048, 1 / 0.3048)
SIZES = (0.25, 1.5)  # of the nav-mesh in proportion to the level: a shrunken one lies on *some* floor too
_UNIT_WORDS = {"m": "metres", "cm": "centimetres", "mm": "millimetres", "in": "inches", "ft": "feet"}


@dataclass(frozen=True)
class _Slip:
    """One way to misread a mesh: what turns its level coordinates right, what it is, and what to write."""

    matrix: Floats  # [3, 3]
    words: tuple[str, ...] = ()
    keys: tuple[str, ...] = ()

    def then(self, other: _Slip) -> _Slip:
        return _Slip(other.matrix @ self.matrix, self.words + other.words, self.keys + other.keys)


def check_navmesh(level: Level, index: ColumnIndex) -> tuple[list[Problem], list[Problem], float]:
    """Problems, warnings, and the share of the nav-mesh's area with a floor within a metre.

    An empty nav-mesh (one that could not be read) has none of them.
    """
    if not len(level.navmesh.faces):
        return [], [], float("nan")
    where = f"{level.file.name}: navmesh"
    points = _sample(level.navmesh.triangles)
    share = _floor_share(index, points)
    name = level.navmesh.file
    if share >= ODD_SHARE:
        return [], [], share
    if share >= LEAST_SHARE:
        found = f"{name}: {1 - share:.0%} of its area has no floor within {FLOOR_WITHIN_M:g} m"
        return [], [Problem(where, found, "rebuild the nav-mesh if the geometry has changed since")], share
    found = f"{name} lies elsewhere than the geometry: {_separation(level, share)}"
    return [Problem(where, found, _explanation(level, index, points))], [], share


def _sample(triangles: Floats) -> Floats:
    """Points [N, 3] spread evenly over the area, the same every time."""
    area = triangle_normals(triangles)[1]
    rng = np.random.default_rng(0)
    place = (np.arange(SAMPLES) + rng.random(SAMPLES)) / SAMPLES
    chosen = triangles[
        np.searchsorted(np.cumsum(area) / area.sum(), place, side="right").clip(max=len(area) - 1)
    ]
    root, along = np.sqrt(rng.random((SAMPLES, 1))), rng.random((SAMPLES, 1))
    return np.asarray(
        (1 - root) * chosen[:, 0] + root * (1 - along) * chosen[:, 1] + root * along * chosen[:, 2]
    )


def _floor_share(index: ColumnIndex, points: Floats) -> float:
    return float(np.isfinite(index.highest(points, FLOOR_WITHIN_M, FLOOR_WITHIN_M)[0]).mean())


def _separation(level: Level, share: float) -> str:
    nav, geometry = _box(level.navmesh.vertices), _box(level.collision.reshape(-1, 3))
    boxes = f"its box is {_show(nav)}, the geometry's {_show(geometry)}"
    if (nav[0] > geometry[1]).any() or (nav[1] < geometry[0]).any():
        return f"the two do not touch; {boxes} [m, z up]"
    return f"only {share:.0%} of its area has a floor within {FLOOR_WITHIN_M:g} m; {boxes} [m, z up]"


def _box(points: Floats) -> tuple[Floats, Floats]:
    return points.min(axis=0), points.max(axis=0)


def _show(box: tuple[Floats, Floats]) -> str:
    return " to ".join("(" + ", ".join(f"{value:.3g}" for value in corner) + ")" for corner in box)


def _explanation(level: Level, index: ColumnIndex, points: Floats) -> str:
    frame = level.reading.navmesh_frame if isinstance(level, ReadLevel) else level.frame
    size = _size(level.collision.reshape(-1, 3))
    for slip in _slips(frame):
        moved = points @ slip.matrix.T
        fits = SIZES[0] <= _size(moved) / size <= SIZES[1]
        if fits and _floor_share(index, moved) >= GOOD_SHARE:
            return f"it looks like {' and '.join(slip.words)}: write {' and '.join(slip.keys)}"
    return "no slip of units or axes explains it: export both from the same level, at the same origin"


def _size(points: Floats) -> float:
    low, high = _box(points)
    return float(np.linalg.norm((high - low)[:2]))


def _slips(frame: Frame) -> list[_Slip]:
    """Ways to misread a mesh, the simple ones first."""
    none = _Slip(np.eye(3))
    other = "z" if frame.up_axis == "y" else "y"
    upright = np.array(UP_AXES["y"], dtype=np.float64)
    turned = _Slip(upright if other == "y" else upright.T, (f"{other} up",), (f"navmesh.up_axis: {other}",))
    flip = str(np.linalg.det(frame.matrix) > 0).lower()
    mirrored = _Slip(np.diag([-1.0, 1.0, 1.0]), ("mirrored x",), (f"navmesh.flip_x: {flip}",))
    scaled = [_scaled(float(np.linalg.norm(frame.matrix[:, 0])), factor) for factor in UNIT_SLIPS]
    every = product([none, *scaled], [none, turned], [none, mirrored])
    slips = [unit.then(turn).then(mirror) for unit, turn, mirror in every]
    return sorted((slip for slip in slips if slip.keys), key=lambda slip: len(slip.keys))


def _scaled(now_m: float, factor: float) -> _Slip:
    unit = unit_name(now_m * factor)
    return _Slip(
        np.eye(3) * factor, (_UNIT_WORDS.get(unit, f"units of {unit} m"),), (f"navmesh.units: {unit}",)
    )
