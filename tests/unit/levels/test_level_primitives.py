"""Primitives: closed, outward, and of the size they state."""

from __future__ import annotations

import numpy as np
import pytest

from reachtest.levels import PRIMITIVES
from reachtest.levels.frames import make_frame
from reachtest.levels.meshes.solids import find_leaks
from reachtest.levels.shapes.primitives import CYLINDER_SIDES
from reachtest.records import Floats
from tests.unit.levels.make import WriteLevel, only_problem

SPECS = {
    "box": {"center": [1, 2, 3], "size": [2, 3, 4], "yaw_deg": 30},
    "ramp": {"from": [0, 0, 0], "to": [3, 0, 4], "width": 2, "thickness": 0.5},
    "cylinder": {"center": [1, 2, 3], "radius": 2, "height": 5},
}
VOLUMES = {
    "box": 24.0,
    "ramp": 5 * 2 * 0.5,
    "cylinder": CYLINDER_SIDES / 2 * np.sin(2 * np.pi / CYLINDER_SIDES) * 2**2 * 5,
}


def test_every_shape_that_needs_no_file_is_tried() -> None:
    assert set(SPECS) == {kind for kind, primitive in PRIMITIVES.items() if not primitive.files}


def build(kind: str, up_axis: str = "z", units: str = "m", **changes: object) -> Floats:
    primitive = PRIMITIVES[kind]
    spec = primitive.spec.model_validate({**SPECS[kind], **changes})
    return primitive.build(spec, make_frame(up_axis, units))


@pytest.mark.parametrize("kind", SPECS)
@pytest.mark.parametrize("units", ["m", "ft"])
def test_closed_outward_and_of_its_volume(kind: str, units: str) -> None:
    triangles = build(kind, units=units)
    factor = {"m": 1.0, "ft": 0.3048}[units] ** 3
    assert find_leaks(triangles).closed
    assert np.linalg.det(triangles).sum() / 6 == pytest.approx(VOLUMES[kind] * factor)


def test_box_turns_anticlockwise_about_up_in_either_frame() -> None:
    long = {"center": [0, 0, 0], "size": [10, 1, 1], "yaw_deg": 45}
    for triangles in (build("box", **long), build("box", "y", **long)):
        corners = triangles.reshape(-1, 3)
        far = corners[np.argmax(corners @ np.array([1, 1, 0]))]
        np.testing.assert_allclose(far[:2].mean(), 5 / np.sqrt(2), atol=0.4)
        assert np.abs(corners[:, 2]).max() == pytest.approx(0.5)


def test_y_up_box_is_as_tall_as_its_second_size() -> None:
    triangles = build("box", "y", center=[0, 0, 0], size=[1, 2, 3], yaw_deg=0)
    np.testing.assert_allclose(triangles.max(axis=(0, 1)), [0.5, 1.5, 1.0])


def test_ramp_top_goes_through_both_edges() -> None:
    corners = build("ramp").reshape(-1, 3)
    for edge in ([0, -1, 0], [0, 1, 0], [3, -1, 4], [3, 1, 4]):
        assert np.linalg.norm(corners - edge, axis=1).min() < 1e-9
    assert corners[:, 2].max() == pytest.approx(4)  # nothing above the upper edge


def test_upright_ramp_is_refused(write_level: WriteLevel) -> None:
    path = write_level(geometry=[{"ramp": {"from": [0, 0, 0], "to": [0, 0, 1], "width": 1}}])
    where, _, remedy = only_problem(path)
    assert where == "level.yaml: geometry[0].ramp"
    assert "horizontal distance" in remedy
