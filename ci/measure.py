"""Long measurements: the planted bugs over seeds, and the real levels. Prints Markdown tables."""

from __future__ import annotations

import argparse
import json
import os
import platform
import subprocess
import sys
import tempfile
from collections.abc import Callable, Collection
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from reachtest.columns import ColumnIndex
from reachtest.explore import Explorer
from reachtest.levels import load_level
from reachtest.navmesh.allowed import expected_surface
from reachtest.records import Exploration, Floats, Level, Points, Spawn, StepResult
from reachtest.world import MujocoSimulator

ROOT = Path(__file__).resolve().parent.parent
OPEN_LEVELS = ("demo_level", "three_pathfinding", "tut3d", "nav_test")
SEALED_LEVELS = ("oa_dm1",)
SHARED = ROOT.parent / "shared/levels"
AGREEMENT_STEPS = 300_000
FALL_M, CELL_M = 2.0, 1.5  # a fall at the same edge; a floor at a cell border flips cells
FOOTING_M = 3.0  # a footing of the reference character this near to ours is the same edge


def run(level: Path, seed: int, *options: str) -> dict[str, Any]:
    """The report of one run, as the command line gives it."""
    with tempfile.TemporaryDirectory() as out:
        command = [sys.executable, "-m", "reachtest", "run", str(level), "--seed", str(seed), "--out", out]
        done = subprocess.run([*command, "--json", "--quiet", *options], capture_output=True, text=True)
    if done.returncode not in (0, 1, 4):
        raise SystemExit(f"{level} seed {seed}: exit status {done.returncode}\n{done.stderr}")
    report = json.loads(done.stdout)
    assert report["exit_code"] == done.returncode
    return dict(report)


def small() -> None:
    """Both bugs of maps/small in every seed, and nothing in the fixed map."""
    truth = yaml.safe_load((ROOT / "maps/small/truth.yaml").read_text())["bugs"]
    print(
        "| map | seed | exit | findings | all goals at step | goals | positions | wall s | physics / cache s |"
    )
    print("|---|---|---|---|---|---|---|---|---|")
    for name in ("level.yaml", "level-fixed.yaml"):
        for seed in range(10):
            report = run(ROOT / "maps/small" / name, seed)
            gating = [f for f in report["findings"] if f["gating"]]
            matched = {bug["name"] for bug in truth for f in gating if _matches(bug, f)}
            strays = [f for f in gating if not any(_matches(bug, f) for bug in truth)]
            what = ", ".join(sorted(matched)) + "".join(f" **stray {f['kind']}**" for f in strays)
            timing, coverage = report["timing"], report["coverage"]
            print(
                f"| {name} | {seed} | {report['exit_code']} | {what or 'none'} | {coverage['all_goals_step']} |"
                f" {coverage['goals_reached']} of {coverage['goals_total']} |"
                f" {report['positions']['discovered']} | {timing['wall_s']:.1f} |"
                f" {timing['physics_s']:.1f} / {timing['cache_s']:.1f} |",
                flush=True,
            )


def _matches(bug: dict[str, Any], finding: dict[str, Any]) -> bool:
    """Whether a finding is the planted bug: its kind, at its place (truth.yaml is in the level's own axes)."""
    if finding["kind"] not in (bug["kind"], *bug.get("also", ())):
        return False
    away = np.linalg.norm(np.array(finding["source_position"]) - bug["position"])
    low, high = np.array(bug["bounds"]["low"]), np.array(bug["bounds"]["high"])
    inside = (np.array(finding["source_position"]) >= low) & (np.array(finding["source_position"]) <= high)
    return bool(away <= bug["radius_m"] or inside.all())


