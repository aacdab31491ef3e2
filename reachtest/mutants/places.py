"""Which findings of two runs are the same bug: by the exits that baselines go by, and else by the middle.

A baseline takes what touches a known area for known. Here that would hide a blocked room behind the islands that are
not connected to anything, whose bounds are often the whole level's: so wide areas are known by their id first, and of
what is left only the middle counts.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from reachtest.baseline.place import Place, match
from reachtest.records import Finding

_HALF_M = 4.0  # of what is left of wide bounds
_WIDE_M = 16.0


def same_place(found: Sequence[Finding], known: Sequence[Finding]) -> list[int | None]:
    """For each of `found` the index of the one of `known` that it is; None where it is new."""
    wide = {finding.id: index for index, finding in enumerate(known) if _is_wide(finding)}
    result = [wide.get(finding.id) if _is_wide(finding) else None for finding in found]
    rest = [index for index, pair in enumerate(result) if pair is None]
    others = [index for index in range(len(known)) if index not in result]
    pairs = match([_compact(found[index]) for index in rest], [_compact(known[index]) for index in others])
    for index, pair in zip(rest, pairs, strict=True):
        result[index] = None if pair is None else others[pair]
    return result


def _is_wide(finding: Finding) -> bool:
    return finding.exits is None and bool((finding.high - finding.low).max() > _WIDE_M)


def _compact(finding: Finding) -> Place:
    place = Place.of(finding)
    middle, half = (place.low + place.high) / 2, np.minimum((place.high - place.low) / 2, _HALF_M)
    return replace(place, low=middle - half, high=middle + half)
