"""Pieces: fewer than triangles, and the same space to collide with."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from reachtest.geometry import triangle_normals
from reachtest.records import Bools, Floats
from reachtest.world.convex import pieces_of
from reachtest.world.model import Template
from reachtest.world.pieces import PRISM_M, Pieces
from tests.levels import UNREAL, box

EVERY_AXIS = np.eye(3)


def turned(triangles: Floats, degrees: float = 33.0) -> Floats:
    a = np.radians(degrees)
    spin = np.array([[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1]])
    tilt = np.array([[1, 0, 0], [0, np.cos(0.4), -np.sin(0.4)], [0, np.sin(0.4), np.cos(0.4)]])
    return triangles @ (tilt @ spin).T


def rectangle(width: float, depth: float) -> Floats:
    a, b, c, d = [0, 0, 0], [width, 0, 0], [width, depth, 0], [0, depth, 0]
    return np.array([[a, b, c], [a, c, d]], dtype=np.float64)


def field(height: Floats) -> Floats:
    """Two triangles a cell of a grid of heights [m, n]."""
    x, y = np.meshgrid(*(np.arange(n, dtype=np.float64) for n in height.shape), indexing="ij")
    points = np.stack([x, y, height], axis=2)
    a, b, c, d = points[:-1, :-1], points[1:, :-1], points[1:, 1:], points[:-1, 1:]
    return np.stack([a, b, c, a, c, d], axis=2).reshape(-1, 3, 3)


def inside(pieces: Pieces, points: Floats, slack: float) -> Bools:
    """Which points [n, 3] lie in one of the pieces, grown by `slack`."""
    from scipy.spatial import ConvexHull

    found = np.zeros(len(points), dtype=np.bool_)
    for corners in pieces.corners:
        facets = ConvexHull(np.unique(corners, axis=0), qhull_options="QJ Pp").equations
        found |= (points @ facets[:, :3].T + facets[:, 3] <= slack).all(axis=1)
    return found


def test_a_box_is_one_box() -> None:
    pieces = pieces_of(box([1, 2, 3], [2, 4, 6]))
    assert len(pieces) == 1
    assert pieces.half[0].tolist() == [0.5, 1.0, 1.5]
    assert pieces.low[0].tolist() == [1, 2, 3]


def test_a_box_in_which_somebody_starts_keeps_its_sides() -> None:
    room = box([0, 0, 0], [4, 4, 3])
    assert len(pieces_of(room, np.array([[2.0, 2, 1]]))) == 6
    assert len(pieces_of(room, np.array([[9.0, 2, 1]]))) == 1


def test_a_room_seen_from_inside_is_no_box() -> None:
    room = box([0, 0, 0], [4, 4, 3])[:, ::-1]
    pieces = pieces_of(room)
    assert len(pieces) == 6
    assert (pieces.half.min(axis=1) == PRISM_M / 2).all()


def test_a_box_with_a_missing_side_is_no_box() -> None:
    assert len(pieces_of(box([0, 0, 0], [4, 4, 3])[2:])) == 5


def test_a_tilted_rectangle_is_a_box_that_lies_where_it_lay() -> None:
    pieces = pieces_of(turned(rectangle(3, 2)))
    assert len(pieces) == 1
    assert sorted(pieces.half[0]) == pytest.approx([PRISM_M / 2, 1.0, 1.5])
    rebuilt = (pieces.low + pieces.high)[0] / 2 + (
        np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * pieces.half[0]
    ) @ pieces.axes[0].T
    away = np.linalg.norm(rebuilt[:, None] - pieces.corners[0][None], axis=2).min(axis=1)
    assert away.max() < 1e-9


def test_two_planes_and_a_bent_arrow_stay_two_triangles() -> None:
    fold = np.array([[[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[1, 0, 0], [1, 1, 0.01], [0, 1, 0]]], dtype=float)
    arrow = np.array(
        [[[0, 0, 0], [2, 0, 0], [0.3, 0.3, 0]], [[0, 0, 0], [0.3, 0.3, 0], [0, 2, 0]]], dtype=float
    )
    assert len(pieces_of(fold)) == 2
    assert len(pieces_of(arrow)) == 2


@given(seed=st.integers(0, 10_000))
@settings(max_examples=25, deadline=None)
def test_pieces_fill_the_space_of_the_prisms(seed: int) -> None:
    """Every point of a triangle's prism is in a piece, and the other way round (where no edge is sharp)."""
    rng = np.random.default_rng(seed)
    across, along = rng.integers(1, 4, 2)
    height = rng.choice([0.0, 0.2, 0.4], (across + 1, along + 1))
    triangles = turned(field(height * rng.integers(0, 2)))
    pieces = pieces_of(triangles)
    assert len(pieces) <= len(triangles)
    normals, _ = triangle_normals(triangles)
    weight = rng.dirichlet(np.ones(3), (len(triangles), 20))
    depth = rng.uniform(0, PRISM_M, (len(triangles), 20, 1))
    points = np.einsum("fnk,fkd->fnd", weight, triangles) - depth * normals[:, None]
    assert inside(pieces, points.reshape(-1, 3), 1e-6).all()
    prisms = Pieces(
        np.concatenate(
            [triangles[:, [0, 1, 2, 2]], (triangles - PRISM_M * normals[:, None])[:, [0, 1, 2, 2]]], axis=1
        ),
        np.full(len(triangles), 8),
        np.full((len(triangles), 3), np.nan),
        np.tile(EVERY_AXIS, (len(triangles), 1, 1)),
    )
    weight = rng.dirichlet(np.ones(pieces.corners.shape[1]), (len(pieces), 40))
    points = np.einsum("fnk,fkd->fnd", weight, pieces.corners)
    assert inside(prisms, points.reshape(-1, 3), 1e-6).all()


