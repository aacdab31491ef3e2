"""How fast a level is explored, beside what the bare physics of the same tiles would take, in one run."""

from __future__ import annotations

import resource
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from reachtest.explore import Explorer
from reachtest.explore.actions import action_stream
from reachtest.levels import load_level
from reachtest.navmesh.allowed import expected_surface
from reachtest.records import Floats, Level
from reachtest.world import MujocoSimulator

MOST_BARE_STEPS = 200_000  # enough to average over
PUSH_MPS2 = 15.0  # random controls: about what it takes to walk


@dataclass(frozen=True)
class Speed:
    """One measurement."""

    agent_steps: int
    agent_steps_per_s: float  # of the whole exploration
    physics_steps_per_s_per_core: float  # likewise
    bare_physics_agent_steps_per_s: float  # `Batch.step` with random controls, nothing else
    bare_physics_steps_per_s_per_core: float
    explorer_over_physics: float
    characters_agent_steps_per_s: (
        float  # with the character's controller, under random gamepads, nothing else
    )
    explorer_over_characters: float  # what the search leaves of that
    cache_us_per_step: float  # checking and inserting
    bytes_per_point: float  # outside the tree
    peak_rss_mb: float
    first_step_s: float  # from reading the level on
    tiles_compiled: int
    positions: int
    goals_reached: int
    goals_total: int
    threads: int
    probe_s: float  # looking for pockets afterwards, whose steps are not counted


def measure_speed(path: Path, steps: int | None = None, seed: int = 0) -> Speed:
    """Explore the level at `path`, then step as many agents of the places found. Raises BadInput."""
    began = time.perf_counter()
    level = load_level(path, {"explore": {"steps": steps}} if steps else {})
    settings = level.explore
    surface = expected_surface(level)
    simulator = MujocoSimulator(level, settings.lanes)
    explorer = Explorer(level, simulator, surface, seed)
    _first_step(level, simulator)
    first_step_s = time.perf_counter() - began
    found = explorer.run()
    rate = found.agent_steps / found.timing["wall_s"]
    tests = simulator, found.points.states, found.agent_steps, settings.reset_interval
    bare, characters = (_rate(*tests, controls) for controls in (_pushes, _gamepads))
    per_core = settings.action_repeat / simulator.threads
    return Speed(
        agent_steps=found.agent_steps,
        agent_steps_per_s=rate,
        physics_steps_per_s_per_core=rate * per_core,
        bare_physics_agent_steps_per_s=bare,
        bare_physics_steps_per_s_per_core=bare * per_core,
        explorer_over_physics=rate / bare,
        characters_agent_steps_per_s=characters,
        explorer_over_characters=rate / characters,
        cache_us_per_step=found.timing["cache_s"] / found.agent_steps * 1e6,
        bytes_per_point=explorer.bytes_per_point,
        peak_rss_mb=_peak_rss_mb(),
        first_step_s=first_step_s,
        tiles_compiled=simulator.tiles_compiled,
        positions=len(found.points),
        goals_reached=int((found.goal_step >= 0).sum()),
        goals_total=len(found.goals),
        threads=simulator.threads,
        probe_s=found.timing["probe_s"],
    )


def _first_step(level: Level, simulator: MujocoSimulator) -> None:
    spawns = simulator.place(np.array([spawn.position for spawn in level.spawns]))
    everyone = np.arange(simulator.agents)
    simulator.restore(everyone, spawns[everyone % len(spawns)])
    simulator.step(np.zeros((simulator.agents, 2), dtype=np.int8))


Step = Callable[[], object]


def _pushes(simulator: MujocoSimulator, rng: np.random.Generator, steps: int) -> list[Step]:
    """Agent steps of bare physics."""
    pushes = rng.normal(0.0, PUSH_MPS2, (steps, simulator.agents, 3)) * [1.0, 1.0, 0.0]
    return [partial(simulator.coast, push) for push in pushes]


def _gamepads(simulator: MujocoSimulator, rng: np.random.Generator, steps: int) -> list[Step]:
    """Agent steps of characters; the gamepads are those of an exploration."""
    seed = int(rng.integers(1 << 32))
    streams = [action_stream(seed, 0, agent, steps) for agent in range(simulator.agents)]
    return [partial(simulator.step, actions) for actions in np.stack(streams, axis=1)]


def _rate(
    simulator: MujocoSimulator,
    states: Floats,
    agent_steps: int,
    interval: int,
    controls: Callable[[MujocoSimulator, np.random.Generator, int], list[Step]],
) -> float:
    """Agent steps a second under `controls` from states [P, S], set anew every `interval` steps.

    Every round is run twice and the second time counts: it finds its tiles compiled.
    """
    rng = np.random.default_rng(0)
    everyone = np.arange(simulator.agents)
    rounds = max(1, min(agent_steps, MOST_BARE_STEPS) // (interval * len(everyone)))
    spent = 0.0
    for _ in range(rounds):
        starts = states[rng.integers(len(states), size=len(everyone))]
        steps = controls(simulator, rng, interval)
        for _ in ("warm", "timed"):
            simulator.restore(everyone, starts)
            begin = time.perf_counter()
            for step in steps:
                step()
            once = time.perf_counter() - begin
        spent += once
    return rounds * interval * len(everyone) / spent


def _peak_rss_mb() -> float:
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak / (1e6 if sys.platform == "darwin" else 1024)  # bytes there, kB on Linux
