"""From `level.yaml` to a `Level`: reads everything, and reports every mistake at once."""

from __future__ import annotations

import dataclasses
import hashlib
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from reachtest.errors import BadInput
from reachtest.levels.checks.check import check_level
from reachtest.levels.collect import Collected
from reachtest.levels.files import missing_files
from reachtest.levels.keys.document import parse, read_yaml
from reachtest.levels.keys.overlay import overlay
from reachtest.levels.meshes.defects import degenerate
from reachtest.levels.names import distinct
from reachtest.levels.navmeshes.built import built_navmesh
from reachtest.levels.reading import Reading, ReadLevel
from reachtest.records import (
    Bools,
    Floats,
    Frame,
    GateSettings,
    HeightField,
    Level,
    NavMesh,
    Required,
    Spawn,
    Zone,
)

KILL_BELOW_M = 10.0  # deep enough that no pit inside the geometry is a fall
BOUNDS_MARGIN_M = (
    50.0  # farther than any character jumps off the geometry's edge before it falls below kill_z
)


def load_level(path: Path, overrides: Mapping[str, Any] | None = None, config: Path | None = None) -> Level:
    """Read a level file and everything it names.

    `config` is a file with sections `explore` and `gate`, which win over the level's; `overrides` are values from
    the command line, section by section as in the file, which win over both.
    Raises BadInput with all problems found: in the schema, the files, the geometry, and its plausibility.
    """
    path = Path(path)
    given = overlay(config, overrides)
    document = given.over(read_yaml(path))
    spec, problems = parse(document, path.name, given.sources)
    problems += given.problems
    if spec is None:
        raise BadInput(problems + list(missing_files(document, path)), path)
    collected = Collected(spec, path, problems)
    collected.read()
    if collected.collision_known:
        level = _assembled(collected)
        collected.problems += check_level(level).problems
    if collected.problems or not collected.collision_known:
        raise BadInput(collected.problems, path)
    return level


def _assembled(read: Collected) -> ReadLevel:
    """The level, as far as it could be read."""
    spec = read.spec
    collision = np.concatenate(read.collision)
    thin = degenerate(collision)
    collision = collision[~thin]
    low, high = collision.min(axis=(0, 1)), collision.max(axis=(0, 1))
    kill_z = spec.kill_z_m if spec.kill_z_m is not None else float(low[2]) - KILL_BELOW_M
    navmesh, thin_nav = _built(read, collision) if spec.navmesh.build else _navmesh(read)
    return ReadLevel(
        name=spec.name or read.path.resolve().parent.name or "level",
        file=read.path,
        sha256=_digest(read),
        frame=read.frame,
        collision=collision,
        solids=distinct(read.solids),
        parts=tuple(read.parts),
        navmesh=navmesh,
        character=spec.character.character(),
        spawns=tuple(
            Spawn(spawn.name or f"spawn {index}", _point(read, spawn.position))
            for index, spawn in enumerate(spec.spawns)
        ),
        kill_z_m=kill_z,
        bounds=_bounds(read, low, high, kill_z),
        zones=distinct([Zone(zone.name, zone.kind, *zone.box.level_box(read.frame)) for zone in spec.zones]),
        required=distinct(
            [Required(place.name, _point(read, place.position), place.within_m) for place in spec.required]
        ),
        explore=spec.explore.settings(),
        gate=GateSettings(**spec.gate.model_dump()),
        height_fields=_moved_up(read.height_fields, thin),
        reading=Reading(int(thin.sum()), thin_nav, _navmesh_frame(read), spec.navmesh.scale),
    )


def _digest(read: Collected) -> str:
    """Of the level itself: how long it is explored and what fails a build may change, the level is the same."""
    said = read.spec.model_dump(mode="json", exclude={"explore", "gate"}, exclude_unset=True)
    digest = hashlib.sha256(json.dumps(said, sort_keys=True).encode())
    for content in read.contents:
        digest.update(content)
    return digest.hexdigest()


def _point(read: Collected, position: Sequence[float]) -> Floats:
    return read.frame.to_level(np.array(position))


def _navmesh_frame(read: Collected) -> Frame:
    return read.navmesh.mesh.frame if read.navmesh else read.frame


def _navmesh(read: Collected) -> tuple[NavMesh, int]:
    """The nav-mesh without degenerate triangles, and their number; empty if it could not be read."""
    if read.navmesh is None:
        return NavMesh(str(read.spec.navmesh.mesh), np.zeros((0, 3)), np.zeros((0, 3), np.int64)), 0
    return read.navmesh.navmesh, read.navmesh.degenerate


def _built(read: Collected, collision: Floats) -> tuple[NavMesh, int]:
    """A nav-mesh built from the collision triangles; empty if the input is wrong anyway."""
    if read.problems or not read.spec.navmesh.build:
        return NavMesh("", np.zeros((0, 3)), np.zeros((0, 3), np.int64)), 0
    where = f"{read.path.name}: navmesh.build"
    navmesh, problems = built_navmesh(
        read.spec.navmesh.build, read.spec.character.character(), collision, where
    )
    read.problems += problems
    return navmesh, 0


def _bounds(read: Collected, low: Floats, high: Floats, kill_z: float) -> tuple[Floats, Floats]:
    if read.spec.bounds_m:
        return np.array(read.spec.bounds_m.low), np.array(read.spec.bounds_m.high)
    margin = np.full(3, BOUNDS_MARGIN_M)
    return np.append((low - margin)[:2], kill_z), high + margin


def _moved_up(fields: Sequence[HeightField], thin: Bools) -> tuple[HeightField, ...]:
    """The height fields in a collision without its `thin` [F] triangles; one that loses some is none any more."""
    return tuple(dataclasses.replace(field, first=int((~thin[: field.first]).sum())) for field in fields)
