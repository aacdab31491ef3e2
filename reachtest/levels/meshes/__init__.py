"""Mesh files: a reader for each format, and what makes of its pieces a part of the level."""
