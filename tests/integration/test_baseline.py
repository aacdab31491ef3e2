"""A bug that is known, becomes known, expires, and is fixed: as a build server goes through it."""

from __future__ import annotations

import json
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest

from tests.integration.test_cli import reachtest, yard


@pytest.fixture(scope="module")
def known(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path, Path]:
    """The open yard, the output of a run of it that failed, and the file of its known bugs."""
    folder = tmp_path_factory.mktemp("known")
    file = yard(folder / "yard", closed=False)
    assert reachtest("run", file, "--quiet", "--out", folder / "out").returncode == 1
    arguments = ("--file", folder / "known.yaml", "--reason", "the wall comes in May", "--author", "Mia")
    done = reachtest("baseline", "update", folder / "out", *arguments, "--expires", "2999-12-31")
    assert done.returncode == 0, done.stderr
    return file, folder / "out", folder / "known.yaml"


def test_a_known_bug_passes_is_shown_and_is_skipped(known, tmp_path) -> None:
    file, _, baseline = known
    done = reachtest("run", file, "--seed", 1, "--baseline", baseline, "--quiet", "--out", tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "Known bugs (1)" in done.stdout
    assert "the wall comes in May (Mia, until 2999-12-31)" in " ".join(done.stdout.split())
    report = json.loads((tmp_path / "report.json").read_text())
    (finding,) = report["findings"]
    assert not finding["gating"]
    assert (
        finding["suppressed_by"]
        == f"baseline: {report['baseline']['known'][0]['id']} (the wall comes in May)"
    )
    assert [case.tag for case in ET.parse(tmp_path / "junit.xml").iter("skipped")] == ["skipped"]
    assert "## Known bugs (1)" in (tmp_path / "summary.md").read_text(encoding="utf-8")


def test_an_expired_one_gates_again_and_is_named_with_its_date(known, tmp_path) -> None:
    file, _, baseline = known
    expired = tmp_path / "expired.yaml"
    expired.write_text(baseline.read_text().replace("2999-12-31", "2020-12-31"))
    done = reachtest("run", file, "--baseline", expired, "--quiet", "--out", tmp_path / "out")
    assert done.returncode == 1
    assert "expired 2020-12-31" in " ".join(done.stdout.split())


def test_the_level_may_name_the_file_and_a_fixed_bug_is_named(known, tmp_path) -> None:
    _, _, baseline = known
    file = yard(tmp_path / "yard", closed=True, extra="gate: {baseline: known.yaml}\n")
    (tmp_path / "yard" / "known.yaml").write_text(baseline.read_text())
    done = reachtest("run", file, "--quiet", "--json", "--out", tmp_path / "out")
    assert done.returncode == 0
    section = json.loads(done.stdout)["baseline"]
    assert (section["file"], len(section["fixed"])) == ("known.yaml", 1)
    (tmp_path / "yard" / "known.yaml").unlink()
    assert reachtest("run", file, "--quiet", "--out", tmp_path / "out").returncode == 2
    done = reachtest("validate", file)
    assert done.returncode == 2
    assert "level.yaml: gate.baseline" in done.stderr
    done = reachtest("run", file, "--quiet", "--baseline", baseline, "--out", tmp_path / "out")
    assert done.returncode == 0  # the option wins


@pytest.mark.parametrize(
    ("change", "fact"),
    [
        (lambda text: text[: len(text) // 2], "known.yaml"),
        (lambda text: text.replace("version: 1", "version: 3"), "found 3"),
        (lambda text: text.replace("level: yard", "level: cellar"), "cellar"),
    ],
    ids=["cut off", "another version", "another level"],
)
def test_a_bad_baseline_is_status_2_and_nothing_is_run(known, tmp_path, change, fact) -> None:
    file, _, baseline = known
    bad = tmp_path / "known.yaml"
    bad.write_text(change(baseline.read_text()))
    done = reachtest("run", file, "--baseline", bad, "--quiet", "--out", tmp_path / "out")
    assert done.returncode == 2
    assert fact in done.stderr
    assert "Traceback" not in done.stderr
    assert not (tmp_path / "out").exists()


def test_update_refuses_what_is_no_run_and_dates_that_are_past(known, tmp_path) -> None:
    _, out, _ = known
    arguments = ("--file", tmp_path / "new.yaml", "--reason", "x", "--author", "y")
    (tmp_path / "report.json").write_text((out / "report.json").read_text()[:-200])
    done = reachtest("baseline", "update", tmp_path, *arguments)
    assert done.returncode == 2
    assert "cut off" in done.stderr
    done = reachtest("baseline", "update", out, *arguments, "--expires", "2020-01-01")
    assert done.returncode == 2
    assert "past" in done.stderr
    assert reachtest("baseline", "update", out, "--reason", " ", "--author", "y").returncode == 2
    assert not (tmp_path / "new.yaml").exists()


def test_diff_of_a_closed_and_an_open_yard(known, tmp_path) -> None:
    _, out, _ = known
    file = yard(tmp_path / "yard", closed=True)
    assert reachtest("run", file, "--quiet", "--out", tmp_path / "closed").returncode == 0
    fixed = reachtest("diff", out, tmp_path / "closed")
    assert fixed.returncode == 0, fixed.stderr
    assert "Fixed (1)" in fixed.stdout
    assert "has changed" in fixed.stdout
    broken = reachtest("diff", tmp_path / "closed", out, "--format", "json")
    assert broken.returncode == 1
    assert [f["kind"] for f in json.loads(broken.stdout)["findings"]["new"]] == ["fell_out_of_world"]
    same = json.loads(reachtest("diff", out, out, "--format", "json").stdout)
    assert same["areas"]["became_unreachable"] == same["areas"]["became_reachable"] == []
    assert reachtest("diff", out, tmp_path / "nowhere").returncode == 2


def test_severities_gate_like_kinds(known, tmp_path) -> None:
    file, _, _ = known
    statuses = {
        names: reachtest("run", file, "--fail-on", names, "--quiet", "--out", tmp_path).returncode
        for names in ("error", "warning", "inside_solid,error", "inside_solid")
    }
    assert statuses == {"error": 1, "warning": 1, "inside_solid,error": 1, "inside_solid": 0}
    done = reachtest("run", file, "--fail-on", "eror", "--out", tmp_path)
    assert done.returncode == 2
    assert "did you mean 'error'?" in done.stderr
    assert "no_return" in done.stderr
