"""The file of known bugs: what it says comes back, and mistakes are told with their place."""

from __future__ import annotations

from dataclasses import replace
from datetime import date

import pytest

from reachtest.baseline import baseline_of, read_baseline
from reachtest.baseline.document import dump, parse
from reachtest.errors import BadInput
from tests.unit.baseline.test_apply import entry
from tests.unit.report.make import make_level

LEVEL = "hall"


def test_what_is_written_is_what_is_read() -> None:
    nasty = "colon: #hash 'quote' \"double\" \n line – ünï {brace} [1, 2] & *x"
    entries = (entry(reason=nasty, expires=date(2031, 1, 1)), entry(exits=(), author="yes"))
    assert parse(dump(LEVEL, entries), "").entries == entries
    assert parse(dump("null", ()), "") == parse(dump("null", []), "")
    assert parse(dump("null", ()), "").level == "null"


def test_a_file_of_before_the_level_was_noted_is_read() -> None:
    text = dump(LEVEL, [entry()])
    older = "".join(line for line in text.splitlines(keepends=True) if "level_sha256" not in line)
    assert older != text
    assert parse(older, "").entries == (entry(level_sha256=None),)


def problems(tmp_path, text) -> str:
    file = tmp_path / "known.yaml"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(BadInput) as caught:
        read_baseline(file, LEVEL)
    assert all("known.yaml" in problem.where for problem in caught.value.problems)
    return str(caught.value)


GOOD = dump(LEVEL, [entry(expires=date(2031, 2, 28))])


@pytest.mark.parametrize(
    ("old", "new", "facts"),
    [
        ("version: 1", "version: 2", ["version", "found 2", "reads version 1"]),
        ("version: 1\n", "", ["version", "is missing"]),
        (f"level: {LEVEL}", "level: cellar", ["'cellar'", "'hall'"]),
        ("reason: ticket 7", "resaon: ticket 7", ["entries[0].resaon", "unknown key", "entries[0].reason"]),
        ("reason: ticket 7", "reason: ' '", ["entries[0].reason"]),
        ("kind: fell", "kind: fall", ["fall_out_of_world", "fell_out_of_world"]),
        ("2031-02-28", "2031-02-30", ["day is out of range"]),
        ("2031-02-28", "2031", ["entries[0].expires", "2030-12-31"]),
        ("2031-02-28", "soon", ["entries[0].expires", "soon"]),
        ("entries:\n-", "entries:\n}", ["line 5"]),
        ("[4.0, 3.0, -10.0]", "[4.0, .nan, -10.0]", ["position"]),
        (GOOD, "[1, 2]", ["no mapping"]),
        (GOOD, "", ["no mapping"]),
        ("version: 1", "version: true", ["version", "found True"]),
        ("version: 1", "version: 1.0", ["version", "found 1.0"]),
        (GOOD, "version: 1\nlevel: hall\nentries: " + "[" * 3000, ["nested too deep"]),
        (GOOD, GOOD[:-60], ["added"]),
    ],
)
def test_mistakes_are_told_with_their_place(tmp_path, old, new, facts) -> None:
    assert old in GOOD
    told = problems(tmp_path, GOOD.replace(old, new))
    for fact in facts:
        assert fact in told


def test_a_file_that_a_level_names_in_vain_is_told_with_the_key(tmp_path) -> None:
    gate = replace(make_level().gate, baseline="nosuch.yaml")
    level = make_level(file=tmp_path / "hall.yaml", gate=gate)
    with pytest.raises(BadInput) as caught:
        baseline_of(level)
    (problem,) = caught.value.problems
    assert problem.where == "hall.yaml: gate.baseline"
    assert "'nosuch.yaml': No such file" in problem.found
    (tmp_path / "nosuch.yaml").write_text(GOOD)
    assert [e.id for e in baseline_of(level).entries] == [entry().id]
    assert baseline_of(make_level()) is None


def test_a_file_that_is_none_is_told(tmp_path) -> None:
    with pytest.raises(BadInput, match="No such file"):
        read_baseline(tmp_path / "known.yaml", LEVEL)
    (tmp_path / "known.yaml").write_bytes(b"\xff\xfe\x00\x01")
    with pytest.raises(BadInput, match="is no text"):
        read_baseline(tmp_path / "known.yaml", LEVEL)