def compiled(pieces: Pieces) -> mujoco.MjModel:
    """The same pieces through MuJoCo's own compiler, hulls as meshes."""
    spec = mujoco.MjSpec()
    body = spec.worldbody.add_body()
    for axis in np.eye(3):
        body.add_joint(type=mujoco.mjtJoint.mjJNT_SLIDE, axis=axis)
    half = UNREAL.height_m / 2
    size = [UNREAL.radius_m, half - UNREAL.radius_m, 0.0]
    body.add_geom(
        type=mujoco.mjtGeom.mjGEOM_CAPSULE, size=size, pos=[0, 0, half], mass=80, condim=1, gap=0.01
    )
    spec.option.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_MULTICCD)
    for index, corners in enumerate(pieces.corners):
        mesh = spec.add_mesh(name=f"m{index}", uservert=np.unique(corners, axis=0).ravel())
        mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL
        spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname=mesh.name, condim=1)
    return spec.compile()


def pillar(sides: int, radius: float, height: float) -> Floats:
    """A closed prism over a regular polygon."""
    angle = np.arange(sides) * 2 * np.pi / sides
    ring = np.stack([radius * np.cos(angle), radius * np.sin(angle), np.zeros(sides)], axis=1)
    top, following = ring + [0, 0, height], np.roll(np.arange(sides), -1)
    walls = [(ring, ring[following], top[following]), (ring, top[following], top)]
    lids = [(ring[:1], ring[2:], ring[1:-1]), (top[:1], top[1:-1], top[2:])]
    return np.concatenate([np.stack(np.broadcast_arrays(*corners), axis=1) for corners in walls + lids])


