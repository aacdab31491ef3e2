"""MuJoCo models of one capsule among convex pieces: compiled once, then filled with other pieces.

Compiling takes 70 us a mesh, most of it for a hull of corners that are known to be one already; writing the arrays
of a compiled model takes a fiftieth of that. All models filled from one template have the same layout, whatever
shapes they hold, and the same height fields. Contacts are frictionless; the controller does the walking.

Shape legend: N pieces.
"""

from __future__ import annotations

import copy
from collections.abc import Sequence

import mujoco
import numpy as np

from reachtest.records import Character, Floats, HeightField
from reachtest.world.bounding import bounding_tree
from reachtest.world.pieces import CORNERS, PRISM_M, Pieces

CONTACT_SLOTS = 8
CONTACT_FIELDS = 5  # found, dist, normal
SKIN_M = 0.01  # contacts are reported from this distance on, without a force
MASS_KG = 80.0  # any: the controller plans velocities
ARENA_BYTES = 1 << 20  # for the contacts of one capsule; MuJoCo's own guess is 13 MB an agent

_DYNAMIC, _STATIC = 1, 2
_NOWHERE_M = -1e6  # 1,000 km down
_CUBE = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=np.float64)


class Template:
    """A compiled model of height fields, with room for `capacity` pieces."""

    def __init__(
        self,
        capacity: int,
        character: Character,
        timestep_s: float,
        fields: Sequence[HeightField] = (),
        corners: int = CORNERS,
    ) -> None:
        """A piece may have up to `corners`."""
        self.capacity, self._corners = capacity, corners
        self._fields = np.array([_extent(field) for field in fields]).reshape(-1, 2, 3)
        spec = mujoco.MjSpec()
        spec.memory = ARENA_BYTES
        option = spec.option
        option.timestep = timestep_s
        option.gravity = [0.0, 0.0, -character.gravity_mps2]
        # Without a warm start a step depends on position and velocity alone: less to store, nothing to forget.
        option.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_WARMSTART)
        option.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_MULTICCD)
        # Static poses are recomputed at every step unless sleeping is allowed (630 us against 46 at 40,000 geoms).
        option.enableflags |= int(mujoco.mjtEnableBit.mjENBL_SLEEP)
        _add_capsule(spec, character)
        for slot in range(capacity):
            _add_slot(spec, slot, corners)
        for number, field in enumerate(fields):
            _add_field(spec, field, number)
        self._model = spec.compile()
        for number, field in enumerate(fields):  # the compiler would stretch them
            begin = self._model.hfield_adr[number]
            self._model.hfield_data[begin : begin + field.heights.size] = _shares(field).ravel()
        # Every corner is asked: for eight that is no slower than a walk over a hull, and more are rare.
        self._model.mesh_graphadr[:] = -1

    def fill(self, pieces: Pieces) -> mujoco.MjModel:
        """A model with `pieces`, at most `capacity`; the slots that are left over lie out of everybody's reach."""
        model, count = copy.copy(self._model), len(pieces)
        centre = (pieces.low + pieces.high) / 2
        # Mesh vertices are float32: keep them small, the position of the geom is float64.
        local = (pieces.corners - centre[:, None]).astype(np.float32)
        box = pieces.is_box
        model.mesh_vert[: self._corners * count] = local.reshape(-1, 3)
        model.mesh_vertnum[:count] = pieces.count
        model.mesh_extrema[:count] = (local @ _DIRECTIONS.T).argmax(axis=1)
        model.geom_pos[:count] = centre
        model.geom_type[:count] = np.where(box, mujoco.mjtGeom.mjGEOM_BOX, mujoco.mjtGeom.mjGEOM_MESH)
        model.geom_dataid[:count][box] = -1
        half = np.where(box[:, None], pieces.half, np.abs(local).max(axis=1))
        model.geom_size[:count] = half
        model.geom_aabb[:count, :3], model.geom_aabb[:count, 3:] = 0.0, half
        model.geom_rbound[:count] = np.linalg.norm(half, axis=1)
        model.geom_quat[:count] = quaternions(pieces.axes)
        spare = np.full((self.capacity - count, 3), _NOWHERE_M)
        low = np.concatenate([pieces.low, spare, self._fields[:, 0]])
        high = np.concatenate([pieces.high, spare, self._fields[:, 1]])
        nodes = 2 * len(low) - 1
        boxes, children, leaves = bounding_tree(low, high)
        model.bvh_aabb[:nodes], model.bvh_child[:nodes], model.bvh_nodeid[:nodes] = boxes, children, leaves
        return model