def real() -> None:
    """The real levels: the open ones are left at their open edges, the sealed one is not left."""
    print("| level | seed | exit | fell | other gating | goals | positions | footings near the reference's |")
    print("|---|---|---|---|---|---|---|---|")
    for name in (*OPEN_LEVELS, *SEALED_LEVELS):
        level = ROOT / "maps/real" / name / "level.yaml"
        for seed in range(5 if name in SEALED_LEVELS else 1):
            report = run(level, seed)
            fell = [f for f in report["findings"] if f["kind"] == "fell_out_of_world"]
            others = [f["kind"] for f in report["findings"] if f["gating"] and f not in fell]
            coverage = report["coverage"]
            print(
                f"| {name} | {seed} | {report['exit_code']} | {len(fell)} | {', '.join(others) or '-'} |"
                f" {coverage['goals_reached']} of {coverage['goals_total']} |"
                f" {report['positions']['discovered']} | {_near_reference(name, fell)} |",
                flush=True,
            )


def _near_reference(name: str, fell: list[dict[str, Any]]) -> str:
    """How many of our footings lie near one of the reference character's last footings."""
    file = SHARED / name / "jolt_reach.jump.json"
    if not fell or not file.exists():
        return "-"
    theirs = np.array(json.loads(file.read_text())["exit_footings"])
    ours = np.array([f["source_position"] for f in fell])
    near = np.linalg.norm(ours[:, None] - theirs[None], axis=2).min(axis=1) <= FOOTING_M
    return f"{near.sum()} of {len(ours)}"


def agreement(steps: int = AGREEMENT_STEPS, levels: Collection[str] = ()) -> None:
    """Where the reference character stood and fell, against ours: same capsule, spawn and speeds, seed 0."""
    print(
        "| level | moves | still growing | our falls | its footings near ours | its cells ours reached |"
        " of those one can stand in | ours it reached |"
    )
    print("|---|---|---|---|---|---|---|---|")
    for file in sorted(SHARED.glob("*/jolt_reach.*.json")):
        if not levels or file.parent.name in levels:
            _agreement_with(file, steps)


def _agreement_with(file: Path, steps: int) -> None:
    name, moves = file.parent.name, file.name.split(".")[1]
    theirs = json.loads(file.read_text())
    level = _as_the_reference(load_level(ROOT / "maps/real" / name / "level.yaml"), theirs)
    simulator, found = _explored(level, steps)
    stood = simulator.places()
    footings = np.array([fall.footing for fall in found.falls]).reshape(-1, 3)
    cells = level.frame.to_level(np.array(theirs["standing_cells_1m"]) + 0.5)
    exits = level.frame.to_level(np.array(theirs["exit_footings"]).reshape(-1, 3))
    near = cKDTree(footings).query(exits)[0] <= FALL_M if len(footings) else np.zeros(len(exits))
    met = cKDTree(stood).query(cells)[0] <= CELL_M
    roomy = np.concatenate(
        [np.flatnonzero(met), np.flatnonzero(~met)[_has_footing(level, simulator, cells[~met])]]
    )
    known = np.mean(cKDTree(cells).query(stood)[0] <= CELL_M)
    row = f"| {name} | {moves} | {_growth(found.points):.1%} | {len(footings)} | {np.sum(near):.0f} of {len(exits)} |"
    print(f"{row} {met.mean():.1%} | {met[roomy].mean():.1%} | {known:.1%} |", flush=True)
    if folder := os.environ.get("REACHTEST_KEEP"):  # to look at the places afterwards
        np.savez(
            Path(folder) / f"{name}-{moves}.npz", stood=stood, cells=cells, footings=footings, exits=exits
        )


def _as_the_reference(level: Level, theirs: dict[str, Any]) -> Level:
    capsule = theirs["capsule"]
    character = replace(
        level.character,
        radius_m=capsule["radius"],
        height_m=capsule["height"],
        step_height_m=capsule["step"],
        slope_limit_deg=capsule["slope_deg"],
        walk_speed_mps=theirs["speed"],
        jump_speed_mps=theirs["jump_speed"],
        gravity_mps2=theirs["gravity"],
        air_control=1.0,  # its files do not say, but it gets under rims that one cannot get under without
    )
    spawn = Spawn("reference", level.frame.to_level(np.array(theirs["spawn"])))
    return replace(level, character=character, spawns=(spawn,), required=())


