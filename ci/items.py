"""Which items of oa_dm1 and aggressor the Quake agent reaches, and where it is trapped, beside what the game's own bot
navigation says.

usage: python ci/items.py [STEPS]      (default: 200,000 agent steps, seed 0)
"""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from reachtest.columns import ColumnIndex
from reachtest.explore import Explorer
from reachtest.levels import load_level
from reachtest.navmesh.allowed import expected_surface
from reachtest.records import Character, Level, Pocket, Required, Spawn
from reachtest.world import MujocoSimulator

ROOT = Path(__file__).resolve().parent.parent
SHARED = ROOT.parent / "shared/levels"
ORIGIN_M = 0.75  # of an entity above its feet: 24 units of 1/32 m
TOUCH_M = 1.2  # item and player touch when their boxes do: 30 units, and half a unit's slack on the diagonal
DROP_M = 4.0  # items that hang in the air fall to the floor when the game starts


def main() -> None:
    """One table a level."""
    steps = int(sys.argv[1]) if len(sys.argv) > 1 else 200_000
    for name in ("oa_dm1", "aggressor"):
        truth = json.loads((SHARED / name / f"{name}.aas_truth.json").read_text())
        level = _as_the_game(load_level(ROOT / "maps/real" / name / "level.yaml"), truth, steps)
        simulator = MujocoSimulator(level, level.explore.lanes)
        found = Explorer(level, simulator, expected_surface(level), 0).run()
        _print(name, truth["items"], found.required_step >= 0, found.required_attempts)
        _print_traps(level, truth["traps"], found.pockets)


def _as_the_game(level: Level, truth: dict[str, Any], steps: int) -> Level:
    """The level with Quake's agent, the game's spawns, and its items as required points on the floor below them."""
    who = level.character
    agent = Character(
        radius_m=0.47,
        height_m=1.75,
        walk_speed_mps=10.0,
        jump_speed_mps=8.44,
        step_height_m=0.5625,
        slope_limit_deg=float(np.degrees(np.arccos(0.7))),
        gravity_mps2=25.0,
        terminal_speed_mps=who.terminal_speed_mps,
        acceleration_mps2=100.0,
        braking_mps2=60.0,
        ground_friction=6.0,
        air_control=0.1,
    )
    spawns = level.frame.to_level(np.array([spawn["pos"] for spawn in truth["spawns"]])) - [
        0,
        0,
        ORIGIN_M - 0.02,
    ]
    items = level.frame.to_level(np.array([item["pos"] for item in truth["items"]]))
    floor, _ = ColumnIndex(level.collision).highest(items, DROP_M, 0.1)
    items[:, 2] = np.where(np.isfinite(floor), floor, items[:, 2] - ORIGIN_M)
    names = [item["cls"] for item in truth["items"]]
    return replace(
        level,
        character=agent,
        spawns=tuple(Spawn(f"spawn {i}", place) for i, place in enumerate(spawns)),
        required=tuple(Required(n, place, TOUCH_M) for n, place in zip(names, items, strict=True)),
        explore=replace(level.explore, steps=steps),
    )


def _print(name: str, items: list[dict[str, Any]], reached: Any, attempts: Any) -> None:
    """The counts, and every item on which the two differ. Items in no area of the bots' are not compared."""
    hows = ("walk", "jump", "full")
    known = np.array([item["jump"] is not None for item in items])
    print(f"\n## {name}: {len(items)} items, {known.sum()} of them known to its bots\n")
    print("| reached by | items | of those ours reached |\n|---|---|---|")
    for how in hows:
        said = np.array([(item[how] or 0) > 0 for item in items])
        print(f"| its bots, {how} | {said.sum()} | {(reached & said).sum()} |")
    print(f"| ours, of the known ones | {(reached & known).sum()} | |")
    print(
        "\n| where they differ | place | its bots: walk, jump, full | ours | attempts |\n|---|---|---|---|---|"
    )
    for item, mine, tried in zip(items, reached, attempts, strict=True):
        if item["jump"] is not None and mine != (item["jump"] > 0):
            counts = ", ".join(str(item[how]) for how in hows)
            place = ", ".join(f"{x:.1f}" for x in item["pos"])
            print(
                f"| {item['cls']} | {place} | {counts} | {'reached' if mine else 'not reached'} | {tried} |"
            )


def _print_traps(level: Level, areas: list[Any], pockets: Sequence[Pocket]) -> None:
    """Areas from which the bots know no way to a spawn, and the pockets from which nobody found one."""
    print(f"\nTraps: {len(areas)} areas of its bots, {len(pockets)} pockets of ours")
    for pocket in pockets:
        place = ", ".join(f"{x:.1f}" for x in level.frame.to_source(pocket.cells.mean(axis=0)))
        kind = "stuck" if pocket.stuck else "no way back"
        print(f"* {kind} at {place}: {pocket.attempts} attempts, {pocket.volume_m3:.0f} m3")


if __name__ == "__main__":
    main()
