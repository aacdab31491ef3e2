"""The command line as a build uses it: files, exit statuses, streams."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from reachtest import pipeline
from reachtest.signals import StopOnSignal

COMMAND = [sys.executable, "-m", "reachtest"]
FILES = {"report.json", "summary.md", "junit.xml", "coverage.json", "run.mcap", "state"}


def reachtest(*arguments: object, cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [*COMMAND, *map(str, arguments)], capture_output=True, text=True, timeout=120, cwd=cwd
    )


NAV = "v -5.5 0 -5.5\nv 5.5 0 -5.5\nv 5.5 0 5.5\nv -5.5 0 5.5\nf 1 3 2\nf 1 4 3\n"
WALLS = [([0, 1, -6.5], [14, 4, 1]), ([0, 1, 6.5], [14, 4, 1]), ([-6.5, 1, 0], [1, 4, 14])]
EAST = ([6.5, 1, 0], [1, 4, 14])


def yard(folder: Path, closed: bool, extra: str = "") -> Path:
    """A yard of 12 m, y up, walled in on all sides or on three."""
    folder.mkdir(exist_ok=True)
    (folder / "nav.obj").write_text(NAV)
    boxes = [*WALLS, EAST] if closed else WALLS
    lines = [f"  - {{name: wall {i}, box: {{center: {c}, size: {s}}}}}" for i, (c, s) in enumerate(boxes)]
    file = folder / "level.yaml"
    file.write_text(
        "version: 1\nname: yard\nframe: {up_axis: y, units: m}\ngeometry:\n"
        "  - {name: floor, box: {center: [0, -0.5, 0], size: [14, 1, 14]}}\n"
        + "\n".join(lines)
        + "\nnavmesh: {mesh: nav.obj}\ncharacter: unreal\nspawns: [[0, 0.02, 0]]\n"
        + "explore: {steps: 12000, goal_spacing_m: 3}\n"
        + extra
    )
    return file


@pytest.fixture(scope="module")
def open_yard(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return yard(tmp_path_factory.mktemp("open") / "yard", closed=False)


@pytest.fixture(scope="module")
def closed_yard(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return yard(tmp_path_factory.mktemp("closed") / "yard", closed=True)


def test_an_open_edge_fails_the_build_and_is_reported(open_yard, tmp_path) -> None:
    done = reachtest("run", open_yard, "--out", tmp_path)
    assert done.returncode == 1, done.stderr
    assert {p.name for p in tmp_path.iterdir()} == FILES
    report = json.loads((tmp_path / "report.json").read_text())
    assert (report["verdict"], report["exit_code"]) == ("fail", 1)
    gating = [f for f in report["findings"] if f["gating"]]
    assert [f["kind"] for f in gating] == ["fell_out_of_world"]
    x, y, _ = gating[0]["source_position"]  # the level's axes: y up
    assert x > 6
    assert abs(y) < 0.5
    assert gating[0]["reproduced"] == {"attempts": 1, "succeeded": 1}
    assert gating[0]["exit_point"] is not None
    assert gating[0]["path"]["duration_s"] > 0
    assert "falls out of the world" in done.stdout
    assert set(report["timing"]) >= {"started_at", "wall_s", "agent_steps_per_s", "physics_s", "cache_s"}


def test_a_closed_yard_passes_and_an_unexplored_one_is_inconclusive(closed_yard, tmp_path) -> None:
    done = reachtest("run", closed_yard, "--out", tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr
    assert reachtest("run", closed_yard, "--out", tmp_path, "--steps", 64).returncode == 4


def test_json_is_all_of_stdout_and_threads_change_nothing(open_yard, tmp_path) -> None:
    reports = []
    for threads in (1, 2):
        done = reachtest("run", open_yard, "--json", "--threads", threads, "--out", tmp_path / str(threads))
        reports.append(json.loads(done.stdout))
        del reports[-1]["timing"]
    assert reports[0] == reports[1]
    assert reports[0]["config"]["explore"]["steps"] == 12000
    other = json.loads(reachtest("run", open_yard, "--json", "--seed", 1, "--out", tmp_path / "3").stdout)
    assert other["positions"] != reports[0]["positions"] or other["findings"] != reports[0]["findings"]


def test_fail_on_chooses_what_gates(open_yard, tmp_path) -> None:
    done = reachtest("run", open_yard, "--fail-on", "inside_solid, forbidden_zone", "--out", tmp_path)
    assert done.returncode in (0, 4)
    done = reachtest("run", open_yard, "--fail-on", "typo", "--out", tmp_path)
    assert done.returncode == 2
    assert "typo" in done.stderr


def test_a_configuration_goes_over_the_level(open_yard, tmp_path) -> None:
    file = tmp_path / "gate.yaml"
    file.write_text("explore: {steps: 256}\ngate: {fail_on: []}\n")
    assert reachtest("validate", open_yard, "--config", file).returncode == 0
    done = reachtest("run", open_yard, "--config", file, "--json", "--out", tmp_path / "out")
    assert done.returncode == 4
    config = json.loads(done.stdout)["config"]
    assert (config["explore"]["steps"], config["gate"]["fail_on"]) == (256, [])
    file.write_text("explore: {heuristics: {vizits: 1}}\n")
    for command in ("run", "validate"):
        done = reachtest(command, open_yard, "--config", file)
        assert done.returncode == 2
        assert "level.yaml under gate.yaml: explore.heuristics" in done.stderr


@pytest.mark.parametrize(("number", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_signal_ends_the_run_with_what_was_found(closed_yard, tmp_path, number, status) -> None:
    arguments = ["run", str(closed_yard), "--steps", "50000000", "--out", str(tmp_path)]
    process = subprocess.Popen(
        [*COMMAND, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    deadline = time.monotonic() + 60
    part = tmp_path / ".run.mcap.part"
    while time.monotonic() < deadline and not (part.exists() and part.stat().st_size > 2_000):
        time.sleep(0.1)
    os.kill(process.pid, number)
    _, stderr = process.communicate(timeout=60)
    assert process.returncode == status, stderr
    assert {p.name for p in tmp_path.iterdir()} == FILES
    assert json.loads((tmp_path / "report.json").read_text())["exit_code"] == status


@pytest.mark.parametrize(("number", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_signal_while_confirming_leaves_the_rest_unconfirmed(open_yard, tmp_path, number, status) -> None:
    phases: list[str] = []

    def tell(what: str, *_: int) -> None:
        if what == "confirming findings" and what not in phases:
            os.kill(os.getpid(), number)
        phases.append(what)

    options = pipeline.RunOptions(open_yard, tmp_path)
    with StopOnSignal() as interrupted:
        report, _ = pipeline.run(pipeline.load(options), options, [], interrupted, tell)
    assert report.verdict.exit_code == status
    assert {p.name for p in tmp_path.iterdir()} == FILES
    written = json.loads((tmp_path / "report.json").read_text())
    (finding,) = (f for f in written["findings"] if f["kind"] == "fell_out_of_world")
    assert finding["gating"]
    assert finding["confirmation"] is None
    assert written["stop_reason"] == report.exploration.stop_reason.name.lower()
    assert "unconfirmed" in (tmp_path / "summary.md").read_text()


def test_an_empty_fail_on_does_not_open_the_gate(open_yard, tmp_path) -> None:
    for empty in ("", " , "):
        done = reachtest("run", open_yard, "--out", tmp_path, "--fail-on", empty)
        assert done.returncode == 2
        assert "--fail-on\n    is empty" in done.stderr
    assert reachtest("run", open_yard, "--out", tmp_path, "--quiet", "--fail-on", "none").returncode == 0


def test_who_reads_the_first_line_only_does_not_change_the_exit_status(closed_yard, tmp_path) -> None:
    arguments = ["run", closed_yard, "--out", tmp_path, "--quiet", "--steps", "40000"]
    with subprocess.Popen([*COMMAND, *map(str, arguments)], stdout=subprocess.PIPE) as process:
        assert process.stdout is not None
        process.stdout.close()  # before anything is written
        assert process.wait(60) == 0


@pytest.mark.parametrize("unbuffered", ["", "1"])
def test_a_full_disk_is_a_message(closed_yard, tmp_path, unbuffered: str) -> None:
    full = Path("/dev/full")
    if not full.exists():
        pytest.skip("the system has no /dev/full")
    arguments = ["run", closed_yard, "--out", tmp_path, "--quiet", "--steps", "2000"]
    with full.open("w") as stdout:
        done = subprocess.run(
            [*COMMAND, *map(str, arguments)],
            stdout=stdout,
            stderr=subprocess.PIPE,
            text=True,
            timeout=60,
            env=os.environ | {"PYTHONUNBUFFERED": unbuffered},
        )
    assert done.returncode == 2
    assert "No space left" in done.stderr
    assert "Traceback" not in done.stderr


def test_all_mistakes_come_at_once_and_nothing_is_run(tmp_path) -> None:
    file = yard(tmp_path / "yard", closed=True, extra="colour: blue\n")
    text = file.read_text().replace("nav.obj", "nov.obj").replace("character: unreal", "character: unrael")
    file.write_text(text)
    done = reachtest("run", file, "--out", tmp_path / "out")
    assert done.returncode == 2
    for fact in ("nov.obj", "nav.obj", "unrael", "unreal", "colour"):
        assert fact in done.stderr
    assert not (tmp_path / "out").exists()


def test_unknown_heuristics_are_bad_input(tmp_path) -> None:
    file = yard(tmp_path / "yard", closed=True)
    file.write_text(
        file.read_text().replace("goal_spacing_m: 3", "goal_spacing_m: 3, heuristics: {viists: 1}")
    )
    for command in (["run", file, "--out", tmp_path / "out"], ["validate", file]):
        done = reachtest(*command)
        assert done.returncode == 2
        assert "viists" in done.stderr
        assert "visits" in done.stderr


def test_validate_says_what_it_understood(closed_yard, tmp_path) -> None:
    done = reachtest("validate", closed_yard)
    assert done.returncode == 0, done.stderr
    assert "60" in done.stdout  # triangles of five boxes
    assert reachtest("validate", tmp_path / "nowhere.yaml").returncode == 2


def test_schema_is_json_schema() -> None:
    schema = json.loads(reachtest("schema").stdout)
    assert "geometry" in schema["properties"]


def test_usage_errors_are_status_2() -> None:
    assert reachtest("run").returncode == 2
    assert reachtest("run", "x.yaml", "--seed", "minus one").returncode == 2


def test_help_answers_within_a_second() -> None:
    def once() -> float:
        began = time.monotonic()
        assert reachtest("run", "--help").returncode == 0
        return time.monotonic() - began

    assert sorted(once() for _ in range(3))[0] < 1.0


def test_bench_speed_is_one_json_object_with_the_promised_keys(closed_yard) -> None:
    done = reachtest("bench", "speed", closed_yard, "--steps", 4096, "--json")
    assert done.returncode == 0, done.stderr
    figures = json.loads(done.stdout)
    promised = (
        "agent_steps_per_s physics_steps_per_s_per_core bare_physics_agent_steps_per_s explorer_over_physics"
        " cache_us_per_step bytes_per_point peak_rss_mb first_step_s characters_agent_steps_per_s"
    )
    assert set(promised.split()) <= set(figures)
    assert all(figures[key] > 0 for key in promised.split())
    ratio = figures["agent_steps_per_s"] / figures["bare_physics_agent_steps_per_s"]
    assert abs(figures["explorer_over_physics"] - ratio) < 1e-9
    assert figures["bytes_per_point"] <= 100
    table = reachtest("bench", "speed", closed_yard, "--steps", 4096)
    assert all(key in table.stdout for key in promised.split())


def test_bench_speed_of_a_level_with_mistakes_says_so(tmp_path) -> None:
    (tmp_path / "level.yaml").write_text("version: 1\n")
    done = reachtest("bench", "speed", tmp_path / "level.yaml")
    assert done.returncode == 2
    assert "problems in the input" in done.stderr