class _Standing(MujocoSimulator):
    """Remembers everywhere somebody stood: the cache alone keeps points a metre apart, also of those in the air."""

    stood: Floats = np.empty((0, 3))

    def step(self, actions: NDArray[np.int8]) -> StepResult:
        result = super().step(actions)
        some = result.stood[np.isfinite(result.stood[:, 0])]
        self.stood = np.concatenate([self.stood, some])
        if len(self.stood) > 200_000:
            self.stood = self.places()
        return result

    def places(self) -> Floats:
        """One position of every cell of a quarter of a metre [n, 3]."""
        _, first = np.unique(np.floor(self.stood * 4), axis=0, return_index=True)
        return self.stood[first]


def _explored(level: Level, steps: int) -> tuple[_Standing, Exploration]:
    level = replace(level, explore=replace(level.explore, steps=steps))
    surface = expected_surface(level)
    simulator = _Standing(level, level.explore.lanes)
    return simulator, Explorer(level, simulator, surface, 0).run()


def _has_footing(level: Level, simulator: MujocoSimulator, cells: Floats) -> NDArray[np.bool_]:
    """In which cells [n, 3] there is walkable floor with room for a character above it.

    The reference counts every tick of support: also that of an edge inside a flush wall that it slides past.
    """
    c = level.character
    across = np.arange(-0.75, 0.76, 0.1)
    around = np.stack(
        [*(side.ravel() for side in np.meshgrid(across, across)), np.zeros(len(across) ** 2)], axis=1
    )
    places = (cells[:, None] + around).reshape(-1, 3)
    floor, slope = ColumnIndex(level.collision).highest(places, 1.0, 1.0)
    good = np.flatnonzero(np.isfinite(floor) & (slope >= np.cos(np.radians(c.slope_limit_deg))))
    places = places[good]
    hang = c.radius_m * (1 / slope[good] - 1)  # a sphere on a slope touches uphill of its lowest point
    places[:, 2] = floor[good] + hang + 0.005
    result = np.zeros(len(cells), dtype=np.bool_)
    result[good[simulator.has_room(places)] // len(around)] = True
    return result


def _growth(points: Points) -> float:
    """Share of the standing places that the last fifth of the run brought: small where it is saturated."""
    late = points.round >= 0.8 * points.round.max()
    return float(late[points.grounded].mean())


def threads() -> None:
    """Same seed, 1 thread and 2 threads: the same report outside `timing`."""
    for name in ("maps/small/level.yaml", "maps/small/level-fixed.yaml"):
        one, two = (run(ROOT / name, 0, "--threads", str(n)) for n in (1, 2))
        same = {k: v for k, v in one.items() if k != "timing"} == {
            k: v for k, v in two.items() if k != "timing"
        }
        print(f"{name}: 1 and 2 threads give {'the same' if same else 'DIFFERENT'} reports")
        if not same:
            raise SystemExit(1)


PARTS: dict[str, Callable[[], None]] = {
    "small": small,
    "real": real,
    "agreement": agreement,
    "threads": threads,
}


def main() -> None:
    """Run the named parts."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("part", choices=[*PARTS, "all"])
    parser.add_argument("--steps", type=int, default=AGREEMENT_STEPS, help="of agreement [agent steps]")
    parser.add_argument("--levels", default="", help="of agreement, by commas; default: all")
    given = parser.parse_args()
    print(f"{os.cpu_count()} cores, {platform.machine()}, Python {platform.python_version()}\n")
    for name in PARTS if given.part == "all" else (given.part,):
        print(f"\n## {name}\n")
        if name == "agreement":
            agreement(given.steps, [level for level in given.levels.split(",") if level])
        else:
            PARTS[name]()


if __name__ == "__main__":
    main()
