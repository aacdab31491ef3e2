"""Built nav-meshes: beside Recast's on published levels, from the command line, and in a level file.

`pytest tests/integration/test_navmesh_build.py -s` prints the comparison.
"""

from __future__ import annotations

import json
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from reachtest.cli import app
from reachtest.errors import BadInput
from reachtest.geometry import triangle_normals
from reachtest.levels import load_level
from reachtest.navmesh.build import build_navmesh
from reachtest.navmesh.islands import islands
from reachtest.navmesh.settings import settings_for
from reachtest.records import Floats, NavMesh
from reachtest.surface import SurfaceIndex

MAPS = Path(__file__).parents[2] / "maps" / "real"
SHARED = Path(__file__).parents[3] / "shared" / "levels"
NAMES = (
    *("aggressor", "bridges", "c2_dutility", "c2_pandora", "c2_steelribs", "c2_test_ctf"),
    *("demo_level", "dungeon", "nav_test", "oa_dm1", "tut3d"),
)
# What the reference meshes were built with.
RECAST = {
    "radius_m": 0.34,
    "height_m": 1.8,
    "climb_m": 0.45,
    "slope_deg": 44.765,
    "cell_m": 0.085,
    "cell_height_m": 0.05,
}
INSIDE_OUT = (
    "bridges",
)  # its mirrored nodes turn floors upside down; the reference was built without mirroring
LARGE_M2 = 2.0  # islands below this come and go with a cell
SAMPLES = 4000
FAR_M = 0.2  # more than cell height and detail error explain

needs_levels = pytest.mark.skipif(
    not SHARED.is_dir(), reason="the real levels are not next to the project (../shared/levels)"
)


@dataclass(frozen=True)
class Row:
    """One level, built and as Recast has it."""

    name: str
    areas: tuple[float, float]  # Recast's, built [m2]
    faces: tuple[int, int]
    islands: tuple[int, int]  # of LARGE_M2 and more
    mean_m: float  # symmetric distance of the surfaces
    p99_m: float
    far: tuple[
        float, float
    ]  # share of Recast's surface farther than FAR_M from the built one, and vice versa
    seconds: float

    @property
    def ratio(self) -> float:
        return self.areas[1] / self.areas[0]


def area(navmesh: NavMesh) -> float:
    return float(triangle_normals(navmesh.triangles)[1].sum())


def large_islands(navmesh: NavMesh) -> int:
    # Steps are climbed up to the climb in whole cells of height: a step may be one cell higher in truth.
    label = islands(navmesh, RECAST["climb_m"] + RECAST["cell_height_m"])
    sizes = np.bincount(label, weights=triangle_normals(navmesh.triangles)[1])
    return int((sizes >= LARGE_M2).sum())


def distances(of: NavMesh, to: NavMesh) -> Floats:
    """Distances of points spread over the surface `of` to the surface `to`, 1 m where farther [m]."""
    rng = np.random.default_rng(0)
    areas = triangle_normals(of.triangles)[1]
    corners = of.triangles[rng.choice(len(areas), SAMPLES, p=areas / areas.sum())]
    root, along = np.sqrt(rng.random((SAMPLES, 1))), rng.random((SAMPLES, 1))
    points = (1 - root) * corners[:, 0] + root * ((1 - along) * corners[:, 1] + along * corners[:, 2])
    return np.minimum(SurfaceIndex(to.triangles, 1.0).distance(points), 1.0)


def compare(name: str) -> Row:
    reference = f"../../../../shared/levels/{name}/{name.replace('_', '-') if name == 'demo_level' else name}"
    level = load_level(MAPS / name / "level.yaml", {"navmesh": {"mesh": f"{reference}.solo.navmesh.glb"}})
    began = time.perf_counter()
    numbers = settings_for(level.character, both_sides=name in INSIDE_OUT, **RECAST)
    built = build_navmesh(level.collision, numbers)
    seconds = time.perf_counter() - began
    there, back = distances(level.navmesh, built), distances(built, level.navmesh)
    both = np.concatenate([there, back])
    return Row(
        name,
        (area(level.navmesh), area(built)),
        (len(level.navmesh.faces), len(built.faces)),
        (large_islands(level.navmesh), large_islands(built)),
        float(both.mean()),
        float(np.quantile(both, 0.99)),
        (float((there > FAR_M).mean()), float((back > FAR_M).mean())),
        seconds,
    )


@pytest.fixture(scope="module")
def rows() -> dict[str, Row]:
    found = {name: compare(name) for name in NAMES}
    print("\nBuilt against Recast's nav-mesh, cells of 0.085 m x 0.05 m")
    print(
        "| level | area m2 Recast / built | ratio | triangles | islands >= 2 m2 | distance mean / 99 % m |",
        end="",
    )
    print(" beyond 0.2 m | s |\n|---|---|---|---|---|---|---|---|")
    for row in found.values():
        print(
            f"| {row.name} | {row.areas[0]:.1f} / {row.areas[1]:.1f} | {row.ratio:.3f} | {row.faces[0]} / "
            f"{row.faces[1]} | {row.islands[0]} / {row.islands[1]} | {row.mean_m:.3f} / {row.p99_m:.2f} | "
            f"{row.far[0]:.1%} / {row.far[1]:.1%} | {row.seconds:.1f} |"
        )
    return found


