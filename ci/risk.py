"""How good the estimates of the risk that remains are: one long run of each level against its own beginnings.

A longer run begins as the shorter one, so that its curve says what a shorter run would have foretold and what
then came. Prints Markdown tables.
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

from reachtest.explore import Explorer
from reachtest.levels import load_level
from reachtest.navmesh.allowed import expected_surface
from reachtest.records import RiskSample, RoundRecord, StopReason
from reachtest.report.risk import is_settled
from reachtest.world import MujocoSimulator

ROOT = Path(__file__).resolve().parent.parent
SMALL = (ROOT / "maps/small/level.yaml", ROOT / "maps/small/level-fixed.yaml")
LONGER = 10
Curve = tuple[RiskSample, ...]


class StopAt:
    """Ends a run at a number of agent steps, without the search for ways back that follows a budget's end."""

    def __init__(self, steps: int) -> None:
        self._left, self._steps = True, steps

    def on_round(self, record: RoundRecord) -> None:
        """Note whether there is more to do."""
        self._left = record.agent_steps < self._steps

    def __call__(self) -> StopReason | None:
        """Why to stop, if so."""
        return None if self._left else StopReason.INTERRUPTED


def curve_of(file: Path, steps: int, seed: int) -> Curve:
    """What a run knew of its risk, over the run."""
    level = load_level(file, {"explore": {"steps": 2 * steps, "stop_when_done": False}})
    level = replace(level, explore=replace(level.explore, time_budget_s=None))
    simulator, stop = MujocoSimulator(level, level.explore.lanes), StopAt(steps)
    explorer = Explorer(level, simulator, expected_surface(level), seed, [stop], stop)
    return explorer.run().risk_curve


def print_probabilities(curves: dict[str, Curve]) -> None:
    """What was foretold of the next episodes, and the share of them that found something new."""
    print(
        "| level | agent steps | goals | bound Q1/t | share of the latest | share of the next | bound held |"
    )
    print("|---|---|---|---|---|---|---|")
    for name, curve in curves.items():
        for now, later in pairwise(curve):
            observed = (later.discovering - now.discovering) / (later.episodes - now.episodes)
            print(
                f"| {name} | {now.agent_steps:,} | {now.goals_reached} | {now.discovery_probability:.1%} |"
                f" {now.recent_share:.1%} | {observed:.1%} |"
                f" {'yes' if observed <= now.discovery_probability else '**no**'} |"
            )


def print_totals(curves: dict[str, Curve]) -> None:
    """What was foretold of a run ten times as long, and what it found."""
    print("\n| level | agent steps | settled | cells seen | foretold | ten times the steps | bracketed |")
    print("|---|---|---|---|---|---|---|")
    for name, curve in curves.items():
        for number, now in enumerate(curve, start=1):
            later = next((s for s in curve if s.agent_steps >= LONGER * now.agent_steps), None)
            if later is None:
                break
            settled = is_settled(curve[:number], now.goals_reached < curve[-1].goals_reached)
            low, high = now.ten_times_longer
            print(
                f"| {name} | {now.agent_steps:,} | {'yes' if settled else 'no'} |"
                f" {now.cells_total:,} | {low:,.0f} to {high:,.0f} | {later.cells_total:,} |"
                f" {'yes' if low <= later.cells_total <= high else '**no**'} |"
            )


def main() -> None:
    """Run, and print both tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("levels", nargs="*", type=Path, default=SMALL, help="level.yaml files [maps/small]")
    parser.add_argument("--steps", type=int, default=1_000_000)
    parser.add_argument("--seed", type=int, default=0)
    args = parser.parse_args()
    curves = {
        f"{file.parent.name}/{file.stem}": curve_of(file, args.steps, args.seed) for file in args.levels
    }
    print_probabilities(curves)
    print_totals(curves)


if __name__ == "__main__":
    main()
