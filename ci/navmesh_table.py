"""Every real level's nav-mesh against a run: its islands, its goals, and why some were not reached. Prints Markdown."""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from reachtest.geometry import triangle_normals
from reachtest.levels import load_level

ROOT = Path(__file__).resolve().parent.parent
HEADER = (
    "level",
    "format",
    "m2",
    "islands",
    "connected to a spawn",
    "goals",
    "reached",
    "left: unconnected",
    "left: mismatch",
    "left: unreached",
    "verdict",
)


def run(level: Path, steps: int) -> dict[str, Any]:
    """The report of one run, as the command line gives it."""
    with tempfile.TemporaryDirectory() as out:
        command = [sys.executable, "-m", "reachtest", "run", str(level), "--steps", str(steps), "--out", out]
        done = subprocess.run([*command, "--json", "--quiet"], capture_output=True, text=True)
    if done.returncode not in (0, 1, 4):
        raise SystemExit(f"{level}: exit status {done.returncode}\n{done.stderr}")
    return dict(json.loads(done.stdout))


def row(path: Path, steps: int) -> tuple[object, ...]:
    """One line of the table."""
    navmesh = load_level(path).navmesh
    report = run(path, steps)
    coverage = report["coverage"]
    unconnected = coverage["goals_total"] - coverage["goals_connected"]
    unconnected -= coverage["goals_reached"] - coverage["goals_connected_reached"]
    mismatch = coverage["goals_unreached_by_mismatch"]
    return (
        path.parent.name,
        navmesh.format or navmesh.file.rpartition(".")[2],
        f"{triangle_normals(navmesh.triangles)[1].sum():,.0f}",
        coverage["islands"],
        coverage["islands_connected"],
        coverage["goals_total"],
        coverage["goals_reached"],
        unconnected,
        mismatch,
        coverage["goals_unreached"] - unconnected - mismatch,
        report["verdict"],
    )


def main() -> None:
    """All levels of maps/real, or the named ones."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("level", nargs="*", help="names of folders in maps/real")
    parser.add_argument("--steps", type=int, default=200_000)
    options = parser.parse_args()
    print(f"| {' | '.join(HEADER)} |\n|{'---|' * len(HEADER)}")
    for path in sorted((ROOT / "maps/real").glob("*/level.yaml")):
        if not options.level or path.parent.name in options.level:
            print(f"| {' | '.join(map(str, row(path, options.steps)))} |", flush=True)


if __name__ == "__main__":
    main()
