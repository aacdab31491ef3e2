"""Known bugs: a file of them, and which findings of a run they are."""

from reachtest.baseline.apply import Outcome, apply_baseline
from reachtest.baseline.document import Baseline, Entry, baseline_of, read_baseline
from reachtest.baseline.gone import Look
from reachtest.baseline.place import Place, match

__all__ = [
    "Baseline",
    "Entry",
    "Look",
    "Outcome",
    "Place",
    "apply_baseline",
    "baseline_of",
    "match",
    "read_baseline",
]
