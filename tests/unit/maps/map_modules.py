"""Imports a map's own scripts as `python maps/<name>/make.py` would, and leaves nothing behind."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType

import numpy as np
import trimesh

MAPS = Path(__file__).parents[3] / "maps"


@contextmanager
def scripts(name: str) -> Iterator[ModuleType]:
    """The `make` module of a map; the modules of several maps have the same names."""
    before, path = set(sys.modules), list(sys.path)
    sys.path[:0] = [str(MAPS / name), str(MAPS)]
    try:
        yield importlib.import_module("make")
    finally:
        sys.path[:] = path
        for module in set(sys.modules) - before:
            file = getattr(sys.modules[module], "__file__", None)
            if file and Path(file).is_relative_to(MAPS):
                del sys.modules[module]


def z_up(points: np.ndarray) -> np.ndarray:
    """From the files' axes to level coordinates."""
    return np.stack([points[..., 0], -points[..., 2], points[..., 1]], axis=-1)


def triangles_of(file: Path) -> np.ndarray:
    """All triangles [F, 3, 3] of a GLB in level coordinates."""
    return z_up(np.asarray(trimesh.load_scene(file, process=False).to_mesh().triangles))
