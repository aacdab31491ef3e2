"""Levels that nobody tuned the test on: random and sealed, so that nobody falls out of them.

Turned by any angle and up to 2 km from the origin, in any unit, up axis, file format and for any character; the
nav-mesh is built. Prints a Markdown table. What gates is to be looked at: one can climb a heap of props
(`unexpected_area`), and two flights of stairs or four rocks can enclose a pit (`stuck`). With `--mutants N` bugs are
planted, too.
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Callable
from pathlib import Path

import buildings
import caves
import clutter
import numpy as np
import terrain
import trimesh
import yaml

from reachtest import pipeline
from reachtest.bench.mutants import measure_recall

STEPS = 100_000
AROUND_M = 15.0  # below the lowest floor the world ends
STEPPING = ("unreal", "unity", "quake3")
Make = Callable[[np.random.Generator], tuple[list[trimesh.Trimesh], np.ndarray]]
# How each kind is made, and for whom: its stairs are nothing for who does not step up.
KINDS: dict[str, tuple[Make, tuple[str, ...]]] = {
    "buildings": (buildings.make, STEPPING),
    "terrain": (terrain.make, (*STEPPING, "godot")),
    "caves": (caves.make, (*STEPPING, "godot")),
    "clutter": (clutter.make, (*STEPPING, "godot")),
}


def write_level(kind: str, seed: int, folder: Path) -> Path:
    """Write a level's mesh and file; the same for the same seed."""
    rng, (make, characters) = np.random.default_rng(seed), KINDS[kind]
    pieces, spawn = make(rng)
    place = trimesh.transformations.rotation_matrix(rng.uniform(0, 2 * np.pi), [0, 0, 1])
    place[:3, 3] = [*rng.uniform(-2000, 2000, 2), rng.uniform(-50, 50)]
    units, up, suffix = (
        str(rng.choice(some)) for some in (["m", "cm"], ["y", "z"], ["obj", "glb", "stl", "ply"])
    )
    if up == "y":
        place = np.array([[1, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]]) @ place
    place = np.diag([100.0, 100.0, 100.0, 1.0] if units == "cm" else [1.0] * 4) @ place
    mesh = trimesh.util.concatenate(pieces)
    mesh.apply_transform(place)
    mesh.export(folder / f"level.{suffix}")
    lowest = mesh.bounds[0][1 if up == "y" else 2] / (100 if units == "cm" else 1)
    axes = {"up_axis": up, "units": units}
    level = {
        "version": 1,
        "name": f"{kind} {seed}",
        "frame": axes,
        "geometry": [{"mesh": f"level.{suffix}", **axes}],
        "navmesh": {"build": {"min_island_m2": 1.0}},  # corners between flights are small
        "character": str(rng.choice(characters)),
        "spawns": [{"name": "start", "position": (place @ np.append(spawn, 1.0))[:3].tolist()}],
        "kill_z_m": float(lowest - AROUND_M),
        "explore": {"steps": STEPS},
    }
    path = folder / "level.yaml"
    path.write_text(yaml.safe_dump(level))
    return path


def row(kind: str, seed: int, mutants: int) -> str:
    """What a run of the level, and with `mutants` bugs planted in it, comes to."""
    with tempfile.TemporaryDirectory() as folder:
        path = write_level(kind, seed, Path(folder))
        run = pipeline.RunOptions(path, out=Path(folder) / "out", seed=0)
        report, _ = pipeline.run(pipeline.load(run), run)
        who = yaml.safe_load(path.read_text())["character"]
        recall = measure_recall(path, mutants, 0, None).row() if mutants else None
    gates = [
        f"{finding.kind} at {np.round(finding.position, 1).tolist()}"
        for finding in report.findings
        if finding.gating
    ]
    reached = report.exploration.goal_step >= 0
    cells = [
        f"{kind} {seed}",
        who,
        report.verdict.name,
        f"{reached.sum()} of {len(reached)}",
        ", ".join(gates),
        f"{recall[1]} of {recall[0]}" if recall else "",
    ]
    return f"| {' | '.join(cells)} |"


def main() -> None:
    """Print a row for each level."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("kinds", nargs="*", default=list(KINDS), help=", ".join(KINDS))
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--count", type=int, default=12)
    parser.add_argument("--mutants", type=int, default=0, help="bugs planted in each")
    options = parser.parse_args()
    if unknown := set(options.kinds) - set(KINDS):
        parser.error(f"unknown: {', '.join(sorted(unknown))}")
    print(
        "| level | character | verdict | goals | what gates | planted bugs found |\n|---|---|---|---|---|---|"
    )
    for kind in options.kinds:
        for seed in range(options.first, options.first + options.count):
            print(row(kind, seed, options.mutants), flush=True)


if __name__ == "__main__":
    main()
