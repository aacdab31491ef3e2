"""What a level consists of, section by section: so that replaying can name what changed, and not only in which file."""

from __future__ import annotations

import dataclasses
import hashlib
from collections.abc import Iterator, Mapping

import numpy as np

from reachtest.records import Level

GEOMETRY = "the collision geometry"
MOST = 12  # lines: a level whose parts all have new names has changed, and no more need be said
SAYS_WHERE = ("expected_within_m",)  # of explore: the rest says how one looks, and changes no level


def values_of(level: Level) -> dict[str, str]:
    """Settings, by their keys in the level file."""
    explore = {key: getattr(level.explore, key) for key in SAYS_WHERE}
    return {
        **{f"character.{key}": str(value) for key, value in vars(level.character).items()},
        **{f"explore.{key}": str(value) for key, value in explore.items()},
        "kill_z_m": str(level.kill_z_m),
    }


def digests_of(level: Level) -> dict[str, str]:
    """Of what has a place: a digest of where it is, by what a designer calls it."""
    mesh = level.navmesh
    result = {
        GEOMETRY: _digest(level.collision),
        "the nav-mesh": _digest(mesh.triangles, mesh.areas, [_plain(link) for link in mesh.links]),
        "bounds": _digest(*level.bounds),
    }
    named: dict[str, list[tuple[str, object]]] = {
        "geometry": [(part.name, (part.low, part.high)) for part in level.parts],
        "solid": [(solid.name, solid.triangles) for solid in level.solids],
        "spawn": [(spawn.name, spawn.position) for spawn in level.spawns],
        "zone": [(zone.name, (zone.kind, zone.low, zone.high)) for zone in level.zones],
        "required point": [(point.name, (point.position, point.within_m)) for point in level.required],
    }
    for what, things in named.items():
        same: dict[str, list[object]] = {}  # a name may stand for several
        for name, where in things:
            same.setdefault(f"{what} '{printable(name)}'", []).append(where)
        result |= {name: _digest(places) for name, places in same.items()}
    return result


def differences(level: Level, values: Mapping[str, str], digests: Mapping[str, str]) -> list[str]:
    """What is not as it was kept, a line each."""
    now = values_of(level)
    lines = [
        f"{key} is {now[key]}, it was {values[key]}" for key in now if now[key] != values.get(key, now[key])
    ]
    places = dict(_changed(digests_of(level), digests))
    if any(name.startswith("geometry ") for name in places):
        places.pop(GEOMETRY, None)  # said better
    lines += [f"{name} {what}" for name, what in places.items()]
    more = len(lines) - MOST
    return lines if more <= 1 else [*lines[:MOST], f"and {more} more"]


def printable(text: str) -> str:
    """`text` without halves of surrogate pairs, which a level file can hold and JSON cannot."""
    return text.encode("utf-8", errors="replace").decode()


def _changed(now: Mapping[str, str], before: Mapping[str, str]) -> Iterator[tuple[str, str]]:
    for name, digest in now.items():
        if name not in before:
            yield name, "is new"
        elif before[name] != digest:
            yield name, "has changed"
    yield from ((name, "is gone") for name in before if name not in now)


def _digest(*parts: object) -> str:
    return hashlib.sha256(repr([_plain(part) for part in parts]).encode()).hexdigest()[:16]


def _plain(value: object) -> object:
    """The same without numpy and records, whose `repr` leaves numbers out."""
    if isinstance(value, np.ndarray):
        return value.shape, hashlib.sha256(np.ascontiguousarray(value).tobytes()).hexdigest()
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if dataclasses.is_dataclass(value):
        return [_plain(item) for item in vars(value).values()]
    return value
