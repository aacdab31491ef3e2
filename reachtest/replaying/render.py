"""Draws the frames of a replay with MuJoCo's renderer: a program of its own, started by `video`.

`python -m reachtest.replaying.render JOB.npz` writes raw RGB frames to its standard output. It is a process of its
own because MuJoCo chooses its OpenGL (MUJOCO_GL) when it is imported, and a missing or broken one can end a process.
"""

from __future__ import annotations

import itertools
import sys
from typing import Any

import mujoco
import numpy as np

from reachtest.records import Floats

FAR_M, AIM_ABOVE_M = 9.0, 1.0
DOWN_DEG = -32.0
LEVEL_RGBA = (0.72, 0.72, 0.76, 1.0)
SOLID_RGBA = (0.85, 0.25, 0.55, 0.4)  # what one can get into: the character shows in it
CHARACTER_RGBA = np.array([0.95, 0.45, 0.1, 1.0], dtype=np.float32)
TRAIL_RGBA = np.array([0.1, 0.45, 0.95, 1.0], dtype=np.float32)
EXIT_RGBA = np.array([0.95, 0.15, 0.1, 0.8], dtype=np.float32)
TRAIL_M, MARK_M = 0.05, 0.25
SHADOW_PX = 1024  # MuJoCo's 4096 take four fifths of the time without a graphics card
MAX_TRAIL = 1500  # segments: MuJoCo draws 10,000 geoms at most


def build(triangles: Floats, solids: Floats) -> mujoco.MjModel:
    """A model that only shows `triangles` [F, 3, 3], and `solids` [G, 3, 3] that nothing collides with."""
    spec = mujoco.MjSpec()
    spec.visual.global_.offwidth, spec.visual.global_.offheight = 1920, 1080
    spec.visual.headlight.ambient, spec.visual.headlight.diffuse = [0.35] * 3, [0.4] * 3
    spec.visual.quality.shadowsize = SHADOW_PX
    spec.visual.map.zfar, spec.visual.map.znear = 200.0, 0.005
    spec.add_texture(
        name="sky",
        type=mujoco.mjtTexture.mjTEXTURE_SKYBOX,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_GRADIENT,
        rgb1=[0.55, 0.7, 0.9],
        rgb2=[0.95, 0.95, 1.0],
        width=64,
        height=384,
    )
    spec.worldbody.add_light(
        pos=[0, 0, 60], dir=[0.35, 0.2, -1], type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL, diffuse=[0.5] * 3
    )
    _show(spec, "level", triangles, LEVEL_RGBA)
    _show(spec, "solids", solids, SOLID_RGBA)
    return spec.compile()


def _show(spec: Any, name: str, triangles: Floats, colour: tuple[float, float, float, float]) -> None:
    """Add triangles [F, 3, 3] to look at, if any, each with corners of its own so that edges stay sharp."""
    if not len(triangles):
        return
    mesh = spec.add_mesh(
        name=name,
        uservert=triangles.reshape(-1).astype(np.float64),
        userface=np.arange(3 * len(triangles), dtype=np.int32),
    )
    mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL
    spec.worldbody.add_geom(
        type=mujoco.mjtGeom.mjGEOM_MESH, meshname=name, contype=0, conaffinity=0, rgba=colour
    )


def draw(job: Any) -> None:
    """Write every frame of a job to the standard output."""
    places, headings = job["places"], job["headings"]  # [frames, 3], [frames] degrees
    width, height = (int(size) for size in job["size"])
    # The mesh's own frame is moved to its centre of mass by the compiler, the geom with it: places stay as they are.
    model = build(job["triangles"], job["solids"])
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    camera = mujoco.MjvCamera()
    camera.type, camera.distance, camera.elevation = mujoco.mjtCamera.mjCAMERA_FREE, FAR_M, DOWN_DEG
    with mujoco.Renderer(model, height, width, max_geom=MAX_TRAIL + 100) as renderer:
        for number, place in enumerate(places):
            camera.lookat, camera.azimuth = place + [0, 0, AIM_ABOVE_M], headings[number]
            renderer.update_scene(data, camera)
            _add_character(renderer.scene, place, job)
            _add_trail(renderer.scene, places, number)
            for mark in job["marks"]:
                _add(renderer.scene, mujoco.mjtGeom.mjGEOM_SPHERE, [MARK_M] * 3, mark, EXIT_RGBA)
            sys.stdout.buffer.write(renderer.render().tobytes())


def _add_character(scene: Any, feet: Floats, job: Any) -> None:
    radius, height = float(job["radius_m"]), float(job["height_m"])
    size = [radius, radius, max(height / 2 - radius, 1e-3)]
    _add(scene, mujoco.mjtGeom.mjGEOM_CAPSULE, size, feet + [0, 0, height / 2], CHARACTER_RGBA)


def _add_trail(scene: Any, places: Floats, now: int) -> None:
    every = max(1, len(places) // MAX_TRAIL)
    points = places[: now + 1 : every] + [0, 0, TRAIL_M]
    for begin, end in itertools.pairwise(points):
        geom = _add(scene, mujoco.mjtGeom.mjGEOM_CAPSULE, [TRAIL_M] * 3, begin, TRAIL_RGBA)
        if geom is not None:
            mujoco.mjv_connector(geom, mujoco.mjtGeom.mjGEOM_CAPSULE, TRAIL_M, begin, end)


def _add(scene: Any, kind: Any, size: list[float], place: Floats, colour: Any) -> Any:
    if scene.ngeom >= scene.maxgeom:
        return None
    geom = scene.geoms[scene.ngeom]
    mujoco.mjv_initGeom(geom, kind, np.array(size), np.asarray(place, dtype=float), np.eye(3).ravel(), colour)
    scene.ngeom += 1
    return geom


if __name__ == "__main__":
    with np.load(sys.argv[1], allow_pickle=False) as stored:
        draw({name: stored[name] for name in stored.files})
