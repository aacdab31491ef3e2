"""`--audit`: ground that characters stand on and the nav-mesh misses, near enough to be no bug.

Shape legend: n points.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from reachtest.findings.cluster import single_linkage
from reachtest.findings.evidence import Evidence
from reachtest.navmesh.expected import floats_over
from reachtest.records import Floats

_LINK_M = 2.0  # cached points are a metre apart: this bridges one that is missing
_DIGITS = 3  # as the other positions of report.json


def missed_ground(evidence: Evidence) -> list[dict[str, Any]]:
    """Places of report.json's `audit`, the largest first.

    Of the expected standing places those that erosion and float cannot explain: farther from the surface than a
    radius and a cell to the side, or than a climb up or down, and not at a link's end or in an allowed zone.
    """
    level, points = evidence.level, evidence.exploration.points
    allowed = evidence.allowed
    standing = points.positions[points.grounded & points.expected & ~allowed]
    missed = standing[~floats_over(level.navmesh, level.character, standing)]
    groups = sorted(single_linkage(missed, _LINK_M), key=len, reverse=True)
    return [_entry(evidence, missed[group]) for group in groups]


def _entry(evidence: Evidence, places: Floats) -> dict[str, Any]:
    position = places[np.linalg.norm(places - places.mean(axis=0), axis=1).argmin()]
    return {
        "position": _plain(position),
        "source_position": _plain(evidence.level.frame.to_source(position)),
        "bounds": [_plain(places.min(axis=0)), _plain(places.max(axis=0))],
        "points": len(places),
        "nearest_named": evidence.nearest_part(position),
    }


def _plain(position: Floats) -> list[float]:
    return [float(value) for value in (position.round(_DIGITS) + 0.0).tolist()]  # + 0.0: no "-0.0"
