"""A film shows what a character can get into: solids without collision, and it inside of them."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from reachtest.errors import BadInput
from reachtest.records import Solid
from reachtest.replaying.render import build
from reachtest.replaying.video import _around, _without_collision, check_video
from tests.levels import FLOOR, box, level

GHOST, CRATE, FAR = box([0, 0, 0], [2, 2, 2]), box([4, 0, 0], [6, 2, 2]), box([300, 0, 0], [302, 2, 2])


def test_only_solids_without_collision_are_drawn_beside_it() -> None:
    where = level(FLOOR, CRATE)
    where = replace(where, solids=(Solid("ghost", GHOST), Solid("crate", CRATE), Solid("far", FAR)))
    alone = _without_collision(where)
    np.testing.assert_array_equal(alone, np.concatenate([GHOST, FAR]))
    np.testing.assert_array_equal(_around(np.array([[5.0, 5, 0], [9, 9, 0]]), alone), GHOST)


def test_solids_are_translucent_and_the_level_is_not() -> None:
    assert build(FLOOR, GHOST).geom_rgba[:, 3].tolist()[0] == 1
    assert 0 < build(FLOOR, GHOST).geom_rgba[1, 3] < 1
    assert build(FLOOR, GHOST[:0]).ngeom == 1


def test_an_mp4_without_ffmpeg_is_refused_before_it_is_drawn(monkeypatch) -> None:
    monkeypatch.setenv("PATH", "")
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    with pytest.raises(BadInput, match="needs ffmpeg"):
        check_video(Path("way.mp4"), level(FLOOR))
