"""`reachtest bench stability` and `reachtest bench mutants` on a yard of 12 m."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.integration.test_cli import reachtest, yard


@pytest.fixture(scope="module")
def closed_yard(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return yard(tmp_path_factory.mktemp("bench") / "yard", closed=True)


def test_seeds_of_a_closed_yard_agree(closed_yard: Path) -> None:
    done = reachtest("bench", "stability", closed_yard, "--seeds", 2, "--jobs", 2, "--json")
    assert done.returncode == 0, done.stderr
    (level,) = json.loads(done.stdout)["levels"]
    assert level["verdicts"] == ["pass", "pass"]
    assert level["bugs"] == []
    table = reachtest("bench", "stability", closed_yard, "--seeds", 1, "--steps", 64)
    assert "inconclusive 1 of 1" in table.stdout


def test_bugs_planted_in_a_closed_yard_are_found(closed_yard: Path) -> None:
    done = reachtest("bench", "mutants", closed_yard, "--count", 3, "--steps", 12000, "--json")
    assert done.returncode == 0, done.stderr
    result = json.loads(done.stdout)
    assert result["verdict"] in ("pass", "inconclusive")
    assert [mutant["kind"] for mutant in result["tried"]] == ["hole", "missing wall", "lowered wall"]
    assert [mutant["found"] for mutant in result["tried"]] == ["fell_out_of_world"] * 3
    assert result["total"]["recall"] == 1.0
    assert all(0 < mutant["first_seen_step"] <= 12000 for mutant in result["tried"])


def test_bad_input_is_status_2(tmp_path: Path) -> None:
    for command in ("stability", "mutants"):
        assert reachtest("bench", command, tmp_path / "none.yaml").returncode == 2


def test_an_unknown_kind_is_told_with_the_known_ones(closed_yard: Path) -> None:
    done = reachtest("bench", "mutants", closed_yard, "--kinds", "hole, trapdoor")
    assert done.returncode == 2
    assert "trapdoor" in done.stderr
    assert "missing wall" in done.stderr
