"""Episodes that act on purpose: towards open goals, over the nav-mesh's border, and across gaps."""

from reachtest.explore.directed.purposes import Directed, directed

__all__ = ["Directed", "directed"]
