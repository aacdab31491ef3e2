"""Stage levels: reads `level.yaml` and the meshes it names, and says everything that is wrong with them.

Reading order: `frames` and `fields` (axes, units, single values), `keys` (what the file may say, how it is read, and
what a configuration puts over it), `shapes`, `meshes` and `navmeshes` (what it names), `collect` (reads all of that),
`load` (how it becomes a `Level`), `checks` (whether that level is plausible). That is no order of imports: the keys
know the formats that they may name.
"""

from reachtest.levels.checks.check import Check, check_level
from reachtest.levels.files import named_files
from reachtest.levels.keys.level import json_schema
from reachtest.levels.keys.presets import PRESETS
from reachtest.levels.load import load_level
from reachtest.levels.meshes.formats import MESH_READERS
from reachtest.levels.navmeshes.formats import NAVMESH_FORMATS
from reachtest.levels.navmeshes.read import read_navmesh_file
from reachtest.levels.shapes.primitives import PRIMITIVES

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