@needs_levels
@pytest.mark.parametrize("name", NAMES)
def test_like_recast(name: str, rows: dict[str, Row]) -> None:
    row = rows[name]
    assert row.ratio == pytest.approx(1, abs=0.05)
    assert row.mean_m < 0.1
    assert max(row.far) < 0.03
    assert abs(row.islands[0] - row.islands[1]) <= 3, "small islands come and go with a cell"


YARD = """version: 1
frame: {up_axis: z, units: cm}
geometry:
  - {name: floor, box: {center: [0, 0, -50], size: [2000, 2000, 100]}}
  - {name: crate, box: {center: [500, 0, 50], size: [400, 400, 100]}}
navmesh: NAVMESH
character: unreal
spawns: [[0, 0, 2]]
explore: {steps: 2000}
"""


def yard(folder: Path, navmesh: str) -> Path:
    """A floor of 20 m with a crate of 1 m height, in centimetres."""
    file = folder / "level.yaml"
    file.write_text(YARD.replace("NAVMESH", navmesh))
    return file


@pytest.mark.parametrize("name", ["nav.glb", "nav.obj"])
def test_the_built_file_can_be_named_in_the_same_level_file(name: str, tmp_path: Path) -> None:
    file = yard(tmp_path, f"{{mesh: {name}}}")
    done = CliRunner().invoke(app, ["navmesh", "build", str(file), "-o", str(tmp_path / name)])
    assert done.exit_code == 0, done.output
    assert "triangles" in done.stdout
    read = load_level(file).navmesh
    built = load_level(yard(tmp_path, "{build: {}}")).navmesh
    assert area(read) == pytest.approx(area(built), rel=1e-4)
    if name == "nav.obj":
        assert vars(read.agent) == pytest.approx(vars(built.agent))
    assert area(read) == pytest.approx(19**2, rel=0.1)
    points = [[-9.3, -9.3, 0], [9.3, 9.3, 0], [5, 0, 1]]
    assert SurfaceIndex(read.triangles, 1.0).distance(np.array(points, dtype=float)).max() < 0.1
    assert np.allclose(read.vertices.min(axis=0), built.vertices.min(axis=0), atol=1e-4)


def test_numbers_of_the_level_file_count_and_options_go_over_them(tmp_path: Path) -> None:
    file = yard(tmp_path, "{build: {radius_m: 1, min_island_m2: 8}}")
    out = tmp_path / "nav.glb"
    assert (
        CliRunner().invoke(app, ["navmesh", "build", str(file), "-o", str(out), "--cell", "0.25"]).exit_code
        == 0
    )
    read = load_level(yard(tmp_path, "{mesh: nav.glb}")).navmesh
    assert np.abs(read.vertices[:, :2]).max() <= 9.0 + 1e-4, "a metre off the edge"
    assert read.vertices[:, 2].max() < 0.1, "the crate's top is smaller than 8 m2 once eroded"


@pytest.mark.parametrize(
    ("navmesh", "words"),
    [
        ("{}", ["exactly one of mesh, build"]),
        ("{mesh: a.glb, build: {}}", ["exactly one of mesh, build", "mesh and build"]),
        ("{build: {}, units: cm}", ["units can only go with 'mesh'"]),
        ("{build: {cell_m: 0}}", ["navmesh.build.cell_m", "greater than 0"]),
        ("{build: {radius: 1}}", ["unknown key 'radius'", "radius_m"]),
        ("{build: {height_m: 50, radius_m: 40}}", ["navmesh.build", "nothing is walkable"]),
        ("{build: {cell_m: 0.0001}}", ["navmesh.build", "too many", "larger"]),
    ],
)
def test_mistakes(navmesh: str, words: list[str], tmp_path: Path) -> None:
    with pytest.raises(BadInput) as found:
        load_level(yard(tmp_path, navmesh))
    assert all(word in str(found.value) for word in words), str(found.value)


def test_a_level_without_a_navmesh_is_explored(tmp_path: Path) -> None:
    out = tmp_path / "out"
    command = ["run", str(yard(tmp_path, "{build: {}}")), "--out", str(out), "--quiet"]
    done = CliRunner().invoke(app, command)
    assert isinstance(done.exception, SystemExit | None), done.exception
    assert done.exit_code in (0, 1, 4), done.output
    report = json.loads((out / "report.json").read_text())
    assert report["coverage"]["goals_total"] > 5
    assert report["coverage"]["goals_reached"] > 0


def test_faces_is_one_of_two_words(tmp_path: Path) -> None:
    command = ["navmesh", "build", str(yard(tmp_path, "{build: {}}")), "-o", str(tmp_path / "nav.glb")]
    assert CliRunner().invoke(app, [*command, "--faces", "down"]).exit_code == 2
    assert CliRunner().invoke(app, [*command, "--faces", "any"]).exit_code == 0


def test_a_file_that_cannot_be_written_is_said_before_anything_is_built(tmp_path: Path) -> None:
    file = yard(tmp_path, "{build: {}}")
    for out, word in (("nav.bin", "write one of .glb, .obj"), ("gone/nav.glb", "there is no folder")):
        done = CliRunner().invoke(app, ["navmesh", "build", str(file), "-o", str(tmp_path / out)])
        assert isinstance(done.exception, BadInput)
        assert word in str(done.exception)
