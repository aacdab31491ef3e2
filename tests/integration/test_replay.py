"""`reachtest replay`: what was found comes about again, and what changed since is told."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader

from tests.integration.test_cli import COMMAND, EAST, reachtest, yard


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with an open yard and the output of its run."""
    folder = tmp_path_factory.mktemp("replay")
    done = reachtest("run", yard(folder / "yard", closed=False), "--quiet", "--out", folder / "out")
    assert done.returncode == 1, done.stderr
    return folder


@pytest.fixture
def folder(made: Path, tmp_path: Path) -> Path:
    """A copy of it to change."""
    shutil.copytree(made / "yard", tmp_path / "yard")
    shutil.copytree(made / "out", tmp_path / "out")
    return tmp_path


def replay(folder: Path, *arguments: object, level: bool = True) -> subprocess.CompletedProcess[str]:
    where = ["--level", folder / "yard" / "level.yaml"] if level else []
    return reachtest("replay", folder / "out", *arguments, *where)


def the_finding(folder: Path) -> dict[str, object]:
    report = json.loads((folder / "out" / "report.json").read_text())
    (finding,) = [f for f in report["findings"] if f["gating"]]
    return finding


def test_every_finding_comes_about_again_bit_for_bit(made) -> None:
    done = replay(made, level=False)  # the run's own level
    assert done.returncode == 0, done.stdout + done.stderr
    (line,) = [line for line in done.stdout.splitlines() if the_finding(made)["id"] in line]
    assert line.startswith("pass")
    assert "bit for bit" in line


def test_the_report_says_how_often_it_came_about(made) -> None:
    finding = the_finding(made)
    assert finding["fragile"] is False
    told = finding["confirmation"]
    assert set(told) == {"exact", "half_step", "nearby"}
    assert told["exact"]["succeeded"] == told["exact"]["attempts"] > 0
    assert 0 < told["half_step"]["succeeded"] <= told["half_step"]["attempts"]
    assert finding["path"]["duration_s"] <= finding["path"]["found_duration_s"]
    assert "half the time step" in (made / "out" / "summary.md").read_text(encoding="utf-8")


def test_the_way_is_written_in_the_levels_own_axes(made, tmp_path) -> None:
    target = tmp_path / "way.pts"
    done = replay(made, the_finding(made)["id"], "--path", target)
    assert done.returncode == 0, done.stderr
    way = np.array([[float(x) for x in line.split(" ")] for line in target.read_text().splitlines()])
    assert way.shape == (the_finding(made)["path"]["agent_steps"] + 1, 3)
    np.testing.assert_allclose(way[0], [0, 0.02, 0], atol=1e-6)  # the spawn, y up
    assert way[-1, 1] < -9  # below
    assert way[:, 0].max() > 6.5  # past the open edge
    assert {path.name for path in tmp_path.iterdir()} == {"way.pts"}


def test_the_way_is_written_as_a_recording(made, tmp_path) -> None:
    target = tmp_path / "way.mcap"
    assert replay(made, "fell", "--mcap", target).returncode == 0
    with target.open("rb") as stream:
        summary = make_reader(stream, validate_crcs=True).get_summary()
    counts = {
        channel.topic: summary.statistics.channel_message_counts[i] for i, channel in summary.channels.items()
    }
    assert counts["/agents"] == the_finding(made)["path"]["agent_steps"] + 1  # and the start
    assert counts["/findings"] == counts["/level"] == 1


def test_a_fixed_level_says_so_and_what_changed(folder) -> None:
    file = folder / "yard" / "level.yaml"
    centre, size = EAST
    wall = f"  - {{name: wall 3, box: {{center: {centre}, size: {size}}}}}\nnavmesh:"
    file.write_text(file.read_text().replace("navmesh:", wall))
    done = replay(folder)
    assert done.returncode == 1, done.stderr
    assert "level.yaml has changed" in done.stdout
    assert "geometry 'wall 3' is new" in done.stdout
    assert "nav" not in done.stdout
    assert "not there any more" in done.stdout
    assert "FAIL" in done.stdout


def test_a_level_that_changed_elsewhere_still_has_the_bug(folder) -> None:
    nav = folder / "yard" / "nav.obj"
    nav.write_text("# exported again\n" + nav.read_text())
    file = folder / "yard" / "level.yaml"
    file.write_text(file.read_text().replace("[14, 1, 14]", "[14.3, 1, 14]"))  # the floor is 15 cm longer
    done = replay(folder)
    assert done.returncode == 0, done.stdout + done.stderr
    for fact in (
        "level.yaml has changed",
        "nav.obj has changed",
        "geometry 'floor' has changed",
        "still there",
    ):
        assert fact in done.stdout
    assert "the nav-mesh has changed" not in done.stdout  # it says the same as before


