"""A third opinion: Rapier's character controller explores levels of ../shared/levels, beside ours and the reference's.

Needs `pip install rapier3d`; run `python ci/third_opinion.py`. Prints a Markdown table.
"""

from __future__ import annotations

import argparse
import importlib
import itertools
import json
from dataclasses import replace
from typing import Any

import numpy as np
from measure import CELL_M, FALL_M, ROOT, SHARED, _as_the_reference, _explored
from rapier_walk import Opinion, RapierCharacter, Search
from scipy.spatial import cKDTree

from reachtest.levels import load_level
from reachtest.records import Floats, Level, Spawn

CASES = (("oa_dm1", "walk"), ("nav_test", "jump"), ("dungeon", "jump"))
# Rapier's step rule asks for this much floor behind the edge. On a single box with its height set to 0.45 m it climbs
# 0.46 m with the first and 0.55 m with the second, since its capsule's round end may rest on the edge.
STEP_WIDTHS_M = (0.3, 0.1)
TICKS = 2_400_000  # as much play as the 300,000 agent steps of 4/30 s that ours gets
DUNGEON_EXIT, DUNGEON_NEAR_M = (9.9, 25.1, -81.1), 6.0  # source axes; where ours leaves the dungeon
DUNGEON_HEAP = (15.0, 22.25, -79.05)  # source axes; the last place below it that ours gets to by walking


def ours(level: Level) -> Opinion:
    """Our character's exploration, as `measure.py agreement` has it."""
    simulator, found = _explored(level)
    footings = np.array([fall.footing for fall in found.falls]).reshape(-1, 3)
    return Opinion(simulator.places(), footings)


def reference(level: Level, theirs: dict[str, Any]) -> Opinion:
    """What the reference character's search left: centres of its cells, and some of its last footings."""
    cells = level.frame.to_level(np.array(theirs["standing_cells_1m"]) + 0.5)
    return Opinion(cells, level.frame.to_level(np.array(theirs["exit_footings"]).reshape(-1, 3)))


def share(places: Floats, among: Floats, within_m: float) -> str:
    """How many of `places` [n, 3] have one of `among` [m, 3] near."""
    if not len(places):
        return "-"
    near = cKDTree(among).query(places)[0] <= within_m if len(among) else np.zeros(len(places))
    return f"{near.mean():.1%}"


def cells(places: Floats) -> Floats:
    """One of `places` for every cell of a metre: so that all three count alike."""
    return places[np.unique(np.floor(places), axis=0, return_index=True)[1]]


def compare(rapier: Any, name: str, moves: str, ticks: int, seed: int) -> None:
    """Print the rows of one level."""
    theirs = json.loads((SHARED / name / f"jolt_reach.{moves}.json").read_text())
    level = _as_the_reference(load_level(ROOT / "maps/real" / name / "level.yaml"), theirs)
    opinions = {"ours": ours(level), "reference": reference(level, theirs)}
    for width in STEP_WIDTHS_M:
        character = RapierCharacter(rapier, level, width)
        opinions[f"Rapier, {width} m"] = Search(character, level, seed, moves == "jump").run(ticks)
    for one, other in itertools.permutations(opinions, 2):
        a, b = opinions[one], opinions[other]
        if one.startswith("Rapier") and other.startswith("Rapier"):
            continue
        stood, fell = share(cells(a.stood), b.stood, CELL_M), share(a.exits, b.exits, FALL_M)
        print(
            f"| {name} | {moves} | {one} | {len(cells(a.stood))} | {len(a.exits)} | {other} | {stood} | {fell} |",
            flush=True,
        )
    if name == "dungeon":
        heap = Spawn("heap", level.frame.to_level(np.array(DUNGEON_HEAP)))
        character = RapierCharacter(rapier, level, STEP_WIDTHS_M[0])
        search = Search(character, replace(level, spawns=(heap,)), seed, jumping=True)
        opinions["Rapier from the heap below"] = search.run(ticks // 8)
        _at_the_exit(level, opinions)


def _at_the_exit(level: Level, opinions: dict[str, Opinion]) -> None:
    place = level.frame.to_level(np.array(DUNGEON_EXIT))
    for who, opinion in opinions.items():
        near = np.sum(np.linalg.norm(opinion.exits - place, axis=1) < DUNGEON_NEAR_M)
        where = f"within {DUNGEON_NEAR_M:g} m of {DUNGEON_EXIT}"
        print(f"\n{who}: {near} of {len(opinion.exits)} falls {where}", flush=True)


def main() -> None:
    """Compare the levels of CASES, or those named."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("levels", nargs="*", help="some of " + ", ".join(name for name, _ in CASES))
    parser.add_argument("--ticks", type=int, default=TICKS)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    try:
        rapier = importlib.import_module("rapier3d")
    except ImportError:
        raise SystemExit("ci/third_opinion.py needs Rapier's Python binding: pip install rapier3d") from None
    if not SHARED.is_dir():
        raise SystemExit(f"ci/third_opinion.py needs the levels in {SHARED}")
    print("| level | moves | who | cells | falls | against | cells it stood in too | falls near one of its |")
    print("|---|---|---|---|---|---|---|---|")
    for name, moves in CASES:
        if not options.levels or name in options.levels:
            compare(rapier, name, moves, options.ticks, options.seed)


if __name__ == "__main__":
    main()
