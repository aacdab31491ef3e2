"""Ways that no nav-mesh shows: along a narrow beam, and up a row of pillars with no room for a run-up."""

from __future__ import annotations

from pathlib import Path

import pytest

from reachtest import pipeline

HIGH_M = 10.0
GAP_M, RISE_M, PILLAR_M = 2.25, 0.8, 2.5  # a jump carries 3.4 m that much higher, and 0.9 m up


def box(name: str, x: float, y: float, top: float, size_x: float, size_y: float) -> str:
    return f"  - {{name: {name}, box: {{center: [{x}, {y}, {top - 0.5}], size: [{size_x}, {size_y}, 1]}}}}\n"


def course(folder: Path, pillars: int) -> Path:
    """A platform, a beam of 0.9 m beside its middle, a landing, and pillars up to the end; the ground is far below."""
    boxes = box("ground", 0, 0, 0, 80, 60) + box("start", -25, 0, HIGH_M, 8, 8)
    boxes += box("beam", -12, 1.3, HIGH_M, 18, 0.9) + box("landing", -1, 0, HIGH_M, 4, 4)
    edge, top = 1.0, HIGH_M
    for number in range(pillars):
        top += RISE_M
        boxes += box(f"pillar{number}", edge + GAP_M + PILLAR_M / 2, 0.5, top, PILLAR_M, PILLAR_M)
        edge += GAP_M + PILLAR_M
    boxes += box("end", edge + GAP_M + 2, 0, top + RISE_M, 4, 4)
    path = folder / "level.yaml"
    path.write_text(f"""
version: 1
frame: {{up_axis: z, units: m}}
geometry:
{boxes}navmesh: {{build: {{}}}}
character: unreal
spawns: [[-25, 0, {HIGH_M + 0.02}]]
required: [{{name: end, position: [{edge + GAP_M + 2}, 0, {top + RISE_M + 0.02}]}}]
explore: {{steps: 80000}}
""")
    return path


@pytest.mark.parametrize("seed", [0, 1])
def test_somebody_gets_along_the_beam_and_up_the_pillars(tmp_path: Path, seed: int) -> None:
    """By step 41,475 to 49,670 in seeds 0 to 2; leaps were only looked for from where the nav-mesh or leaps lead."""
    options = pipeline.RunOptions(course(tmp_path, pillars=4), seed=seed, out=tmp_path / "out", threads=1)
    report, _ = pipeline.run(pipeline.load(options), options)
    assert "required_unreached" not in {finding.kind for finding in report.findings}
