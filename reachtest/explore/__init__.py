"""The exploration: Go-Explore over a simulator, with one shared position cache."""

from reachtest.explore.explorer import Explorer
from reachtest.explore.heuristics import HEURISTICS, check_heuristics
from reachtest.explore.replay import Replayer

__all__ = ["HEURISTICS", "Explorer", "Replayer", "check_heuristics"]
