"""Stage levels: reads `level.yaml` and the meshes it names, and says everything that is wrong with them.

Reading order: `schema` (what the file says), `document` and `complaints` (how it is read), `meshes` (the
files it names), `load` (how it becomes a `Level`), `check` (whether that level is plausible).
"""

from reachtest.levels.check import Check, check_level
from reachtest.levels.files import named_files
from reachtest.levels.load import load_level
from reachtest.levels.meshes import MESH_READERS
from reachtest.levels.navmesh_formats import NAVMESH_FORMATS
from reachtest.levels.presets import PRESETS
from reachtest.levels.primitives import PRIMITIVES
from reachtest.levels.read_navmesh import read_navmesh_file
from reachtest.levels.schema import json_schema

__all__ = [
    "MESH_READERS",
    "NAVMESH_FORMATS",
    "PRESETS",
    "PRIMITIVES",
    "Check",
    "check_level",
    "json_schema",
    "load_level",
    "named_files",
    "read_navmesh_file",
]
