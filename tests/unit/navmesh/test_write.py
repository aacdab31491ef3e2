"""A nav-mesh that was written is read back as it was."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from reachtest.levels import read_navmesh_file
from reachtest.levels.frames import make_frame
from reachtest.navmesh.write import write_navmesh
from reachtest.records import NavAgent, NavMesh

SQUARE = np.array([[0.0, 0, 1], [4, 0, 1], [4, 3, 1], [0, 3, 1]])
FACES = np.array([[0, 1, 2], [0, 2, 3]])


@pytest.mark.parametrize(("up_axis", "units"), [("z", "m"), ("y", "cm"), ("z", 0.03125)])
@pytest.mark.parametrize("agent", [NavAgent(0.34, 1.76, 0.45, 44.765), NavAgent(height_m=2.0), NavAgent()])
def test_obj_brings_back_surface_and_agent(
    tmp_path: Path, agent: NavAgent, up_axis: str, units: str | float
) -> None:
    file = tmp_path / "nav.obj"
    write_navmesh(NavMesh("", SQUARE, FACES, agent=agent), make_frame(up_axis, units), file)
    read = read_navmesh_file(file, up_axis=up_axis, units=units)
    np.testing.assert_allclose(read.triangles, SQUARE[FACES], atol=1e-6)
    for key, value in vars(agent).items():
        assert getattr(read.agent, key) == (None if value is None else pytest.approx(value))
