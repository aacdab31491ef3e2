"""The findings: what of an exploration is a bug, told once, and what it means for the gate."""

from reachtest.findings.detect import DETECTORS, find
from reachtest.findings.verdict import judge

__all__ = ["DETECTORS", "find", "judge"]
