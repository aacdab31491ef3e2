"""What became of a bug that a run did not find: fixed, worse, or just not seen."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from reachtest.baseline.place import NEAR_M, Place, gap_m
from reachtest.records import SATURATED_RISK


@dataclass(frozen=True)
class Look:
    """A run, as far as it can tell whether a bug is gone."""

    sha256: str  # of the level and what it names
    enough: bool  # explored enough for a pass, but for its findings
    risk: float | None  # of finding something new: the bound, or what the latest episodes did find
    found: tuple[Place, ...]  # every finding
    new: tuple[Place, ...]  # those of them that are no known bug

    def doubt(self, known: Place, sha256: str | None) -> str:
        """Why a bug seen in the level of that `sha256` may still be there; empty: it is fixed.

        The level must have changed, since nobody mends a bug otherwise.
        """
        reached = self._was_reached(known)
        if sha256 == self.sha256:
            return f"{'it was reached this time, but ' if reached else ''}the level is still the same"
        if reached:
            return ""
        if sha256 is None:
            return "nobody noted which version of the level it was seen in"
        if not self.enough:
            return "the run was too short"
        if self.risk is None or self.risk > SATURATED_RISK:
            return "the run still found new places at its end"
        return ""

    def worse(self, known: Place) -> Place | None:
        """The new fall out of the world where standing off the nav-mesh was known."""
        if known.kind != "unexpected_area":
            return None
        falls = [place for place in self.new if place.kind == "fell_out_of_world"]
        near = ((gap_m(replace(fall, kind=known.kind), known), fall) for fall in falls)
        gap, fall = min(near, key=lambda pair: pair[0], default=(np.inf, None))
        return fall if gap <= NEAR_M else None

    def _was_reached(self, known: Place) -> bool:
        """Whether the bug was that nobody got there and somebody did, which is no question of luck."""
        if known.kind == "required_unreached":
            return True  # it would have been found by its name
        return known.kind == "unreached_area" and not any(_touch(known, place) for place in self.found)


def _touch(known: Place, found: Place) -> bool:
    """Whether a place of the same kind lies in the box of the other, if only in part."""
    apart = np.maximum(known.low - found.high, found.low - known.high)
    return found.kind == known.kind and bool((apart <= 0).all())


def new_ones(places: Sequence[Place], matched: Sequence[int | None]) -> tuple[Place, ...]:
    """Those of `places` [n] that `match` found nothing for."""
    return tuple(place for place, index in zip(places, matched, strict=True) if index is None)
