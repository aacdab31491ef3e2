"""The files that a level file names."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from pathlib import Path
from typing import Any

from reachtest.errors import Problem
from reachtest.levels.keys.document import read_yaml
from reachtest.levels.meshes.formats import MESH_READERS
from reachtest.levels.meshes.paths import file_problem
from reachtest.levels.navmeshes.formats import NAVMESH_SUFFIXES
from reachtest.levels.shapes.primitives import PRIMITIVES


def named_files(path: Path) -> dict[str, Path]:
    """The level file and every file it names, by the name it goes by there. Raises BadInput."""
    document = read_yaml(path)
    names = [name for _, name, *_ in _file_keys(document) if isinstance(name, str) and name]
    return {path.name: path} | {name: path.parent / name for name in names}


def missing_files(document: Mapping[str, Any], path: Path) -> Iterator[Problem]:
    """The files that a document with other mistakes names in vain."""
    for where, name, types, what_for in _file_keys(document):
        if not isinstance(name, str) or not name:
            continue
        typed = types is not NAVMESH_SUFFIXES  # a nav-mesh's content says what it is
        if bad := file_problem(name, path.parent, types, what_for, typed):
            yield Problem(f"{path.name}: {where}", *bad)


def _file_keys(document: Mapping[str, Any]) -> Iterator[tuple[str, Any, Collection[str], str]]:
    """Every key that names a file, with its value, the types the file may have, and what it is for."""
    geometry = document.get("geometry")
    for index, item in enumerate(geometry if isinstance(geometry, list) else []):
        yield f"geometry[{index}].mesh", _get(item, "mesh"), MESH_READERS, "mesh"
        for kind, primitive in PRIMITIVES.items():
            name = _get(_get(item, kind), "file")
            if primitive.files:
                yield f"geometry[{index}].{kind}.file", name, primitive.files, kind
    yield "navmesh.mesh", _get(document.get("navmesh"), "mesh"), NAVMESH_SUFFIXES, "mesh"


def _get(value: Any, key: str) -> Any:
    return value.get(key) if isinstance(value, dict) else None
