"""Repeating a run's findings from its output folder: `state` keeps, `repeat` simulates, the rest shows them."""
