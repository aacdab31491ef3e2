"""Which findings of two runs are the same bug: by the exits that baselines go by, and else by the middle.

A baseline takes what touches a known area for known. Here that would hide a blocked room behind the islands that are
not connected to anything, whose bounds are often the whole level's: so of wide bounds only the middle counts.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from reachtest.baseline.place import Place, match
from reachtest.records import Finding

_HALF_M = 4.0  # of what is left of wide bounds


def same_place(found: Sequence[Finding], known: Sequence[Finding]) -> list[int | None]:
    """For each of `found` the index of the one of `known` that it is; None where it is new."""
    return match([_compact(finding) for finding in found], [_compact(finding) for finding in known])


def _compact(finding: Finding) -> Place:
    place = Place.of(finding)
    middle, half = (place.low + place.high) / 2, np.minimum((place.high - place.low) / 2, _HALF_M)
    return replace(place, low=middle - half, high=middle + half)
