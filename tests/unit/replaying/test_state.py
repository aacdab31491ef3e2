"""What a run keeps for replaying comes back as it was, or is refused with what is wrong and where."""

from __future__ import annotations

import io
import json
import zipfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from reachtest.confirm.outcome import Judge
from reachtest.errors import BadInput
from reachtest.replaying.keep import write_state
from reachtest.replaying.kept import STATE_FILE
from reachtest.replaying.state import read_state
from reachtest.surface import SurfaceIndex
from tests.unit.report.make import make_finding, make_level, make_path

LEVEL_TEXT = "version: 1\nname: hall\ngeometry:\n- {mesh: hall.glb}\nnavmesh: {mesh: nav.glb}\n"


@pytest.fixture
def folder(tmp_path) -> Path:
    """The output folder of a run that found two things, one of them without a path."""
    for name, text in (("hall.yaml", LEVEL_TEXT), ("hall.glb", "walls"), ("nav.glb", "floor")):
        (tmp_path / name).write_text(text)
    level = make_level(file=tmp_path / "hall.yaml")
    rng = np.random.default_rng(0)
    steps = make_path().positions
    actions = rng.integers(0, 2, (len(steps), 2)).astype(np.int8)
    path = replace(make_path(), state=np.arange(7.0), actions=actions)
    findings = [make_finding(path=path), make_finding(id="other", path=None)]
    out = tmp_path / "out"
    out.mkdir()
    write_state(out, level, findings, Judge(level, SurfaceIndex(level.navmesh.triangles, 3.0)), "mujoco")
    return out


def complaint(folder: Path) -> str:
    with pytest.raises(BadInput) as error:
        read_state(folder)
    (problem,) = error.value.problems
    return f"{problem.where}: {problem.found}"


def rewritten(folder: Path, meta: dict[str, Any] | None = None, **changes: Any) -> None:
    """The state with other arrays (None: without it) or another description."""
    file = folder / STATE_FILE
    with np.load(file) as stored:
        arrays = {name: stored[name] for name in stored.files}
    if meta is not None:
        document = json.loads(arrays["meta"].tobytes()) | meta
        arrays["meta"] = np.frombuffer(json.dumps(document).encode(), dtype=np.uint8)
    arrays = {name: value for name, value in (arrays | changes).items() if value is not None}
    stream = io.BytesIO()
    np.savez(stream, **arrays)
    file.write_bytes(stream.getvalue())


def test_paths_come_back_to_the_last_bit(folder) -> None:
    state = read_state(folder)
    assert [finding.id for finding in state.kept.findings] == ["fell-5f2a91", "other"]
    assert set(state.recordings) == {"fell-5f2a91"}
    recording = state.recordings["fell-5f2a91"]
    np.testing.assert_array_equal(recording.positions, make_path().positions)
    np.testing.assert_array_equal(recording.state, np.arange(7.0))
    assert recording.actions.dtype == np.int8
    assert set(state.kept.level.files) == {"hall.yaml", "hall.glb", "nav.glb"}
    assert "missing" not in state.kept.level.files.values()


def test_the_same_findings_are_the_same_bytes_and_nothing_else_is_left(folder) -> None:
    before = (folder / STATE_FILE).read_bytes()
    level = make_level(file=folder.parent / "hall.yaml")
    state = read_state(folder)
    recording = state.recordings["fell-5f2a91"]
    path = replace(make_path(), state=recording.state, actions=recording.actions)
    findings = [make_finding(path=path), make_finding(id="other", path=None)]
    judge = Judge(level, SurfaceIndex(level.navmesh.triangles, 3.0))
    write_state(folder, level, findings, judge, "mujoco")
    assert (folder / STATE_FILE).read_bytes() == before
    assert [path.name for path in (folder / "state").iterdir()] == [STATE_FILE.name]


def test_a_folder_without_state_is_told_from_one_that_is_not_there(tmp_path) -> None:
    assert "does not exist" in complaint(tmp_path / "nowhere")
    assert "state/findings.npz" in complaint(tmp_path)


