"""The level files for published levels: valid, and explored without a hitch."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from reachtest import cli, pipeline

MAPS = Path(__file__).parents[2] / "maps" / "real"
SHARED = Path(__file__).parents[3] / "shared" / "levels"
OPEN = ("demo_level", "three_pathfinding", "tut3d", "nav_test")  # a player can walk off their edges
CLOSED = ("oa_dm1",)
STEPS = 10_000

pytestmark = pytest.mark.skipif(
    not SHARED.is_dir(), reason="the real levels are not next to the project (../shared/levels)"
)


@pytest.mark.parametrize("name", [*OPEN, *CLOSED])
def test_level_file_is_valid(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    cli.validate(MAPS / name / "level.yaml")
    told = capsys.readouterr().out
    assert "level.yaml is valid" in told
    assert name in told


@pytest.mark.parametrize("name", [*OPEN, *CLOSED])
def test_short_run(name: str, tmp_path: Path) -> None:
    """Every point that is re-simulated comes out bit for bit: anything else is an internal error."""
    options = pipeline.RunOptions(
        MAPS / name / "level.yaml", tmp_path, overrides={"explore": {"steps": STEPS, "goal_spacing_m": 4}}
    )
    report, folder = pipeline.run(pipeline.load(options), options)
    exploration, bounds = report.exploration, report.level.bounds
    positions = exploration.points.positions
    assert STEPS <= exploration.agent_steps < STEPS + exploration.settings.lanes
    assert exploration.diverged_episodes == 0
    assert len(positions) > 100
    assert exploration.points.expected[exploration.points.grounded].mean() > 0.5
    assert (exploration.goal_step >= 0).mean() > 0.02
    assert ((positions >= bounds[0]) & (positions <= bounds[1])).all()
    assert all(f.path is None or f.path.succeeded == f.path.attempts for f in report.findings)
    assert json.loads((folder / "report.json").read_text())["verdict"] == report.verdict.name
    if name in CLOSED:
        assert not exploration.falls
        assert not [f for f in report.findings if f.gating]
        assert report.verdict.exit_code in (0, 4)
    else:
        assert report.verdict.exit_code in (1, 4)
