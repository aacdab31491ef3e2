"""Ways that no nav-mesh shows: along a narrow beam, up pillars with no room for a run-up, over stones."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import pytest

from reachtest import pipeline

HIGH_M = 10.0
STONE_M, STONE_GAP_M = 1.2, 2.5
GAP_M, RISE_M, PILLAR_M = 2.25, 0.8, 2.5  # a jump carries 3.4 m that much higher, and 0.9 m up


def box(name: str, x: float, y: float, top: float, size_x: float, size_y: float, height: float = 1.0) -> str:
    middle = f"[{x}, {y}, {top - height / 2}]"
    return f"  - {{name: {name}, box: {{center: {middle}, size: [{size_x}, {size_y}, {height}]}}}}\n"


def write(folder: Path, boxes: str, spawn: Sequence[float], end: Sequence[float]) -> Path:
    path = folder / "level.yaml"
    path.write_text(f"""
version: 1
frame: {{up_axis: z, units: m}}
geometry:
{boxes}navmesh: {{build: {{}}}}
character: unreal
spawns: [{list(spawn)}]
required: [{{name: end, position: {list(end)}}}]
explore: {{steps: 150000}}
""")
    return path


def beam_and_pillars(folder: Path) -> Path:
    """High above the ground a platform, a beam of 0.9 m beside its middle, a landing, and four pillars to the end."""
    boxes = box("ground", 0, 0, 0, 80, 60) + box("start", -25, 0, HIGH_M, 8, 8)
    boxes += box("beam", -12, 1.3, HIGH_M, 18, 0.9) + box("landing", -1, 0, HIGH_M, 4, 4)
    edge, top = 1.0, HIGH_M
    for number in range(4):
        top += RISE_M
        boxes += box(f"pillar{number}", edge + GAP_M + PILLAR_M / 2, 0.5, top, PILLAR_M, PILLAR_M)
        edge += GAP_M + PILLAR_M
    boxes += box("end", edge + GAP_M + 2, 0, top + RISE_M, 4, 4)
    return write(folder, boxes, (-25, 0, HIGH_M + 0.02), (edge + GAP_M + 2, 0, top + RISE_M + 0.02))


def crates(folder: Path) -> Path:
    """A yard, and in it a row of crates, each a jump higher, up to a roof."""
    boxes = box("ground", 0, 0, 0, 30, 30)
    for name, x, y, size_x, size_y in (
        ("e", 15.5, 0, 1, 32),
        ("w", -15.5, 0, 1, 32),
        ("n", 0, 15.5, 32, 1),
        ("s", 0, -15.5, 32, 1),
    ):
        boxes += box(name, x, y, 12, size_x, size_y, 12)
    for number in range(1, 6):
        boxes += box(f"crate{number}", -10 + 2 * number, 5, RISE_M * number, 2, 2, RISE_M * number)
    boxes += box("roof", 5, 5, 6 * RISE_M, 8, 8)
    return write(folder, boxes, (0, -5, 0.02), (5, 5, 6 * RISE_M + 0.02))


def stones(folder: Path) -> Path:
    """High above the ground, stones too small for the nav-mesh, one after the other."""
    boxes, edge = box("ground", 0, 0, 0, 80, 40) + box("start", -20, 0, HIGH_M, 6, 6), -17.0
    for number, aside in enumerate((0.0, 0.8, -0.2, -0.8)):
        boxes += box(f"stone{number}", edge + STONE_GAP_M + STONE_M / 2, aside, HIGH_M, STONE_M, STONE_M)
        edge += STONE_GAP_M + STONE_M
    boxes += box("end", edge + STONE_GAP_M + 2, 0, HIGH_M, 4, 4)
    return write(folder, boxes, (-20, 0, HIGH_M + 0.02), (edge + STONE_GAP_M + 2, 0, HIGH_M + 0.02))


@pytest.mark.parametrize("seed", [0, 1])
@pytest.mark.parametrize("course", [beam_and_pillars, crates, stones])
def test_somebody_gets_to_the_end(tmp_path: Path, course: Callable[[Path], Path], seed: int) -> None:
    """By step 25,229 to 70,026 in seeds 0 and 1 of the three."""
    options = pipeline.RunOptions(course(tmp_path), seed=seed, out=tmp_path / "out", threads=1)
    report, _ = pipeline.run(pipeline.load(options), options)
    assert "required_unreached" not in {finding.kind for finding in report.findings}
