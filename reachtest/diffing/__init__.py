"""What changed from one run to another."""

from reachtest.diffing.compare import Difference, compare
from reachtest.diffing.render import RENDERERS

__all__ = ["RENDERERS", "Difference", "compare"]