def test_a_filled_template_touches_what_a_compiled_model_touches() -> None:
    """18,000 capsules among boxes, quadrilaterals, triangles and pillars, tilted: the same depth and direction."""
    rng = np.random.default_rng(3)
    slab = np.array([[[0, 0, 0], [2, 0, 0], [1.5, 1, 0]], [[0, 0, 0], [1.5, 1, 0], [0.2, 1, 0]]], dtype=float)
    shapes = [box([0, 0, 0], [1, 2, 0.5]), rectangle(2, 1), slab, slab[:1], pillar(7, 0.5, 1.5)]
    some = [turned(shapes[i % 5], 40 * i) if i % 5 else shapes[0] for i in range(15)]
    triangles = np.concatenate([s + rng.uniform(-3, 3, 3) for s in some])
    pieces = pieces_of(triangles)
    assert len(pieces) == 15
    assert pieces.corners.shape[1] == pieces.count.max() == 14
    models = Template(20, UNREAL, 1 / 30, corners=14).fill(pieces), compiled(pieces)
    datas = [mujoco.MjData(model) for model in models]
    compared = 0
    for feet in rng.uniform([-4, -4, -5], 4, (18_000, 3)):
        seen = []
        for model, data in zip(models, datas, strict=True):
            data.qpos[:] = feet
            mujoco.mj_forward(model, data)
            contacts = {}
            for contact in data.contact:
                static = min(contact.geom)  # boxes are touched at two points of a capsule: the deeper one
                if static not in contacts or contact.dist < contacts[static][0]:
                    contacts[static] = (contact.dist, contact.frame[:3].copy())
            seen.append(contacts)
        # Deep inside, the nearest way out is a matter of taste: two of the same depth may differ.
        shallow = {g for g, (dist, _) in seen[1].items() if dist > -0.01}
        assert shallow <= set(seen[0])
        for geom in shallow:
            compared += 1
            assert seen[0][geom][0] == pytest.approx(seen[1][geom][0], abs=1e-3)
            assert abs(seen[0][geom][1] @ seen[1][geom][1]) > 0.99
    assert compared > 40


def wedge(length: float, width: float, height: float) -> Floats:
    """A ramp up along x, closed."""
    a, b, c, d = [0, 0, 0], [length, 0, 0], [length, width, 0], [0, width, 0]
    e, f = [length, 0, height], [length, width, height]
    faces = [(a, d, c), (a, c, b), (a, b, e), (d, f, c), (b, c, f), (b, f, e), (a, e, f), (a, f, d)]
    return np.array(faces, dtype=np.float64)


def test_closed_convex_parts_are_one_piece_whichever_way_they_are_turned() -> None:
    parts = [
        wedge(4, 2, 3),
        box([5, 0, 0], [6, 3, 2]),
        turned(box([0, 9, 0], [2, 12, 4])),
        wedge(1, 1, 1) + 20,
    ]
    pieces = pieces_of(np.concatenate(parts))
    assert pieces.is_box.tolist() == [False, True, True, False]
    assert sorted(pieces.half[2]) == pytest.approx([1.0, 1.5, 2.0])
    assert pieces.high[0].tolist() == [4, 2, 3]


@pytest.mark.parametrize("sides", [3, 5, 12, 32])
def test_a_pillar_is_one_piece(sides: int) -> None:
    pieces = pieces_of(
        np.concatenate([turned(pillar(sides, 0.7, 3)), box([9, 9, 9], [10, 10, 10]), rectangle(1, 2)])
    )
    assert pieces.count.tolist() == [2 * sides, 8, 8]
    assert pieces.is_box.tolist() == [False, True, True]
    assert np.allclose(pieces.corners[1:, 7:], pieces.corners[1:, 7:8]), "the last is repeated"


def test_a_rounder_pillar_keeps_its_sides() -> None:
    pieces = pieces_of(pillar(33, 0.7, 3))
    assert len(pieces) > 33
    assert pieces.corners.shape[1] == 8


def test_a_prism_does_not_stick_out_of_its_neighbour_at_a_sharp_edge() -> None:
    """A ramp's back, extruded inwards, would rise above the ramp by up to its own thickness."""
    open_ramp = wedge(4, 2, 3)[2:]  # no bottom: not closed
    pieces = pieces_of(open_ramp)
    assert len(pieces) > 1
    slope = np.array([-3, 0, 4]) / 5
    assert ((pieces.corners @ slope).max(axis=(0, 1))) < 1e-9
    assert pieces.low[:, 2].min() > -PRISM_M - 1e-9
