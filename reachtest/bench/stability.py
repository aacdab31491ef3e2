"""Whether seeds agree: the verdict, and the findings matched by place."""

from __future__ import annotations

import dataclasses
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import nullcontext
from dataclasses import dataclass
from functools import partial, reduce
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np

from reachtest import pipeline
from reachtest.baseline.place import CLOSE_M, Place, gap_m, match
from reachtest.bench.truth import PlantedBug, planted_bugs
from reachtest.records import Finding, Floats


@dataclass(frozen=True)
class Bug:
    """One bug, seen in some of the seeds."""

    kind: str
    title: str
    gating: bool
    position: tuple[float, float, float]  # where the first seed saw it, in the level's own axes and units
    seeds: tuple[int, ...]


@dataclass(frozen=True)
class Stability:
    """What the seeds of one level came to."""

    level: str
    seeds: int
    steps: int
    verdicts: tuple[str, ...]  # seed by seed
    bugs: tuple[Bug, ...]  # most often seen first
    planted: dict[str, tuple[int, ...]]  # name of a planted bug: the seeds that found it
    wall_s: float

    @property
    def agreed(self) -> bool:
        """Whether every seed gave the same verdict."""
        return len(set(self.verdicts)) <= 1


def measure_stability(
    path: Path,
    seeds: int,
    steps: int | None = None,
    jobs: int = 1,
    told: Callable[[str], None] = lambda line: None,
) -> Stability:
    """Run the level at `path` with seeds 0 to `seeds` - 1, `jobs` at a time. Raises BadInput."""
    began = time.perf_counter()
    level = pipeline.load(_options(path, 0, steps))
    run = partial(_run, path, steps, threads=0 if jobs == 1 else 1)
    verdicts: list[str] = []
    found: list[tuple[Finding, ...]] = []
    with ProcessPoolExecutor(jobs, get_context("spawn")) if jobs > 1 else nullcontext() as pool:
        for seed, (verdict, findings) in enumerate(
            pool.map(run, range(seeds)) if pool else map(run, range(seeds))
        ):
            verdicts.append(verdict)
            found.append(findings)
            kinds = ", ".join(f"{n} {kind}" for kind, n in Counter(f.kind for f in findings).items())
            told(f"{level.name} seed {seed}: {verdict}; {kinds or 'no findings'}")
    wanted = {bug.name: _seeds_with(bug, found) for bug in planted_bugs(path, level.frame)}
    bugs = same_bugs(found, level.frame.to_source)
    name = level.name if path.stem == "level" else f"{level.name} ({path.stem})"
    wall_s = time.perf_counter() - began
    return Stability(name, seeds, level.explore.steps, tuple(verdicts), bugs, wanted, wall_s)


def _options(path: Path, seed: int, steps: int | None, threads: int = 0) -> pipeline.RunOptions:
    options = pipeline.RunOptions(path, seed=seed, threads=threads)
    return pipeline.with_overrides(options, explore={"steps": steps})


def _run(path: Path, steps: int | None, seed: int, threads: int) -> tuple[str, tuple[Finding, ...]]:
    """The verdict and the findings of one seed."""
    options = _options(path, seed, steps, threads)
    with tempfile.TemporaryDirectory(prefix="reachtest-") as folder:
        report, _ = pipeline.run(pipeline.load(options), dataclasses.replace(options, out=Path(folder)))
    return report.verdict.name, report.findings


def same_bugs(found: Sequence[Sequence[Finding]], to_source: Callable[[Floats], Floats]) -> tuple[Bug, ...]:
    """The findings of each seed, matched by place: every bug, and which seeds saw it.

    A bug is where any seed saw it. Seeds fall off one rim at different places: they agree as soon as the places of all
    of them together are as close as those of one bug in one run are.
    """
    seen: list[_Seen] = []
    for seed, findings in enumerate(found):
        places = [Place.of(finding) for finding in findings]
        known = match(places, [bug.place for bug in seen])
        for finding, place, which in zip(findings, places, known, strict=True):
            mine = _Seen(finding, place, frozenset({seed}))
            if which is None:
                seen.append(mine)
            else:
                seen[which] = seen[which].joined(mine)
    bugs = [bug.told(to_source) for bug in _joined(seen)]
    return tuple(sorted(bugs, key=lambda bug: (-len(bug.seeds), not bug.gating)))


@dataclass(frozen=True, eq=False)
class _Seen:
    """A bug while seeds are gone through."""

    first: Finding
    place: Place  # all the places where it was seen
    seeds: frozenset[int]

    def joined(self, other: _Seen) -> _Seen:
        return _Seen(self.first, self.place.joined(other.place), self.seeds | other.seeds)

    def told(self, to_source: Callable[[Floats], Floats]) -> Bug:
        one = self.first
        return Bug(
            one.kind, one.title, one.gating, _point(to_source(one.position)), tuple(sorted(self.seeds))
        )


def _joined(seen: Sequence[_Seen]) -> list[_Seen]:
    """Without two that turned out to be one when more seeds were seen."""
    apart: list[_Seen] = []
    for bug in seen:
        same = [other for other in apart if gap_m(bug.place, other.place) <= CLOSE_M]
        apart = [other for other in apart if other not in same] + [reduce(_Seen.joined, [*same, bug])]
    return apart


def _seeds_with(bug: PlantedBug, found: Sequence[Sequence[Finding]]) -> tuple[int, ...]:
    return tuple(seed for seed, findings in enumerate(found) if any(bug.is_told_by(f) for f in findings))


def _point(values: Floats) -> tuple[float, float, float]:
    x, y, z = np.round(values, 1).tolist()
    return x, y, z


def as_markdown(results: Sequence[Stability]) -> str:
    """A row for each level, and below it each bug's share of the seeds."""
    lines = ["| level | verdicts | findings in all seeds | in some | planted bugs found | s |"]
    lines += ["|---|---|---:|---|---|---:|"]
    for result in results:
        n = result.seeds
        verdicts = ", ".join(f"{name} {c} of {n}" for name, c in Counter(result.verdicts).most_common())
        always = sum(len(bug.seeds) == n for bug in result.bugs)
        some = ", ".join(f"{bug.kind} {len(bug.seeds)}" for bug in result.bugs if len(bug.seeds) < n)
        planted = ", ".join(f"{len(seeds)} of {n}" for seeds in result.planted.values())
        row = f"| {result.level} | {verdicts} | {always} | {some or '-'} | {planted or '-'}"
        lines.append(f"{row} | {result.wall_s:,.0f} |")
    for result in results:
        lines += ["", f"{result.level}, {result.steps:,} steps:"]
        lines += [f"- planted '{name}': {len(s)} of {result.seeds}" for name, s in result.planted.items()]
        lines += [
            f"- {len(bug.seeds)} of {result.seeds}: {bug.kind} at {list(bug.position)}"
            f"{' (gates)' if bug.gating else ''}: {bug.title}"
            for bug in result.bugs
        ]
    return "\n".join(lines)


def as_data(results: Sequence[Stability]) -> list[dict[str, Any]]:
    """The same as plain JSON types."""
    return [{**dataclasses.asdict(result), "agreed": result.agreed} for result in results]
