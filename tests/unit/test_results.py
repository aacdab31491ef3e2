"""Reading back what a run left: bad folders are told, not half understood."""

from __future__ import annotations

import json

import pytest

from reachtest.errors import BadInput
from reachtest.results import read_result
from tests.unit.baseline.test_update import result
from tests.unit.report.make import make_finding


def test_a_folder_and_its_report_are_the_same_run(tmp_path) -> None:
    run = result(tmp_path / "out", make_finding())
    assert read_result(tmp_path / "out" / "report.json").report == run.report
    assert [f.id for f in run.report.findings] == [make_finding().id]
    assert run.coverage is not None
    assert [step for *_, step in run.coverage.goals] == [0, 640, -1]
    assert [expected for *_, expected in run.coverage.stood] == [1, 1, 0]  # two goals share a cell


@pytest.mark.parametrize("name", ["report.json", "coverage.json"])
@pytest.mark.parametrize(
    ("change", "fact"),
    [
        (lambda text: text[: len(text) // 2], "cut off"),
        (lambda text: "[]", "schema_version None"),
        (lambda text: text.replace('"schema_version": 1', '"schema_version": 2'), "schema_version 2"),
        (lambda text: text.replace('"schema_version": 1', '"schema_version": true'), "schema_version True"),
        (lambda text: json.dumps({"schema_version": 1}), "required"),
        (lambda text: "[" * 100_000, "nested too deep"),
    ],
    ids=["cut off", "a list", "another version", "true", "empty", "nested"],
)
def test_a_damaged_file_is_told(tmp_path, name, change, fact) -> None:
    result(tmp_path / "out", make_finding())
    file = tmp_path / "out" / name
    file.write_text(change(file.read_text()))
    with pytest.raises(BadInput, match=fact) as caught:
        read_result(tmp_path / "out")
    assert all(name in problem.where for problem in caught.value.problems)


def _set(document, value, *keys) -> None:
    *above, last = keys
    for key in above:
        document = document[key]
    assert document[last] != value
    document[last] = value


@pytest.mark.parametrize(
    ("name", "keys", "value", "fact"),
    [
        ("report.json", ("config", "frame", "matrix"), [[1, 0, 0], [2, 0, 0], [0, 0, 1]], "independent"),
        ("report.json", ("findings", 0, "bounds", 0, 0), float("nan"), "found nan"),
        ("report.json", ("findings", 0, "kind"), "flying", "found 'flying': known kinds are unexpected_area"),
        ("report.json", ("findings", 0, "id"), "", "at least 1 character"),
        ("coverage.json", ("cell_m",), 0, "found 0"),
        ("coverage.json", ("cell_m",), float("nan"), "found nan"),
        ("coverage.json", ("goals", 0, 3), 10**400, "found 1000"),
        ("coverage.json", ("stood", 0, 0), 1e300, "found 1e"),
    ],
)
def test_a_value_that_no_run_writes_is_told(tmp_path, name, keys, value, fact) -> None:
    result(tmp_path / "out", make_finding())
    file = tmp_path / "out" / name
    document = json.loads(file.read_text())
    _set(document, value, *keys)
    file.write_text(json.dumps(document))
    with pytest.raises(BadInput) as caught:
        read_result(tmp_path / "out")
    (problem,) = caught.value.problems
    assert f"{name}: {keys[0]}" in problem.where
    assert fact in problem.found


def test_no_run_there_is_told(tmp_path) -> None:
    with pytest.raises(BadInput, match="No such file"):
        read_result(tmp_path)
