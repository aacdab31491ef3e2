"""MJCF files as geometry, held against MuJoCo's own opinion of where the surfaces are."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from reachtest.levels import load_level
from reachtest.levels.meshes.mjcf import read_mjcf
from reachtest.levels.meshes.scene import Piece
from reachtest.levels.meshes.solids import find_leaks
from tests.unit.levels.make import WriteLevel, only_problem

FLOOR = {"box": {"center": [0, 0, -0.5], "size": [20, 20, 1]}}
L_SHAPE = "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nv 1 3 0\nv 0 3 0\n"  # concave: its hull has another face
L_SHAPE += "v 0 0 4\nv 2 0 4\nv 2 1 4\nv 1 1 4\nv 1 3 4\nv 0 3 4\n"
L_SHAPE += "f 4 3 2\nf 4 2 1\nf 4 1 6\nf 4 6 5\nf 10 8 9\nf 10 7 8\nf 10 12 7\nf 10 11 12\n"
L_SHAPE += "".join(
    f"f {a} {b} {b + 6}\nf {a} {b + 6} {a + 6}\n" for a, b in [(1, 2), (2, 3), (3, 4), (4, 5), (5, 6), (6, 1)]
)
TURNED = 'pos="1 2 3" euler="20 30 40"'


def mjcf(body: str, asset: str = "") -> str:
    return f"<mujoco><asset>{asset}</asset><worldbody>{body}</worldbody></mujoco>"


def read(folder: Path, text: str) -> list[Piece]:
    (folder / "a.xml").write_text(text)
    return read_mjcf(text.encode(), folder / "a.xml")


def with_mjcf(write_level: WriteLevel, text: str, **keys: Any) -> Path:
    """The small level with an MJCF file beside its floor."""
    path = write_level(geometry=[FLOOR, {"mesh": "a.xml", **keys}], spawns=[[-5, -5, 0]])
    (path.parent / "a.xml").write_text(text)
    return path


def ray_distances(path: Path, starts: np.ndarray, ways: np.ndarray) -> np.ndarray:
    """Where MuJoCo's own rays meet the geoms of the file [B]; -1: nowhere."""
    import mujoco

    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    geom = np.zeros(1, dtype=np.int32)
    return np.array(
        [
            mujoco.mj_ray(model, data, start, way, None, 1, -1, geom)
            for start, way in zip(starts, ways, strict=True)
        ]
    )


def our_distances(pieces: list[Piece], starts: np.ndarray, ways: np.ndarray) -> np.ndarray:
    """The same in the triangles that were read."""
    import trimesh

    triangles = np.concatenate([piece.triangles for piece in pieces])
    mesh = trimesh.Trimesh(triangles.reshape(-1, 3), np.arange(3 * len(triangles)).reshape(-1, 3))
    places, rays, _ = mesh.ray.intersects_location(starts, ways)
    distances = np.full(len(starts), np.inf)
    np.minimum.at(distances, rays, np.linalg.norm(places - starts[rays], axis=1))
    return np.where(np.isinf(distances), -1, distances)


MESH_ASSET = '<mesh name="l" file="l.obj" scale="0.5 0.5 0.5" refpos="1 0 0" refquat="1 0.2 0 0"/>'
FIELD_ASSET = '<hfield name="h" nrow="3" ncol="4" size="3 2 1.5 0.5" elevation="0 1 2 3 9 5 1 2 4 0 7 3"/>'
GEOMS = {  # body, assets, how far rays may differ [m]
    "box": (f'<geom type="box" size="1 2 .5" {TURNED}/>', "", 1e-6),
    "plane": (f'<geom type="plane" size="3 2 1" {TURNED}/>', "", 1e-6),
    "mesh": (f'<geom type="mesh" mesh="l" {TURNED}/>', MESH_ASSET, 1e-4),
    "hfield": (f'<geom type="hfield" hfield="h" {TURNED}/>', FIELD_ASSET, 1e-4),
    "sphere": (f'<geom type="sphere" size="2" {TURNED}/>', "", 0.02),
    "capsule": (f'<geom type="capsule" size="1 2" {TURNED}/>', "", 0.02),
    "cylinder": (f'<geom type="cylinder" size="1 2" {TURNED}/>', "", 0.02),
    "ellipsoid": (f'<geom type="ellipsoid" size="1 2 1.5" {TURNED}/>', "", 0.02),
}


@pytest.mark.parametrize("kind", GEOMS)
def test_rays_hit_the_triangles_where_mujoco_hits_the_geom(tmp_path: Path, kind: str) -> None:
    geom, asset, tolerance = GEOMS[kind]
    (tmp_path / "l.obj").write_text(L_SHAPE)
    pieces = read(tmp_path, mjcf(f'<body pos=".5 0 0" euler="0 0 70"><body>{geom}</body></body>', asset))
    corners = pieces[0].triangles.reshape(-1, 3)
    rng = np.random.default_rng(3)
    targets = rng.uniform(corners.min(axis=0), corners.max(axis=0), (300, 3))
    ways = rng.normal(size=(300, 3))
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    starts = targets - 15 * ways
    theirs, ours = ray_distances(tmp_path / "a.xml", starts, ways), our_distances(pieces, starts, ways)
    if kind == "plane":  # MuJoCo's rays go through it from below
        ours[theirs < 0] = -1
    both = (theirs >= 0) & (ours >= 0)
    assert both.sum() > 50
    assert ((theirs >= 0) != (ours >= 0)).sum() <= 6  # at the silhouettes
    # Where a ray only grazes a round shape, little depth becomes much length: hence a quantile.
    assert np.quantile(np.abs(theirs - ours)[both], 0.9) <= tolerance


