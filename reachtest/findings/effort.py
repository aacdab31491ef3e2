"""Effort: a place is called unreached only after directed attempts to get there; before that, nobody can say.

Shape legend: G goals, n goals of one area.
"""

from __future__ import annotations

import numpy as np

from reachtest.findings.cluster import single_linkage
from reachtest.records import Bools, Exploration, Ints


def open_areas(exploration: Exploration, counts: Bools) -> list[Ints]:
    """The unreached goals among those that count [G], grouped by area: indices [n] for each."""
    missing = np.flatnonzero((exploration.goal_step < 0) & counts)
    groups = single_linkage(exploration.goals[missing], 2 * exploration.settings.goal_spacing_m)
    return [missing[group] for group in groups]


def attempts_at(exploration: Exploration, goals: Ints) -> int:
    """Directed attempts in vain at an area of `goals` [n], from its border as it is now."""
    known = exploration.goal_attempts
    return int(known[goals].sum()) if len(known) else 0


def attempts_at_required(exploration: Exploration, index: int) -> int:
    """The same for a required point."""
    known = exploration.required_attempts
    return int(known[index]) if len(known) else 0


def enough(exploration: Exploration, attempts: int) -> bool:
    """Whether so many attempts are enough to call a place unreached."""
    return attempts >= exploration.settings.effort


def required_tried(exploration: Exploration, index: int) -> bool:
    """Whether a required point can be called unreached: attempts near it mean something where a way is promised."""
    return is_connected(exploration, index) and enough(exploration, attempts_at_required(exploration, index))


def is_connected(exploration: Exploration, index: int) -> bool:
    """Whether the nav-mesh promises a way from a spawn to a required point."""
    known = exploration.required_connected
    return bool(known[index]) if len(known) else True


def given_up(exploration: Exploration, counts: Bools) -> Bools:
    """The unreached goals among those that count [G] that a run can call unreached: enough was done to get there.

    None where nobody got to any of them: then it is not the places that are wrong.
    """
    result = np.zeros(len(exploration.goals), dtype=np.bool_)
    if (exploration.goal_step[counts] >= 0).any():
        for area in open_areas(exploration, counts):
            result[area] = enough(exploration, attempts_at(exploration, area))
    return result


def describe_required(exploration: Exploration, index: int) -> tuple[str, ...]:
    """What was tried to get to a required point, for people."""
    attempts = attempts_at_required(exploration, index)
    if is_connected(exploration, index):
        return describe(exploration, attempts)
    tries = f"{attempts} directed attempt{'s' * (attempts != 1)} did not get there"
    return (
        f"{tries}: inconclusive, the nav-mesh connects it to no spawn, so that nobody knows where to try",
    )


def describe(exploration: Exploration, attempts: int, goals: Ints | None = None) -> tuple[str, ...]:
    """What was tried to get to a place (an area of `goals` [n], if given), for people."""
    near = ""
    if goals is not None and attempts:
        near = f" from {exploration.goal_border_m[goals].min():.1f} m away"
    tries = f"{attempts} directed attempt{'s' * (attempts != 1)}{near} did not get there"
    if enough(exploration, attempts):
        return (tries,)
    if not attempts:
        tries = "no directed attempt was made to get there"
    return (f"{tries}: inconclusive, explore.effort asks for {exploration.settings.effort}",)


def lacking(exploration: Exploration, counts: Bools, areas_too: bool = True) -> tuple[list[str], int | None]:
    """What is missing before unreached places can be called so, and an estimate of how many more steps that takes.

    Required points always, and areas of the goals that count [G] if `areas_too`.
    """
    areas = open_areas(exploration, counts) if areas_too else []
    short = sum(not enough(exploration, attempts_at(exploration, area)) for area in areas)
    open_ = [
        i
        for i in np.flatnonzero(exploration.required_step < 0).tolist()
        if not required_tried(exploration, i)
    ]
    untried = [i for i in open_ if is_connected(exploration, i)]
    astray = len(open_) - len(untried)
    effort = f"fewer than {exploration.settings.effort} directed attempts (explore.effort) were made"
    missing = []
    if short:
        missing.append(f"at {short} of {len(areas)} unreached areas {effort}")
    if untried:
        missing.append(f"at {len(untried)} required point{'s' * (len(untried) != 1)} {effort}")
    steps = steps_to_go(exploration, counts) if missing else None
    if astray:
        where = f"{astray} required point{'s' * (astray != 1)} that the nav-mesh connects to no spawn"
        missing.append(f"{where} {'were' if astray != 1 else 'was'} not reached")
    if steps:
        missing.append(f"that is likely to take {steps:,} more steps (an estimate)")
    return missing, steps


def steps_to_go(exploration: Exploration, counts: Bools) -> int | None:
    """An estimate of how many more agent steps it takes to reach the goals that count [G], or to give up on them.

    As long as goals were reached in the last third of the run, each is taken to be reached at the same chance a step
    from now on, so that the last one of k takes 1 + 1/2 + ... + 1/k times as long as one (the mean of the largest of k
    exponential variables); after that, what the directed attempts take that are still to be made. None without an idea.
    """
    s = exploration.settings
    times = exploration.goal_step[counts]
    left, late = int((times < 0).sum()), int((times > exploration.agent_steps * 2 / 3).sum())
    missed = np.flatnonzero(exploration.required_step < 0).tolist()
    tries = [attempts_at_required(exploration, i) for i in missed if is_connected(exploration, i)]
    to_reach = 0.0
    if late:
        one = left * exploration.agent_steps / 3 / late
        to_reach = one * float((1.0 / np.arange(1, left + 1)).sum())
    else:
        tries += [attempts_at(exploration, area) for area in open_areas(exploration, counts)]
    short = sum(max(0, s.effort - done) for done in tries)
    attempts = short / s.directed_at_goals * s.reset_interval if s.directed else 0.0
    most = max(to_reach, attempts)
    return int(round(most, -3 if most > 10_000 else 0)) or None
