"""The planted bugs that a map's `truth.yaml` describes."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import yaml

from reachtest.records import Finding, Floats, Frame


@dataclass(frozen=True)
class PlantedBug:
    """One of them, in level coordinates."""

    name: str
    kinds: tuple[str, ...]
    position: Floats  # [3] m
    radius_m: float
    low: Floats  # [3] m
    high: Floats  # [3] m

    def is_told_by(self, finding: Finding) -> bool:
        """Whether a finding's kind is right, and its position or exit point in the bounds or near the position."""
        places = [finding.position, *([] if finding.exit_point is None else [finding.exit_point])]
        near = any(
            bool(((at >= self.low) & (at <= self.high)).all())
            or float(np.linalg.norm(at - self.position)) <= self.radius_m
            for at in places
        )
        return finding.kind in self.kinds and near


def planted_bugs(level: Path, frame: Frame) -> tuple[PlantedBug, ...]:
    """The bugs planted in `level`: those of truth.yaml beside it, if its head names this file; else none."""
    file = level.parent / "truth.yaml"
    if not file.is_file():
        return ()
    text = file.read_text(encoding="utf-8")
    if f" {level.name}" not in text.partition("\nversion:")[0]:
        return ()  # it is about another variant of the map
    return tuple(_bug(spec, frame) for spec in yaml.safe_load(text)["bugs"])


def _bug(spec: dict[str, object], frame: Frame) -> PlantedBug:
    bounds = spec["bounds"]
    assert isinstance(bounds, dict)
    corners = frame.to_level(np.array([bounds["low"], bounds["high"]], dtype=np.float64))
    also = spec.get("also") or []
    assert isinstance(also, list)
    return PlantedBug(
        name=str(spec["name"]),
        kinds=(str(spec["kind"]), *map(str, also)),
        position=frame.to_level(np.array(spec["position"], dtype=np.float64)),
        radius_m=float(str(spec["radius_m"])),
        low=corners.min(axis=0),
        high=corners.max(axis=0),
    )