# Every combination of -1, 0 and 1, in MuJoCo's order: where support mappings begin to look.
_DIRECTIONS = np.array(
    [[x, y, z] for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1)], dtype=np.float32
)


def quaternions(axes: Floats) -> Floats:
    """Unit quaternions [N, 4] (w first) of rotations given by their columns [N, 3, 3]."""
    from scipy.spatial.transform import Rotation

    if not len(axes):
        return np.empty((0, 4))
    return np.asarray(np.roll(Rotation.from_matrix(axes).as_quat(), 1, axis=1))


def _add_slot(spec: mujoco.MjSpec, slot: int, corners: int) -> None:
    # One face keeps the mesh's own bounding tree, which nothing here asks, as small as it gets; so does a hull of
    # eight corners with the room for others inside.
    room = np.linspace(0.1, 0.9, corners - CORNERS)[:, None] * _CUBE[0]
    mesh = spec.add_mesh(name=f"m{slot}", uservert=np.concatenate([_CUBE, room]).ravel(), userface=[0, 1, 2])
    mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL
    spec.worldbody.add_geom(
        type=mujoco.mjtGeom.mjGEOM_MESH,
        meshname=mesh.name,
        pos=[0.0, 0.0, _NOWHERE_M],
        condim=1,
        contype=_STATIC,
        conaffinity=_DYNAMIC,
    )


def _extent(field: HeightField) -> tuple[Floats, Floats]:
    """Lowest and highest corner [3] of a height field with what lies under it."""
    low, high = field.heights.min() - PRISM_M, field.heights.max()
    return np.append(field.low, low), np.append(field.high, high)


def _span(field: HeightField) -> float:
    """The height [m] of a share of 1: MuJoCo wants it positive, also of a plane."""
    return max(float(np.ptp(field.heights)), PRISM_M)


def _shares(field: HeightField) -> Floats:
    """Heights [R, C] above the lowest, in spans."""
    return np.asarray((field.heights - field.heights.min()) / _span(field))


def _add_field(spec: mujoco.MjSpec, field: HeightField, number: int) -> None:
    rows, columns = field.heights.shape
    size = [*(field.high - field.low) / 2, _span(field), PRISM_M]
    spec.add_hfield(name=f"h{number}", nrow=rows, ncol=columns, size=size, userdata=_shares(field).ravel())
    spec.worldbody.add_geom(
        type=mujoco.mjtGeom.mjGEOM_HFIELD,
        hfieldname=f"h{number}",
        pos=[*(field.low + field.high) / 2, field.heights.min()],
        condim=1,
        contype=_STATIC,
        conaffinity=_DYNAMIC,
    )


def _add_capsule(spec: mujoco.MjSpec, character: Character) -> None:
    body = spec.worldbody.add_body(name="character")
    body.sleep = mujoco.mjtSleepPolicy.mjSLEEP_NEVER
    for axis in np.eye(3):
        body.add_joint(type=mujoco.mjtJoint.mjJNT_SLIDE, axis=axis)
    half = character.height_m / 2
    body.add_geom(
        name="capsule",
        type=mujoco.mjtGeom.mjGEOM_CAPSULE,
        size=[character.radius_m, half - character.radius_m, 0.0],
        pos=[0.0, 0.0, half],
        mass=MASS_KG,
        condim=1,
        contype=_DYNAMIC,
        conaffinity=_STATIC,
        gap=SKIN_M,
    )
    sensor = spec.add_sensor(
        name="contacts",
        type=mujoco.mjtSensor.mjSENS_CONTACT,
        objtype=mujoco.mjtObj.mjOBJ_GEOM,
        objname="capsule",
    )
    bits = mujoco.mjtConDataField
    data = 1 << int(bits.mjCONDATA_FOUND) | 1 << int(bits.mjCONDATA_DIST) | 1 << int(bits.mjCONDATA_NORMAL)
    sensor.intprm = [data, 1, CONTACT_SLOTS]  # reduce 1: the closest first
