"""The exploration: Go-Explore over a simulator, with one shared position cache."""

from reachtest.explore.confirm import Confirmer
from reachtest.explore.explorer import Explorer
from reachtest.explore.heuristics import HEURISTICS
from reachtest.explore.replay import Replayer

__all__ = ["HEURISTICS", "Confirmer", "Explorer", "Replayer"]
