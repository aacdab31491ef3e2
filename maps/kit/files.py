"""The text files of a map: truth.yaml and level.yaml, with positions in the files' axes (y up)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import yaml

from kit.mesh import y_up
from kit.pieces import Corner

TRUTH_HEADER = """\
# The planted bugs of level.yaml, in its own axes and units. Written by make.py.
# A finding counts if its position or exit point lies in `bounds` or within `radius_m` of `position`.
"""


@dataclass(frozen=True)
class Bug:
    """A planted bug, in level coordinates [m]."""

    name: str
    kind: str
    also: tuple[str, ...]
    position: Corner
    low: Corner
    high: Corner
    radius_m: float
    description: str

    def entry(self) -> dict[str, Any]:
        """The bug as truth.yaml has it."""
        corners = y_up(np.array([self.low, self.high], float))
        return {
            "name": self.name,
            "kind": self.kind,
            "also": list(self.also),
            "position": place(self.position),
            "bounds": {"low": corners.min(axis=0).tolist(), "high": corners.max(axis=0).tolist()},
            "radius_m": self.radius_m,
            "description": self.description,
        }


def place(position: Corner) -> list[float]:
    """A position in the files' axes."""
    return [float(value) for value in y_up(np.array(position, float)).round(4)]


def truth_yaml(bugs: Sequence[Bug], **more: Any) -> bytes:
    """The text of truth.yaml."""
    document = {"version": 1, "frame": {"up_axis": "y", "units": "m"}, "bugs": [bug.entry() for bug in bugs]}
    return (TRUTH_HEADER + dump({**document, **more})).encode()


def level_yaml(comment: str, document: dict[str, Any]) -> bytes:
    """The text of a level file under a comment."""
    return (f"# {comment} Written by make.py.\n" + dump(document)).encode()


def dump(document: dict[str, Any]) -> str:
    """YAML in the order given, short lists on one line."""
    return str(yaml.safe_dump(document, sort_keys=False, default_flow_style=None, width=110))