def test_the_replay_of_another_level_is_bad_input(folder) -> None:
    file = folder / "yard" / "level.yaml"
    file.write_text(file.read_text().replace("name: yard", "name: court"))
    done = replay(folder)
    assert done.returncode == 2
    assert "court" in done.stderr
    assert "yard" in done.stderr


def test_a_folder_mixed_from_two_builds_is_bad_input(folder) -> None:
    report = folder / "out" / "report.json"
    document = json.loads(report.read_text())
    document["level"]["sha256"] = "0" * 64
    report.write_text(json.dumps(document))
    done = replay(folder)
    assert done.returncode == 2
    assert "another build" in done.stderr


def test_what_cannot_be_replayed_is_bad_input(folder, tmp_path) -> None:
    assert "belly" in replay(folder, "belly").stderr
    assert replay(folder, "belly").returncode == 2
    state = folder / "out" / "state" / "findings.npz"
    state.write_bytes(state.read_bytes()[:500])
    done = replay(folder)
    assert done.returncode == 2
    assert str(state) in done.stderr
    shutil.rmtree(folder / "out" / "state")
    assert replay(folder).returncode == 2


def test_a_finding_without_a_path_is_not_said_to_have_come_about(folder) -> None:
    state = folder / "out" / "state" / "findings.npz"
    with np.load(state) as stored:
        arrays = {name: stored[name] for name in stored.files}
    meta = json.loads(arrays["meta"].tobytes())
    meta["findings"] = [finding | {"arrays": None} for finding in meta["findings"]]
    arrays["meta"] = np.frombuffer(json.dumps(meta).encode(), dtype=np.uint8)
    np.savez(state, **arrays)
    done = replay(folder)
    assert done.returncode == 4, done.stderr
    assert f"cannot be told without a run: reachtest run {folder / 'yard' / 'level.yaml'}" in done.stdout
    assert "0 of " in done.stdout
    assert "pass" not in done.stdout


def test_a_level_that_moved_away_is_asked_for(folder) -> None:
    shutil.move(folder / "yard", folder / "court")
    text = (folder / "out" / "state" / "findings.npz").read_bytes()
    assert text
    shutil.copytree(folder / "out", folder / "elsewhere" / "out")
    done = reachtest("replay", folder / "elsewhere" / "out", "--level", folder / "court" / "level.yaml")
    assert done.returncode == 0, done.stderr


def test_a_film_needs_opengl_and_says_what_to_install(made, tmp_path) -> None:
    target = tmp_path / "way.gif"
    command = [*COMMAND, "replay", str(made / "out"), "--video", str(target)]
    done = subprocess.run(
        command, capture_output=True, text=True, timeout=120, env=os.environ | {"MUJOCO_GL": "nothing"}
    )
    assert done.returncode == 2
    assert "libosmesa6" in done.stderr
    assert "MUJOCO_GL" in done.stderr
    assert not done.stdout  # before anything was simulated
    assert not list(tmp_path.iterdir())


def test_a_film_that_cannot_be_encoded_is_said_before_anything_is_simulated(made, tmp_path) -> None:
    done = replay(made, "--video", tmp_path / "way.avi")
    assert (done.returncode, done.stdout) == (2, "")
    assert ".mp4 or .gif" in done.stderr


@pytest.mark.parametrize("option", ["--path", "--mcap", "--video"])
def test_a_place_that_cannot_be_written_is_said_before_anything_is_simulated(made, tmp_path, option) -> None:
    file = tmp_path / "file"
    file.touch()
    for target in (file / "way.gif", file / "more" / "way.gif", tmp_path):
        done = replay(made, option, target)
        assert (done.returncode, done.stdout) == (2, "")
        assert f"'{target}' cannot be written" in done.stderr
    assert {path.name for path in tmp_path.iterdir()} == {"file"}


def test_a_film_shows_the_whole_way(made, tmp_path) -> None:
    from PIL import Image

    target = tmp_path / "way.gif"
    done = replay(made, "--video", target)
    if done.returncode == 2 and "MuJoCo cannot draw here" in done.stderr:
        pytest.skip("no OpenGL here")
    assert done.returncode == 0, done.stderr
    with Image.open(target) as film:
        length = film.n_frames * film.info["duration"] / 1000
        colours = len(film.convert("RGB").getcolors(1 << 24))
    assert length == pytest.approx(the_finding(made)["path"]["duration_s"], rel=0.15)
    assert colours > 10


def test_a_setting_that_tells_where_one_is_expected_is_a_change(folder) -> None:
    file = folder / "yard" / "level.yaml"
    file.write_text(file.read_text().replace("goal_spacing_m: 3", "goal_spacing_m: 3, expected_within_m: 4"))
    done = replay(folder)
    assert "changed since the run: explore.expected_within_m is 4.0, it was 3.0" in done.stdout
    file.write_text(file.read_text().replace("steps: ", "steps: 1"))
    assert "explore.steps" not in replay(folder).stdout  # how long one looks changes no level
