"""The primitive `heightmap`: where its samples lie, and what is wrong with its file."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from reachtest.geometry import grid_surface
from reachtest.levels import load_level
from reachtest.levels.meshes.solids import find_leaks
from reachtest.levels.shapes.grids import MOST_SAMPLES, grid_points, skirt
from reachtest.records import Floats
from tests.unit.levels.make import WriteLevel, only_problem, problems_of

FLOOR = {"box": {"center": [0, 0, -0.5], "size": [20, 20, 1]}}
RAMP = np.array([[0, 1, 2, 3], [4, 5, 6, 7], [8, 9, 10, 11]], dtype=np.float64)  # first row: +y


def npy(array: Any) -> bytes:
    stream = io.BytesIO()
    np.save(stream, np.asarray(array))
    return stream.getvalue()


def png(array: Any, mode: str | None = None) -> bytes:
    from PIL import Image

    stream = io.BytesIO()
    image = Image.fromarray(np.asarray(array))
    (image.convert(mode) if mode else image).save(stream, "PNG")
    return stream.getvalue()


def with_map(write_level: WriteLevel, name: str, data: bytes, **keys: Any) -> Path:
    """The small level with a terrain of 6 m x 4 m, its low corner at (1, 2, 3), above the floor."""
    stated = {"file": name, "size_m": [6, 4], "position": [1, 2, 3], **keys}
    path = write_level(geometry=[FLOOR, {"heightmap": stated}], spawns=[[-5, -5, 0]])
    (path.parent / name).write_bytes(data)
    return path


def terrain(path: Path) -> Floats:
    return load_level(path).collision[12:]


def at(triangles: Floats, x: float, y: float) -> float:
    """Height of the corner that stands there."""
    corners = triangles.reshape(-1, 3)
    return float(corners[np.linalg.norm(corners[:, :2] - [x, y], axis=1).argmin(), 2])


def test_two_triangles_a_cell_all_seen_from_above(write_level: WriteLevel) -> None:
    triangles = terrain(with_map(write_level, "a.npy", npy(RAMP)))
    assert triangles.shape == (2 * 3 * 2, 3, 3)
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    assert (normals[:, 2] > 0).all()
    assert normals[:, 2].sum() / 2 == pytest.approx(6 * 4)  # no overlap, no gap


def test_low_corner_at_position_and_first_row_at_plus_y(write_level: WriteLevel) -> None:
    triangles = terrain(with_map(write_level, "a.npy", npy(RAMP), height_m=0.5))
    np.testing.assert_allclose(triangles.min(axis=(0, 1)), [1, 2, 3])
    np.testing.assert_allclose(triangles.max(axis=(0, 1)), [7, 6, 3 + 5.5])
    assert at(triangles, 1, 6) == 3  # first row, first column
    assert at(triangles, 7, 6) == 3 + 1.5
    assert at(triangles, 1, 2) == 3 + 4.0  # last row
    assert at(triangles, 3, 4) == 3 + 2.5


def test_the_level_knows_the_grid_and_its_triangles(write_level: WriteLevel) -> None:
    level = load_level(with_map(write_level, "a.npy", npy(RAMP)))
    (field,) = level.height_fields
    np.testing.assert_allclose([field.low, field.high], [[1, 2], [7, 6]])
    np.testing.assert_array_equal(field.heights, RAMP[::-1] + 3)
    np.testing.assert_array_equal(level.collision[field.first :], grid_surface(field.points))


def test_the_grid_is_found_behind_triangles_that_were_left_out(write_level: WriteLevel) -> None:
    path = with_map(write_level, "a.npy", npy(RAMP))
    (path.parent / "thin.obj").write_text("v 0 0 0\nv 5 0 0\nv 5 5 0\nv 9 0 0\nf 1 2 3\nf 1 2 4\n")
    path.write_text(path.read_text().replace("- heightmap:", "- mesh: thin.obj\n- heightmap:"))
    level = load_level(path)
    assert level.height_fields[0].first == 12 + 1 == len(level.collision) - 12


@pytest.mark.parametrize(("dtype", "white"), [(np.uint8, 255), (np.uint16, 65_535)])
def test_full_white_is_height_m(write_level: WriteLevel, dtype: type, white: int) -> None:
    grey = np.array([[0, white], [white // 5, 0], [0, 0]], dtype=dtype)
    triangles = terrain(with_map(write_level, "a.png", png(grey), height_m=10))
    assert at(triangles, 7, 6) == pytest.approx(13)
    assert at(triangles, 1, 4) == pytest.approx(5)
    assert at(triangles, 1, 2) == 3


def test_sixteen_bits_are_not_cut_to_eight(write_level: WriteLevel) -> None:
    grey = np.array([[0, 1], [300, 0]], dtype=np.uint16)
    triangles = terrain(with_map(write_level, "a.png", png(grey), height_m=65.535, position=[1, 2, 0]))
    assert at(triangles, 7, 6) == pytest.approx(0.001)
    assert at(triangles, 1, 2) == pytest.approx(0.3)


def test_position_is_in_the_frame_and_lengths_in_metres(write_level: WriteLevel) -> None:
    stated = {"file": "a.npy", "size_m": [6, 4], "position": [100, 300, -200]}
    path = write_level(
        frame={"up_axis": "y", "units": "cm"},
        geometry=[{"box": {"center": [0, -50, 0], "size": [2000, 100, 2000]}}, {"heightmap": stated}],
        spawns=[[-500, 0, 500]],
        navmesh={"mesh": "nav.obj", "up_axis": "z", "units": "m"},
    )
    (path.parent / "a.npy").write_bytes(npy(RAMP))
    triangles = load_level(path).collision[12:]
    np.testing.assert_allclose(triangles.min(axis=(0, 1)), [1, 2, 3])
    np.testing.assert_allclose(triangles.max(axis=(0, 1)), [7, 6, 14])


def test_the_level_changes_with_the_file(write_level: WriteLevel) -> None:
    before = load_level(with_map(write_level, "a.npy", npy(RAMP)))
    after = load_level(with_map(write_level, "a.npy", npy(RAMP + 1)))
    assert before.sha256 != after.sha256
    assert before.parts[1].name == "heightmap 1"


def test_png_without_a_height(write_level: WriteLevel) -> None:
    where, _, remedy = only_problem(with_map(write_level, "a.png", png(np.zeros((3, 3), np.uint8))))
    assert where == "level.yaml: geometry[1].heightmap"
    assert "height_m" in remedy


def test_missing_file_is_named_with_what_is_near(write_level: WriteLevel) -> None:
    path = with_map(write_level, "hills.npy", npy(RAMP))
    path.write_text(path.read_text().replace("hills.npy", "hill.npy"))
    where, found, remedy = only_problem(path)
    assert where == "level.yaml: geometry[1].heightmap.file"
    assert found == "hill.npy does not exist"
    assert "did you mean 'hills.npy'?" in remedy


def test_missing_file_is_said_together_with_a_mistake_elsewhere(write_level: WriteLevel) -> None:
    stated = {"file": "no.png", "size_m": [6, 4], "height_m": -1, "position": [1, 2, 3]}
    wheres = [where for where, _, _ in problems_of(write_level(geometry=[{"heightmap": stated}]))]
    assert wheres == ["level.yaml: geometry[0].heightmap.height_m", "level.yaml: geometry[0].heightmap.file"]


def test_other_types_of_file(write_level: WriteLevel) -> None:
    where, found, remedy = only_problem(with_map(write_level, "a.tif", b"II"))
    assert where == "level.yaml: geometry[1].heightmap.file"
    assert "a.tif" in found
    assert ".npy .png" in remedy


GREY = np.arange(9, dtype=np.uint8).reshape(3, 3)
HOLE = np.where(RAMP == 6, np.nan, RAMP)


@pytest.mark.parametrize(
    ("name", "data", "found", "remedy"),
    [
        ("a.png", png(GREY, "RGB"), "holds RGB", "grey with 8 or 16 bits"),
        ("a.png", png(GREY, "LA"), "grey with alpha", "without alpha"),
        ("a.png", png(GREY, "P"), "palette", "grey"),
        ("a.png", png(GREY)[:-30], "cannot be read", "export it again"),
        ("a.png", b"not a picture", "cannot be read", "export it again"),
        ("a.png", png(GREY[:1]), "has 3 x 1 samples", "2 x 2"),
        (
            "a.npy",
            npy(HOLE),
            "NaN, infinite or beyond 1e+07 m, the first at row 1, column 2",
            "fill the gaps",
        ),
        ("a.npy", npy(RAMP * 1e300), "infinite or beyond", "height_m"),
        ("a.npy", npy(RAMP[0]), "holds 1 dimensions of float64", "2-dimensional"),
        ("a.npy", npy(RAMP * 1j), "complex128", "numbers"),
        ("a.npy", npy(np.zeros((0, 4))), "has 4 x 0 samples", "2 x 2"),
        ("a.npy", npy(RAMP)[:-8], "cannot be read", "export it again"),
        ("a.npy", b"PK\3\4 an archive", "cannot be read", "export it again"),
    ],
)
def test_bad_file(write_level: WriteLevel, name: str, data: bytes, found: str, remedy: str) -> None:
    where, what, then = only_problem(with_map(write_level, name, data, height_m=2))
    assert where == "level.yaml: geometry[1].heightmap.file"
    assert what.startswith(name)
    assert found in what
    assert remedy in then


def test_pickled_array_is_not_run(write_level: WriteLevel) -> None:
    stream = io.BytesIO()
    np.save(stream, np.array([[1, None], [2, 3]], dtype=object), allow_pickle=True)
    assert "object" in only_problem(with_map(write_level, "a.npy", stream.getvalue()))[1]


def test_too_many_samples_are_refused_before_memory_is_taken(write_level: WriteLevel) -> None:
    header = io.BytesIO()
    stated = {"descr": "<f8", "fortran_order": False, "shape": (10**6, 10**6)}
    np.lib.format.write_array_header_1_0(header, stated)
    _, found, remedy = only_problem(with_map(write_level, "a.npy", header.getvalue()))
    assert "1000000 x 1000000 samples" in found
    assert f"{MOST_SAMPLES:,}" in remedy
    wide = bytearray(png(GREY))
    wide[16:24] = (200_000).to_bytes(4, "big") * 2  # width and height in the PNG's first chunk
    import zlib

    wide[29:33] = zlib.crc32(wide[12:29]).to_bytes(4, "big")
    assert "200000 x 200000 samples" in only_problem(with_map(write_level, "a.png", wide, height_m=1))[1]


def test_file_too_long_for_any_map_is_not_read(write_level: WriteLevel) -> None:
    path = with_map(write_level, "a.npy", npy(RAMP))
    with (path.parent / "a.npy").open("r+b") as file:
        file.truncate(10**10)  # a hole: it takes no room on the disk
    assert "10,000,000,000 bytes" in only_problem(path)[1]


def test_a_terrain_is_no_solid(write_level: WriteLevel) -> None:
    path = with_map(write_level, "a.npy", npy(RAMP))
    path.write_text(path.read_text().replace("- heightmap:", "- role: solid\n  heightmap:"))
    assert "is not watertight" in only_problem(path)[1]


def test_skirt_closes_the_surface() -> None:
    points = grid_points(RAMP, (6, 4))
    closed = np.concatenate([grid_surface(points), skirt(points, -2)])
    assert find_leaks(closed).closed
    volume = np.linalg.det(closed).sum() / 6
    assert volume == pytest.approx(6 * 4 * (2 + RAMP.mean()))  # of a plane: its middle height
