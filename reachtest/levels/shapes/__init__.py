"""Shapes that `level.yaml` can state without a mesh file."""