@pytest.mark.parametrize("share", [0.0, 0.1, 0.5, 0.9, 0.999])
def test_a_file_that_was_cut_off_is_refused(folder, share) -> None:
    file = folder / STATE_FILE
    data = file.read_bytes()
    file.write_bytes(data[: int(share * len(data))])
    assert str(file) in complaint(folder)


def test_a_file_with_a_flipped_byte_is_refused_or_the_same(folder) -> None:
    file, kept = folder / STATE_FILE, read_state(folder).kept
    data = file.read_bytes()
    refused = 0
    for at in range(40, len(data) - 40, max(len(data) // 40, 1)):
        file.write_bytes(data[:at] + bytes([data[at] ^ 0x55]) + data[at + 1 :])
        try:
            assert read_state(folder).kept == kept  # a byte that means nothing
        except BadInput:
            refused += 1
    assert refused > 20


@pytest.mark.parametrize(
    ("changes", "fact"),
    [
        ({"meta": {"format": 2}}, "format"),
        ({"meta": {"findings": "none"}}, "findings"),
        ({"meta": {"simulator": "unity"}}, "simulator is 'unity': this version knows mujoco"),
        ({"meta": {"physics_hz": 0}}, "physics_hz is '0'"),
        ({"meta": {"physics_hz": float("nan")}}, "physics_hz"),
        ({"meta": {"action_repeat": -3}}, "action_repeat is '-3'"),
        ({"meta": {"action_repeat": 10**7}}, "action_repeat is '10000000'"),
        ({"actions0": None}, "missing"),
        ({"actions0": np.full((72, 2), 9, dtype=np.int8)}, "actions"),
        ({"actions0": np.zeros((71, 2), dtype=np.int8)}, "no path"),
        ({"positions0": np.zeros((72, 3), dtype=np.int8)}, "no path"),
        ({"state0": np.full(7, np.nan)}, "no path"),
        ({"actions0": np.zeros((0, 2), dtype=np.int8)}, "no path"),
    ],
)
def test_what_no_run_writes_is_refused(folder, changes, fact) -> None:
    rewritten(folder, **changes)
    assert fact in complaint(folder)


def test_a_kind_of_finding_that_is_not_known_is_refused(folder) -> None:
    (first, second) = read_state(folder).kept.model_dump(mode="json")["findings"]
    rewritten(folder, {"findings": [first, second | {"kind": "teleported"}]})
    assert "findings.1.kind is 'teleported'" in complaint(folder)


@pytest.mark.parametrize("places", [np.zeros((0, 3)), np.full((2, 3), np.nan), np.zeros((2, 3), np.int8)])
def test_places_of_a_pocket_that_are_none_are_refused(folder, places) -> None:
    (first, _) = read_state(folder).kept.model_dump(mode="json")["findings"]
    rewritten(folder, {"findings": [first | {"kind": "stuck"}]}, standing0=places)
    assert "places of fell-5f2a91" in complaint(folder)


def test_pickles_are_not_opened(folder) -> None:
    rewritten(folder, state0=np.array([{"a": 1}], dtype=object))
    assert str(folder / STATE_FILE) in complaint(folder)


def test_an_archive_that_claims_to_be_huge_is_not_unpacked(folder) -> None:
    with (
        zipfile.ZipFile(folder / STATE_FILE, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive,
        archive.open("meta.npy", "w", force_zip64=True) as stream,
    ):
        for _ in range(1100):
            stream.write(bytes(1 << 20))
    assert "claims" in complaint(folder)


def test_a_report_of_another_build_beside_it_is_told(folder) -> None:
    (folder / "report.json").write_text(json.dumps({"level": {"name": "hall", "sha256": "cd" * 32}}))
    assert "another build" in complaint(folder)
    (folder / "report.json").write_text(json.dumps({"level": {"name": "hall", "sha256": "ab" * 32}}))
    assert read_state(folder).recordings
