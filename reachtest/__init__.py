"""reachtest: fuzzing for level geometry."""

__version__ = "0.1.0"