@pytest.mark.parametrize("kind", sorted(set(GEOMS) - {"plane"}))
def test_surfaces_are_closed_and_face_outwards(tmp_path: Path, kind: str) -> None:
    geom, asset, _ = GEOMS[kind]
    (tmp_path / "l.obj").write_text(L_SHAPE)
    (piece,) = read(tmp_path, mjcf(geom, asset))
    assert find_leaks(piece.triangles).closed
    assert np.linalg.det(piece.triangles - piece.vertices.mean(axis=0)).sum() > 0


@pytest.mark.parametrize("kind", ["sphere", "capsule", "cylinder"])
def test_round_shapes_stay_within_half_a_percent(tmp_path: Path, kind: str) -> None:
    (piece,) = read(tmp_path, mjcf(f'<geom type="{kind}" size="1 2"/>'))
    half = {"sphere": 0, "capsule": 2, "cylinder": 2}[kind]

    def radius(places: np.ndarray) -> np.ndarray:
        """Distance from the line or point that the shape is round about."""
        height = np.clip(places[..., 2], -half, half)
        return np.linalg.norm(places - np.stack([0 * height, 0 * height, height], axis=-1), axis=-1)

    corners = piece.triangles
    if kind == "cylinder":
        corners = corners[np.ptp(corners[..., 2], axis=1) > 0]  # not its flat ends
    assert radius(corners).max() <= 1 + 1e-6
    weights = np.random.default_rng(1).dirichlet(np.ones(3), 200)
    inside = [radius(corners)] + [radius(np.einsum("c,fci->fi", weight, corners)) for weight in weights]
    assert min(values.min() for values in inside) >= 0.995


def test_only_static_geoms_that_collide_and_one_part_for_each(write_level: WriteLevel) -> None:
    box = 'type="box" size="1 1 1"'
    text = mjcf(
        f"""<geom name="wall" {box} contype="0" conaffinity="1"/>
        <geom name="decal" {box} contype="0" conaffinity="0"/>
        <body name="hut"><geom {box}/><body><geom name="roof" {box}/></body></body>
        <body name="door"><joint type="hinge"/><geom name="panel" {box}/>
            <body><geom name="handle" {box}/></body></body>"""
    )
    level = load_level(with_mjcf(write_level, text))
    assert [part.name for part in level.parts] == ["box 0", "wall", "hut geom 2", "roof"]
    assert len(level.collision) == 12 * 4
    level = load_level(with_mjcf(write_level, text, nodes=["roof", "w*"]))
    assert [part.name for part in level.parts] == ["box 0", "wall", "roof"]


def test_metres_and_z_up_whatever_the_frame(write_level: WriteLevel) -> None:
    path = write_level(
        frame={"up_axis": "y", "units": "cm"},
        geometry=[{"mesh": "a.xml"}],
        navmesh={"mesh": "nav.obj", "up_axis": "z", "units": "m"},
    )
    (path.parent / "a.xml").write_text(mjcf('<geom type="box" size="9 10 3" pos="0 0 -3"/>'))
    collision = load_level(path).collision
    np.testing.assert_allclose(
        [collision.min(axis=(0, 1)), collision.max(axis=(0, 1))], [[-9, -10, -6], [9, 10, 0]]
    )


def test_visible_mesh_not_its_hull(write_level: WriteLevel) -> None:
    path = with_mjcf(
        write_level, mjcf('<geom type="mesh" mesh="l"/>', '<mesh name="l" file="l.obj"/>'), role="both"
    )
    (path.parent / "l.obj").write_text(L_SHAPE)
    level = load_level(path)
    assert np.linalg.det(level.solids[0].triangles).sum() / 6 == pytest.approx((2 + 2) * 4, rel=1e-5)
    (path.parent / "l.obj").write_text(L_SHAPE.replace(" 4\n", " 5\n"))
    assert load_level(path).sha256 != level.sha256  # what the file names is part of the level


@pytest.mark.parametrize(
    ("text", "found", "remedy"),
    [
        (
            mjcf('<geom name="ground" type="plane" size="0 0 1"/>'),
            "infinite planes: ground",
            'size="50 50 1"',
        ),
        (mjcf('<geom type="ball" size="1"/>'), "cannot be compiled by MuJoCo", "viewer"),
        (mjcf('<geom type="mesh" mesh="l"/>', '<mesh name="l" file="no.obj"/>'), "no.obj", "viewer"),
        ("<mujoco><worldbody>", "cannot be compiled by MuJoCo", "viewer"),
        ("", "is empty: 0 bytes", "again"),
        (mjcf('<geom size="1" contype="0" conaffinity="0"/>'), "no static geom that collides", "contype"),
        (
            mjcf(
                '<geom type="hfield" hfield="h"/>',
                '<hfield name="h" nrow="1500" ncol="1500" size="1 1 1 1"/>',
            ),
            "the height field 'h', which has 1500 x 1500 samples",
            "coarsely",
        ),
    ],
)
def test_unusable_file(write_level: WriteLevel, text: str, found: str, remedy: str) -> None:
    where, what, then = only_problem(with_mjcf(write_level, text))
    assert where == "level.yaml: geometry[1].mesh"
    assert what.startswith("a.xml")
    assert found in what
    assert remedy in then
