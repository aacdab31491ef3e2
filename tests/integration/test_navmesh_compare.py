"""A walled hall whose nav-mesh leads through everything: what bars the way decides what the run says."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
import yaml

from tests.integration.test_cli import reachtest

HALL = "v -9.5 -1.5 0\nv 9.5 -1.5 0\nv 9.5 1.5 0\nv -9.5 1.5 0\nf 1 2 3\nf 1 3 4\n"
SHELF = "v -9.5 1.6 3\nv 9.5 1.6 3\nv 9.5 1.9 3\nv -9.5 1.9 3\nf 5 6 7\nf 5 7 8\n"


def hall(folder: Path, barrier: tuple[float, float]) -> Path:
    """20 x 4 m, with a barrier across it from one height to another, and a shelf nobody gets onto."""
    boxes = [
        ([0, 0, -0.5], [20, 4, 1]),
        ([0, 2.5, 2], [22, 1, 4]),
        ([0, -2.5, 2], [22, 1, 4]),
        ([-10.5, 0, 2], [1, 4, 4]),
        ([10.5, 0, 2], [1, 4, 4]),
        ([1, 0, sum(barrier) / 2], [2, 4, barrier[1] - barrier[0]]),
    ]
    level = {
        "version": 1,
        "name": "hall",
        "frame": {"up_axis": "z", "units": "m"},
        "geometry": [{"box": {"center": center, "size": size}} for center, size in boxes],
        "navmesh": {"mesh": "nav.obj", "up_axis": "z", "units": "m"},
        "character": "unreal",
        "spawns": [{"name": "start", "position": [-5, 0, 0.02]}],
        "explore": {"steps": 8000, "goal_spacing_m": 2},
    }
    folder.mkdir()
    (folder / "nav.obj").write_text(HALL + SHELF)
    (folder / "level.yaml").write_text(yaml.safe_dump(level))
    return folder / "level.yaml"


def report_of(level: Path, *options: str) -> dict[str, Any]:
    done = reachtest("run", level, "--json", "--quiet", "--out", level.parent / "out", *options)
    report = json.loads(done.stdout)
    assert done.returncode == report["exit_code"]
    return dict(report)


def kinds(report: dict[str, Any]) -> list[str]:
    return sorted(finding["kind"] for finding in report["findings"])


def test_a_beam_too_low_is_one_mismatch_and_no_failure(tmp_path: Path) -> None:
    report = report_of(hall(tmp_path / "hall", (1.5, 4.0)), "--audit")
    assert kinds(report) == ["navmesh_mismatch", "unreached_area"]
    mismatch, shelf = report["findings"]
    assert "1.50 m, it needs 1.76 m" in mismatch["title"]
    assert shelf["title"].startswith("1 island of the nav-mesh (6 m2) is not connected to any spawn")
    coverage = report["coverage"]
    assert coverage["goals_unreached_by_mismatch"] > 0
    assert coverage["goals_connected"] < coverage["goals_total"]
    assert (coverage["islands"], coverage["islands_connected"]) == (2, 1)
    assert report["exit_code"] == 0
    assert report["audit"] == []


@pytest.mark.parametrize("barrier", [(0.0, 4.0), (0.0, 1.3)])
def test_a_wall_or_a_crate_across_the_way_is_no_mismatch_and_no_pass(tmp_path: Path, barrier) -> None:
    report = report_of(hall(tmp_path / "hall", barrier))
    assert kinds(report) == ["unreached_area", "unreached_area"]
    assert report["coverage"]["goals_unreached_by_mismatch"] == 0
    assert report["exit_code"] in (1, 4)  # by the effort that was made
    assert "audit" not in report
