"""MJCF: the static geoms that collide, as MuJoCo compiles them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from reachtest.geometry import grid_surface
from reachtest.levels.meshes.scene import Piece, Unreadable
from reachtest.levels.shapes.grids import grid_points, skirt, too_large
from reachtest.records import Floats, Ints

Shape = tuple[Floats, Ints]  # vertices [V, 3] in the geom's own axes, faces [F, 3]

_SUBDIVISIONS = 3  # of an icosahedron: no face is farther inside than 0.46 % of the radius
_SIDES = 36  # 0.38 % on a cylinder; 0.48 % on the caps of a capsule, which curve both ways


def read_mjcf(data: bytes, path: Path) -> list[Piece]:
    """The colliding geoms of the world and of bodies that have no joint up to it; one piece for each.

    A geom collides if its contype or conaffinity is not 0. Metres, z up, as at the start of a simulation;
    a mocap body stays where the file puts it. Round shapes become polyhedra inside of them, at most 0.5 %
    of the radius (ellipsoid: of each half axis) from the true surface. A mesh gives its own triangles,
    because those are what the designer sees, although MuJoCo itself collides with their convex hull. A
    plane is as large as it is drawn, although MuJoCo's goes on for ever. A height field is closed by walls
    and a floor at its base, as in MuJoCo.
    """
    import mujoco

    # MuJoCo keeps the meshes it has read, by the file's name and time: one edited just now would stay old.
    mujoco.mj_clearCache(mujoco.mj_getCache())
    try:
        model = mujoco.MjModel.from_xml_path(str(path))
    except ValueError as error:
        found = f"cannot be compiled by MuJoCo: {' '.join(str(error).split())}"
        raise Unreadable(found, "correct it until MuJoCo's own viewer opens it") from error
    placed = mujoco.MjData(model)
    mujoco.mj_kinematics(model, placed)
    collides = (model.geom_contype != 0) | (model.geom_conaffinity != 0)
    static = model.body_weldid[model.geom_bodyid] == 0
    chosen: list[int] = np.flatnonzero(collides & static).tolist()
    if not chosen:
        remedy = "give the level's geoms contype or conaffinity, in bodies without joints"
        raise Unreadable(f"has no static geom that collides among its {model.ngeom}", remedy)
    _refuse(model, chosen)
    pieces = []
    for geom in chosen:
        vertices, faces = _SHAPES[model.geom_type[geom]](model, geom)
        turn = placed.geom_xmat[geom].reshape(3, 3)
        pieces.append(Piece(_name(model, geom), vertices @ turn.T + placed.geom_xpos[geom], faces))
    return pieces


def _name(model: Any, geom: int) -> str:
    """The geom's own name, or its body's with its number."""
    body = model.body(model.geom_bodyid[geom]).name
    return model.geom(geom).name or f"{body} geom {geom}"


def _refuse(model: Any, chosen: list[int]) -> None:
    """Raise Unreadable for geoms that have no triangles, naming all of them."""
    kinds = model.geom_type
    if strange := [_name(model, geom) for geom in chosen if kinds[geom] not in _SHAPES]:
        raise Unreadable(f"has geoms of a kind that is not read: {_some(strange)}", "make meshes of them")
    planes = [geom for geom in chosen if kinds[geom] == _PLANE]
    if endless := [_name(model, geom) for geom in planes if min(model.geom_size[geom, :2]) <= 0]:
        remedy = 'give them half lengths, such as size="50 50 1"'
        raise Unreadable(f"has infinite planes: {_some(endless)}", remedy)
    for field in (model.geom_dataid[geom] for geom in chosen if kinds[geom] == _HFIELD):
        if problem := too_large(model.hfield_nrow[field], model.hfield_ncol[field]):
            name = model.hfield(field).name
            raise Unreadable(f"has the height field {name!r}, which {problem[0]}", problem[1])


def _some(names: list[str]) -> str:
    return ", ".join(names[:8]) + (f" and {len(names) - 8} more" if len(names) > 8 else "")


def _plane(model: Any, geom: int) -> Shape:
    x, y, _ = model.geom_size[geom]
    return np.array([[-x, -y, 0], [x, -y, 0], [x, y, 0], [-x, y, 0]]), np.array([[0, 1, 2], [0, 2, 3]])


def _hfield(model: Any, geom: int) -> Shape:
    field = model.geom_dataid[geom]
    x, y, top, base = model.hfield_size[field]
    rows, columns, start = model.hfield_nrow[field], model.hfield_ncol[field], model.hfield_adr[field]
    heights = model.hfield_data[start : start + rows * columns].reshape(rows, columns) * float(top)
    points = grid_points(heights, (2 * x, 2 * y)) - [x, y, 0]
    triangles = np.concatenate([grid_surface(points), skirt(points, -base)])
    return triangles.reshape(-1, 3), np.arange(3 * len(triangles)).reshape(-1, 3)


def _mesh(model: Any, geom: int) -> Shape:
    # The compiler moves a mesh to its centre of mass (mesh_pos, mesh_quat), and the geom the other way: the
    # geom's pose already holds both.
    mesh = model.geom_dataid[geom]
    start, first = model.mesh_vertadr[mesh], model.mesh_faceadr[mesh]
    vertices = model.mesh_vert[start : start + model.mesh_vertnum[mesh]].astype(np.float64)
    return vertices, model.mesh_face[first : first + model.mesh_facenum[mesh]].astype(np.int64)


def _ball(model: Any, geom: int) -> Shape:
    from trimesh.creation import icosphere

    size = model.geom_size[geom]
    round_ = model.geom_type[geom] == _SPHERE
    return _shape(icosphere(_SUBDIVISIONS).apply_scale(size[0] if round_ else size))


def _capsule(model: Any, geom: int) -> Shape:
    from trimesh.creation import capsule

    radius, half, _ = model.geom_size[geom]
    return _shape(capsule(2 * half, radius, count=[_SIDES, _SIDES]))


def _cylinder(model: Any, geom: int) -> Shape:
    from trimesh.creation import cylinder

    radius, half, _ = model.geom_size[geom]
    return _shape(cylinder(radius, 2 * half, sections=_SIDES))


def _box(model: Any, geom: int) -> Shape:
    from trimesh.creation import box

    return _shape(box(2 * model.geom_size[geom]))


def _shape(mesh: Any) -> Shape:
    return np.asarray(mesh.vertices, dtype=np.float64), np.asarray(mesh.faces, dtype=np.int64)


# mjtGeom, whose numbers are part of MuJoCo's interface.
_PLANE, _HFIELD, _SPHERE = 0, 1, 2
_SHAPES: dict[int, Callable[[Any, int], Shape]] = {
    _PLANE: _plane,
    _HFIELD: _hfield,
    _SPHERE: _ball,
    3: _capsule,
    4: _ball,  # an ellipsoid
    5: _cylinder,
    6: _box,
    7: _mesh,
}
"""One function and one line to read another kind."""
