"""What a run leaves behind: every output tells the same, nothing else is left, and bad places are told at once."""

from __future__ import annotations

import json
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory

from reachtest import pipeline
from reachtest.explore import Explorer, Replayer
from reachtest.surface import SurfaceIndex
from reachtest.world import MujocoSimulator
from tests.integration.test_cli import FILES, reachtest, yard

EDGE_M = 7.0  # where the open yard ends
JUMP_M = 5.14  # what the character's jump carries


@pytest.fixture(scope="module")
def open_run(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Any]:
    """The folder of a run of the open yard, and the process that made it."""
    folder = tmp_path_factory.mktemp("outputs")
    done = reachtest("run", yard(folder / "yard", closed=False), "--json", "--quiet", "--out", folder / "out")
    return folder / "out", done


def decoded(path: Path, topic: str) -> list[Any]:
    with path.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True, decoder_factories=[DecoderFactory()])
        return [item.decoded_message for item in reader.iter_decoded_messages(topics=[topic])]


def test_stdout_is_the_report_and_stderr_is_silent_if_asked(open_run) -> None:
    folder, done = open_run
    assert done.stderr == ""
    assert json.loads(done.stdout) == json.loads((folder / "report.json").read_text())
    assert done.returncode == json.loads(done.stdout)["exit_code"] == 1


def test_log_holds_the_findings_and_every_discovered_point(open_run) -> None:
    folder, done = open_run
    report = json.loads(done.stdout)
    log = folder / "run.mcap"
    entities = [entity for update in decoded(log, "/findings") for entity in update.entities]
    assert report["findings"]
    assert {entity.id for entity in entities} >= {finding["id"] for finding in report["findings"]}
    texts = {text.text for entity in entities for text in entity.texts}
    assert texts >= {finding["title"] for finding in report["findings"]}
    clouds = decoded(log, "/coverage")
    told = sum(len(cloud.data) // cloud.point_stride for cloud in clouds)
    assert told == report["positions"]["discovered"]


def test_junit_and_summary_agree_with_the_report(open_run) -> None:
    folder, done = open_run
    gating = [finding for finding in json.loads(done.stdout)["findings"] if finding["gating"]]
    failures = ET.parse(folder / "junit.xml").getroot().findall(".//failure")
    assert len(failures) == len(gating) > 0
    summary = (folder / "summary.md").read_text(encoding="utf-8")
    for finding in gating:
        assert finding["title"] in summary
        assert ", ".join(f"{x:.2f}" for x in finding["source_position"]) in summary


def test_a_second_run_into_the_same_folder_replaces_the_first(open_run, tmp_path) -> None:
    file = yard(tmp_path / "yard", closed=True)
    for steps in (600, 300):
        reachtest("run", file, "--steps", steps, "--out", tmp_path / "out", "--quiet")
        assert {path.name for path in (tmp_path / "out").iterdir()} == FILES
        assert (
            json.loads((tmp_path / "out" / "report.json").read_text())["config"]["explore"]["steps"] == steps
        )


def test_default_folder_is_named_after_the_level(tmp_path) -> None:
    file = yard(tmp_path / "elsewhere", closed=True)
    done = reachtest("run", file, "--steps", 64, cwd=tmp_path)
    assert {path.name for path in (tmp_path / "reachtest-out" / "yard").iterdir()} == FILES
    assert "reachtest-out/yard" in done.stdout


@pytest.mark.parametrize("out", ["taken", "taken/below"])
def test_an_output_folder_that_cannot_be_made_is_bad_usage(tmp_path, out) -> None:
    (tmp_path / "taken").write_text("a file")
    file = yard(tmp_path / "yard", closed=True)
    done = reachtest("run", file, "--steps", 64, "--out", tmp_path / out, "--quiet")
    assert done.returncode == 2
    assert "taken" in done.stderr
    assert "Traceback" not in done.stderr


def test_options_from_the_command_line_are_told_as_such(tmp_path) -> None:
    file = yard(tmp_path / "yard", closed=True)
    done = reachtest("run", file, "--time-budget", "soon", "--agents", "99999", "--fail-on", "colour")
    assert done.returncode == 2
    for fact in ("time_budget", "soon", "agents", "99999", "fail_on", "colour", "command line"):
        assert fact in done.stderr


def test_a_time_budget_ends_the_run(tmp_path) -> None:
    file = yard(tmp_path / "yard", closed=True)
    done = reachtest(
        "run", file, "--steps", 10**9, "--time-budget", "1s", "--out", tmp_path / "out", "--json"
    )
    report = json.loads(done.stdout)
    assert report["stop_reason"] == "time"
    assert 0 < report["run"]["agent_steps"] < 10**9
    assert report["timing"]["wall_s"] < 5


def test_walls_between_the_player_and_the_void_hold(tmp_path) -> None:
    """More steps and another seed than the other tests: nobody gets out of a closed yard."""
    file = yard(tmp_path / "yard", closed=True)
    done = reachtest(
        "run", file, "--steps", 20_000, "--seed", 5, "--out", tmp_path / "out", "--json", "--quiet"
    )
    report = json.loads(done.stdout)
    assert (report["verdict"], report["exit_code"], report["findings"]) == ("pass", 0, [])
    assert report["positions"]["unexpected"] == 0
    assert report["coverage"]["goals_reached_fraction"] == 1


@pytest.mark.parametrize(
    "numbers",
    ["walk_speed_mps: 20, acceleration_mps2: 200", "radius_m: 0.1, height_m: 0.5"],
    ids=["fast", "thin"],
)
def test_a_character_too_fast_for_its_size_is_refused_or_stopped_by_walls(tmp_path, numbers) -> None:
    """Whoever moves further in a physics step than the capsule is wide could pass a wall: no bug of the level."""
    file = yard(tmp_path / "yard", closed=True)
    file.write_text(
        file.read_text().replace("character: unreal", f"character: {{preset: unreal, {numbers}}}")
    )
    done = reachtest("run", file, "--out", tmp_path / "out", "--quiet")
    assert done.returncode in (0, 2, 4), done.stdout


@pytest.mark.parametrize("seed", [0, 1])
def test_who_falls_stood_within_a_jump_of_the_edge(tmp_path, seed) -> None:
    """Holding the jump button the character touches the ground for a single tick at a time: that is standing too."""
    options = pipeline.RunOptions(yard(tmp_path / "yard", closed=False), seed=seed)
    level = pipeline.load(options)
    simulator = MujocoSimulator(level, level.explore.lanes, 1)
    surface = SurfaceIndex(level.navmesh.triangles, level.explore.expected_within_m)
    result = Explorer(level, simulator, surface, seed).run()
    Replayer(level, simulator, result.points, seed, result.headings).check()
    assert len(result.falls) > 20
    away = np.array([EDGE_M - fall.footing[0] for fall in result.falls])
    assert away.max() < JUMP_M + 0.8, f"{(away > JUMP_M + 0.8).sum()} of {len(away)}"
