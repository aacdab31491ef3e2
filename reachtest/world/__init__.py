"""The world: a character in MuJoCo, many at a time, that can be put back into any state it was in."""

from reachtest.world.simulator import SIMULATORS, MujocoSimulator

__all__ = ["SIMULATORS", "MujocoSimulator"]
