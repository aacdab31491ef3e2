"""Confirming: what was found is simulated again, in more than one way, before it is called a bug."""

from reachtest.confirm.confirmer import Confirmer

__all__ = ["Confirmer"]
