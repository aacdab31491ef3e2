"""Measures reachtest itself: how fast it is on a level."""
