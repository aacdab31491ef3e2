"""Does the nav-mesh lie on the geometry? If not, which slip of units or axes would explain it?

Shape legend: N sample points.
"""

from __future__ import annotations

from itertools import groupby, product

import numpy as np

from reachtest.columns import ColumnIndex
from reachtest.errors import Problem
from reachtest.geometry import triangle_normals
from reachtest.levels.checks.slips import slips
from reachtest.levels.navmeshes.built import TURNED_OVER
from reachtest.navmesh.build import BUILT, BUILT_BOTH, turned_over
from reachtest.records import Floats, Level

SAMPLES = 1000  # the share is then known to within 0.03
FLOOR_WITHIN_M = 1.0  # quantisation and erosion move a nav-mesh by less than its climb height, 0.9 m at most
LEAST_SHARE = 0.5  # below it the nav-mesh is some other level's, or lies elsewhere
ODD_SHARE = 0.9
GOOD_SHARE = 0.7  # of a hypothesis that is worth naming
CLEARLY_BETTER = 0.15  # a level with symmetries takes its own mirror image nearly as well
KEY_FIRST = 0.05  # likewise as well as turned round: then rather what a key puts right
TINY_SHARE, TINY_M = 0.1, 3.0  # a nav-mesh this small in proportion, or at all, may be in other units
OUTSIDE_M = (
    50.0  # of the geometry's box: nobody jumps so far, and a nav-mesh in place is at most a few cells out
)
ASTRAY_M = 50_000.0  # likewise: larger than any streamed world, and more than can be sampled
NO_EXPLANATION = "no slip of units or axes explains it: export both from the same level, at the same origin"
SIZES = (0.25, 1.5)  # of the nav-mesh in proportion to the level: a shrunken one lies on *some* floor too


def check_navmesh(level: Level, index: ColumnIndex) -> tuple[list[Problem], list[Problem], float]:
    """Problems, warnings, and the share of the nav-mesh's area with a floor within a metre.

    An empty nav-mesh (one that could not be read) has none of them.
    """
    if not len(level.navmesh.faces):
        return [], [], float("nan")
    where = f"{level.file.name}: navmesh"
    points = _sample(level.navmesh.triangles)
    share = _floor_share(index, points)
    if level.navmesh.format in (BUILT, BUILT_BOTH):  # from this very geometry: units and axes are the same
        over = level.navmesh.format == BUILT and turned_over(level.collision, level.character.slope_limit_deg)
        return [], [Problem(f"{where}.build", *TURNED_OVER)] if over else [], share
    name = level.navmesh.file
    slip = _explanation(level, index, points, share) if share < ODD_SHARE else ""
    if slip or share < LEAST_SHARE:
        found = f"{name} lies elsewhere than the geometry: {_separation(level, share)}"
        return (
            [Problem(where, found, slip or NO_EXPLANATION + _moved(level, index, points, share))],
            [],
            share,
        )
    outside, astray = _outside(level, where)
    if astray:
        return outside, [], share
    size, whole = _size(points), _size(level.collision.reshape(-1, 3))
    if size < TINY_SHARE * whole and (slip := _explanation(level, index, points, 0.0)):
        problem = Problem(where, f"{name} spans only {size:.2g} m of the geometry's {whole:.3g} m", slip)
        return ([problem], outside, share) if size < TINY_M else ([], [problem, *outside], share)
    if share < ODD_SHARE:
        found = f"{name}: {1 - share:.0%} of its area has no floor within {FLOOR_WITHIN_M:g} m"
        remedy = "rebuild the nav-mesh if the geometry has changed since"
        return [], [Problem(where, found, remedy), *outside], share
    return [], outside, share


def _outside(level: Level, where: str) -> tuple[list[Problem], bool]:
    """Triangles far outside of the geometry's box, and whether some are so far that nothing can be done with them.

    Samples by area miss them where they are small or thin.
    """
    low, high = _box(level.collision.reshape(-1, 3))
    corners = level.navmesh.triangles
    away = np.maximum(low - corners, corners - high).max(axis=(1, 2))
    far = np.flatnonzero(away > OUTSIDE_M)
    if not len(far):
        return [], False
    worst = int(np.argmax(away))
    place = corners[worst][np.maximum(low - corners[worst], corners[worst] - high).max(axis=1).argmax()]
    found = (
        f"{level.navmesh.file}: {len(far):,} of {len(corners):,} triangles lie outside of the geometry's box"
    )
    found += f" by more than {OUTSIDE_M:g} m, the farthest at {_show_point(place)} [m, z up]"
    remedy = "remove them from the nav-mesh, or add the geometry that they lie on"
    return [Problem(where, found, remedy)], bool(away[worst] > ASTRAY_M)


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
    return " to ".join(_show_point(corner) for corner in box)


def _show_point(point: Floats) -> str:
    return "(" + ", ".join(f"{value:.3g}" for value in point) + ")"


def _explanation(level: Level, index: ColumnIndex, points: Floats, share: float) -> str:
    """The slip that fits best among those with the fewest keys; empty if none beats `share` clearly.

    Where the nav-mesh lies on the geometry by half and more, its unit is right: a shrunken one fits anything.
    """
    size = _size(level.collision.reshape(-1, 3))
    tried = [slip for slip in slips(level) if share < LEAST_SHARE or slip.keeps_size]
    for _, alike in groupby(tried, key=lambda slip: slip.cost):
        fits = [
            (_fit(index, points @ slip.matrix.T, size) - KEY_FIRST * bool(slip.export), slip)
            for slip in alike
        ]
        fit, best = max(fits, key=lambda pair: pair[0])
        if fit > share + CLEARLY_BETTER:
            return best.remedy
    return ""


def _moved(level: Level, index: ColumnIndex, points: Floats, share: float) -> str:
    """The offset between the two boxes that lays the nav-mesh on the geometry; empty if none beats `share` clearly."""
    nav, geometry = _box(level.navmesh.vertices), _box(level.collision.reshape(-1, 3))
    low, high = geometry[0] - nav[0], geometry[1] - nav[1]
    each = [
        np.array(offset) for offset in product(*zip(low, (low + high) / 2, high, np.zeros(3), strict=True))
    ]
    shares = [_floor_share(index, points + offset) for offset in each]
    best = int(np.argmax(shares))
    if shares[best] < max(GOOD_SHARE, share + CLEARLY_BETTER):
        return ""
    there = points + each[best]
    floor, _ = index.highest(there, 2 * FLOOR_WITHIN_M, 2 * FLOOR_WITHIN_M)
    offset = each[best] + [
        0.0,
        0.0,
        np.nanmedian(floor - there[:, 2]),
    ]  # boxes have no floors in their corners
    return f"; moved by about {_show_point(offset.round(1) + 0.0)} m (z up) it lies on the geometry"


def _fit(index: ColumnIndex, points: Floats, size: float) -> float:
    """How well a nav-mesh lies on a level of this size [m]: above 0 where it plausibly does."""
    ratio = _size(points) / size
    share = _floor_share(index, points) if SIZES[0] <= ratio <= SIZES[1] else 0.0
    # Among floors that take any nav-mesh, the right unit is the one that fills the level.
    return share - 0.1 * abs(float(np.log(ratio))) if share >= GOOD_SHARE else 0.0


def _size(points: Floats) -> float:
    low, high = _box(points)
    return float(np.linalg.norm((high - low)[:2]))
