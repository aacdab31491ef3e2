"""Simulates recorded findings again, on the level as it is now."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

import numpy as np

from reachtest.confirm.outcome import Judge
from reachtest.confirm.shorten import pursuits
from reachtest.confirm.trials import Lane, Plan, Trial, run_lanes
from reachtest.confirm.variation import vary
from reachtest.errors import BadInput, Problem
from reachtest.interfaces import Simulator
from reachtest.levels import load_level, named_files
from reachtest.navmesh.allowed import expected_surface
from reachtest.records import Floats, Level
from reachtest.replaying.keep import digests
from reachtest.replaying.kept import POCKETS, KeptFinding, Recording, State, outcome_of
from reachtest.replaying.sections import differences, printable
from reachtest.world import SIMULATORS

ATTEMPTS = 32  # to get there on a changed level: acting on what is seen, and with other actions around
LANES = 33
SPAWN_M = 0.01  # the character is put where the level file says
_SEED = 0x2E9


@dataclass(frozen=True)
class Repeated:
    """What became of one finding."""

    finding: KeptFinding
    passed: bool | None  # None: cannot be told without a run
    note: str  # how, or why not
    start: Floats | None = None  # [3]
    positions: Floats | None = None  # [N, 3] of what is shown: it came about, or else the recorded actions


def find_level(folder: Path, state: State, given: Path | None) -> Path:
    """The level file: the given one, or that of the run. Raises BadInput."""
    if given is not None:
        return given
    kept = state.kept.level
    for path in (Path(kept.file), folder / kept.beside):
        if path.is_file():
            return path
    found = f"the level '{kept.name}' is not at {kept.file} any more"
    raise BadInput([Problem(str(folder), found, "say where it is: --level LEVEL.yaml")])


def load(path: Path, state: State) -> Level:
    """The level as it is now. Raises BadInput, also for another level."""
    level, before = load_level(path), state.kept.level.name
    if printable(level.name) != before:
        found = f"is the level '{level.name}', the replay is of '{before}'"
        raise BadInput([Problem(str(path), found, "give a build of the level that the run was about")])
    return level


def at_its_step(level: Level, state: State) -> Level:
    """The level at the time step of the run."""
    kept = state.kept
    explore = dataclasses.replace(level.explore, physics_hz=kept.physics_hz, action_repeat=kept.action_repeat)
    return dataclasses.replace(level, explore=explore)


def changes(level: Level, state: State) -> list[str]:
    """What differs from the run: files and what is in them, the simulator's version; empty if nothing does."""
    kept = state.kept
    result = []
    if level.sha256 != kept.level.sha256:
        now, before = digests(named_files(level.file)), kept.level.files
        here, there = level.file.name, Path(kept.level.file).name
        if here != there and there in before:  # the level file itself goes by another name
            before = {here if name == there else name: digest for name, digest in before.items()}
        result += [f"{name} has changed" for name in now if name in before and now[name] != before[name]]
        result += [f"{name} is new" for name in now if name not in before]
        result += [f"{name} is not named any more" for name in before if name not in now]
        result = result or ["a file that one of its files refers to has changed"]
    if kept.level.values is not None and kept.level.sections is not None:  # `explore` is not in the digest
        result += differences(level, kept.level.values, kept.level.sections)
    if version("mujoco") != kept.mujoco:
        result.append(f"MuJoCo is {version('mujoco')}, it was {kept.mujoco}")
    return result


def repeat(level: Level, state: State, findings: Sequence[KeptFinding], changed: bool) -> list[Repeated]:
    """Simulate `findings` again, side by side."""
    judge = Judge(level, expected_surface(level))
    known = [
        (finding, recording)
        for finding in findings
        if (recording := state.recordings.get(finding.id)) and _can_be_told(finding, recording)
    ]
    if not known:
        return [_untold(level, finding, state) for finding in findings]
    simulator = SIMULATORS[state.kept.simulator](level, LANES, 0)
    size = len(simulator.place(np.zeros((1, 3)))[0])
    if any(len(recording.state) != size for _, recording in known):
        found = f"its states are not those of the simulator '{state.kept.simulator}' of this version"
        raise BadInput([Problem("state/findings.npz", found, "run the level again")])
    lanes = [Lane(recording.state, recording.actions, len(recording.actions)) for _, recording in known]
    trials = run_lanes(simulator, lanes)
    told = {}
    for (finding, recording), trial in zip(known, trials, strict=True):
        told[finding.id] = _told(judge, finding, recording, trial, changed)
        if changed and not told[finding.id].passed:
            more = [trial, *_others(simulator, recording)]
            told[finding.id] = _tried(judge, finding, recording, more)
        if not _at_a_spawn(level, trial.start[:3]):
            note = f"{told[finding.id].note}; its start is no spawn of the level any more"
            told[finding.id] = dataclasses.replace(told[finding.id], note=note)
    return [told.get(finding.id) or _untold(level, finding, state) for finding in findings]


def _at_a_spawn(level: Level, place: Floats) -> bool:
    return any(np.linalg.norm(spawn.position - place) <= SPAWN_M for spawn in level.spawns)


def _can_be_told(finding: KeptFinding, recording: Recording) -> bool:
    return finding.kind not in POCKETS or recording.standing is not None


def _untold(level: Level, finding: KeptFinding, state: State) -> Repeated:
    why = "an older version kept no places of it" if finding.id in state.recordings else "no path to repeat"
    return Repeated(finding, None, f"{why}, cannot be told without a run: reachtest run {level.file}")


def _told(judge: Judge, finding: KeptFinding, recording: Recording, trial: Trial, changed: bool) -> Repeated:
    came = judge.step(outcome_of(finding, recording), trial) is not None
    same = np.array_equal(trial.positions, recording.positions)
    if changed:
        note = f"still there, by the recorded actions{_way_out(finding)}" if came else "not reproduced"
    else:
        note = "bit for bit" if came and same else "not reproduced" if not came else "not bit for bit"
    return Repeated(finding, came and (same or changed), note, trial.start[:3], trial.positions)


def _way_out(finding: KeptFinding) -> str:
    """What the way in does not tell of a pocket: somebody may have added stairs."""
    return "; whether one gets out now is told by a run" if finding.kind in POCKETS else ""


def _others(simulator: Simulator, recording: Recording) -> list[Trial]:
    """The recorded way on a level that is not quite the same: followed, and with other actions around."""

    rng = np.random.default_rng(_SEED)
    steps = len(recording.actions) * 5 // 4 + 8
    size = len(recording.state)
    states = np.zeros((len(recording.positions), size))
    states[:, :3] = recording.positions
    found = Trial(recording.state, recording.actions, states, recording.positions, False)
    plans: list[Plan] = [
        *pursuits(found, ATTEMPTS // 2, steps, rng),
        *(vary(recording.actions, steps, rng) for _ in range(ATTEMPTS // 2)),
    ]
    return run_lanes(simulator, [Lane(recording.state, plan, steps) for plan in plans])


def _tried(judge: Judge, finding: KeptFinding, recording: Recording, trials: Sequence[Trial]) -> Repeated:
    outcome = outcome_of(finding, recording)
    steps = [judge.step(outcome, trial) for trial in trials]
    good = [i for i, step in enumerate(steps) if step is not None]
    shown = trials[good[0]] if good else trials[0]
    end = (steps[good[0]] or 0) + 1 if good else len(shown)
    count = f"{len(good)} of {len(trials)} attempts"
    there = f"still there, by {count} around the recorded actions{_way_out(finding)}"
    note = there if good else f"not there any more: {count}"
    return Repeated(finding, bool(good), note, shown.start[:3], shown.positions[:end])
