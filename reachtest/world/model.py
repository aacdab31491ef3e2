"""Compiles level triangles and one capsule into a MuJoCo model.

A mesh geom collides as its convex hull, so a triangle level cannot be one mesh: every triangle becomes a
prism of its own, extruded against its normal. Contacts are frictionless; the controller does the walking.
"""

from __future__ import annotations

import mujoco
import numpy as np

from reachtest.geometry import triangle_normals
from reachtest.records import Character, Floats

CONTACT_SLOTS = 8
CONTACT_FIELDS = 5  # found, dist, normal
SKIN_M = 0.01  # contacts are reported from this distance on, without a force
PRISM_M = 0.03  # thick enough to be hit by walking characters, thin enough for double-sided walls
MIN_ALTITUDE_M = 1e-3  # thinner slivers make no convex hull; the gap they leave is as thin
MASS_KG = 80.0  # any: the controller plans velocities
ARENA_BYTES = 1 << 20  # for the contacts of one capsule; MuJoCo's own guess is 13 MB an agent

_DYNAMIC, _STATIC = 1, 2
_NOWHERE = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]]) + [0.0, 0.0, -1e6]  # 1,000 km down


def usable_triangles(triangles: Floats) -> Floats:
    """The triangles [F, 3, 3] that are not slivers."""
    _, area = triangle_normals(triangles)
    longest = np.linalg.norm(triangles - np.roll(triangles, 1, axis=1), axis=2).max(axis=1)
    return triangles[2 * area > MIN_ALTITUDE_M * np.maximum(longest, 1e-12)]


def build_model(
    triangles: Floats, character: Character, timestep_s: float, prisms: int | None = None
) -> mujoco.MjModel:
    """A model with the capsule (three slide joints, origin at the feet) and one prism a usable triangle [F, 3, 3].

    Filled up to `prisms` with some that nobody gets near: models of as many prisms have the same layout.
    """
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
    missing = 0 if prisms is None else prisms - len(triangles)
    usable = np.concatenate([triangles, np.broadcast_to(_NOWHERE, (missing, 3, 3))])
    normals, _ = triangle_normals(usable)
    for index, (corners, normal) in enumerate(zip(usable, normals, strict=True)):
        # Mesh vertices are float32: keep them small, the position of the geom is float64.
        centre = corners.mean(axis=0)
        local = corners - centre
        mesh = spec.add_mesh(
            name=f"t{index}", uservert=np.concatenate([local, local - PRISM_M * normal]).ravel()
        )
        mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL
        spec.worldbody.add_geom(
            type=mujoco.mjtGeom.mjGEOM_MESH,
            meshname=mesh.name,
            pos=centre,
            condim=1,
            contype=_STATIC,
            conaffinity=_DYNAMIC,
        )
    return spec.compile()


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
