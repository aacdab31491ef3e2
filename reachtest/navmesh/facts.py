"""What `reachtest navmesh info` says about a nav-mesh."""

from __future__ import annotations

from collections import Counter
from typing import Any

import numpy as np

from reachtest.records import Floats, NavMesh

LARGEST = 5  # islands whose areas are listed


def facts(navmesh: NavMesh) -> dict[str, Any]:
    """All that there is to say, in metres and square metres, level axes; JSON types only."""
    from reachtest.geometry import triangle_normals
    from reachtest.navmesh.islands import islands

    size = triangle_normals(navmesh.triangles)[1]
    used = navmesh.triangles.reshape(-1, 3)
    per_island = np.sort(np.bincount(islands(navmesh), weights=size))[::-1]
    return {
        "file": navmesh.file,
        "format": navmesh.format,
        "polygons": navmesh.polygons,
        "triangles": len(navmesh.faces),
        "area_m2": float(size.sum()),
        "islands": {"count": len(per_island), "largest_m2": per_island[:LARGEST].tolist()},
        "bounds": {"low": used.min(axis=0).tolist(), "high": used.max(axis=0).tolist()},
        "agent": vars(navmesh.agent),
        "areas_m2": _areas(navmesh, size),
        "links": dict(sorted(Counter(link.kind for link in navmesh.links).items())),
    }


def _areas(navmesh: NavMesh, size: Floats) -> dict[str, float]:
    """Square metres of every area type; none where the format has no types."""
    if navmesh.areas is None:
        return {}
    kinds, which = np.unique(navmesh.areas, return_inverse=True)
    return dict(zip(map(str, kinds.tolist()), np.bincount(which, weights=size).tolist(), strict=True))


def table(found: dict[str, Any]) -> str:
    """The facts for people, one a line."""
    low, high = found["bounds"]["low"], found["bounds"]["high"]
    polygons = found["polygons"]
    rows = [
        ("file", found["file"]),
        ("format", found["format"]),
        ("polygons", "not in the format" if polygons is None else f"{polygons:,}"),
        ("triangles", f"{found['triangles']:,}"),
        ("area", f"{found['area_m2']:,.1f} m2"),
        ("islands", _islands(found["islands"])),
        (
            "bounds",
            " to ".join(f"({', '.join(f'{each:.2f}' for each in corner)})" for corner in (low, high)) + " m",
        ),
        ("agent", _agent(found["agent"])),
        ("areas", ", ".join(f"{kind}: {size:,.1f} m2" for kind, size in found["areas_m2"].items()) or "none"),
        ("links", ", ".join(f"{count:,} {kind}" for kind, count in found["links"].items()) or "none"),
    ]
    return "\n".join(f"{name:<10} {text}" for name, text in rows)


def _islands(found: dict[str, Any]) -> str:
    sizes = ", ".join(f"{size:,.1f}" for size in found["largest_m2"])
    largest = "the largest " if found["count"] > LARGEST else ""
    return f"{found['count']:,}, {largest}of {sizes} m2"


def _agent(agent: dict[str, float | None]) -> str:
    units = {"radius_m": "m", "height_m": "m", "climb_m": "m", "slope_deg": "degrees"}
    known = [
        f"{key.split('_')[0]} {value:.3g} {units[key]}" for key, value in agent.items() if value is not None
    ]
    return ", ".join(known) or "not in the file"
