"""The small level as a fixture."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import pytest

from tests.unit.levels.make import WriteLevel, write_small


@pytest.fixture
def write_level(tmp_path: Path) -> WriteLevel:
    """Writes the small level with top-level keys changed, and returns its path."""
    return partial(write_small, tmp_path / "small")
