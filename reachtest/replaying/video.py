"""A repeated path as a film: MP4 through ffmpeg, GIF through Pillow, drawn by MuJoCo."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from reachtest.errors import BadInput, Problem
from reachtest.geometry import near_from_above
from reachtest.records import Floats, Level
from reachtest.replaying.repeat import Repeated
from reachtest.replaying.show import way_of, with_place

SIZE = (640, 400)  # width, height
FPS = 15
MAX_FRAMES = 900  # a minute; longer ways are shown faster
AROUND_M = 60.0  # of the level around the way that is drawn
TURN_FRAMES = 25  # the camera turns behind the character in about two seconds
_GL_HELP = (
    "install an OpenGL that needs no screen: libegl1 (with a GPU driver or libgl1-mesa-dri), or libosmesa6,"
    " and set MUJOCO_GL=egl or MUJOCO_GL=osmesa"
)
_FFMPEG_HELP = "install ffmpeg or 'pip install imageio-ffmpeg', or ask for a .gif"


def check_video(path: Path, level: Level, opengl: str | None = None) -> None:
    """Draw one frame: raises BadInput where `write_video` would, before anything is simulated for it."""
    _encoder(path)
    with tempfile.TemporaryDirectory() as folder:
        job = Path(folder) / "job.npz"
        _write_job(job, level, level.spawns[0].position[None], np.zeros((0, 3)))
        for _ in _draw(job, 1, opengl):
            pass


def write_video(path: Path, level: Level, repeated: Repeated, opengl: str | None = None) -> None:
    """Draw the way to `path`, by its ending; `opengl` is what MUJOCO_GL asks for.

    Raises BadInput where OpenGL or ffmpeg is missing.
    """
    encoder = _encoder(path)
    with tempfile.TemporaryDirectory() as folder:
        job = Path(folder) / "job.npz"
        frames = _prepare(job, level, repeated)
        drawn = _draw(job, frames, opengl)
        if encoder is None:
            with_place(path, lambda part: _gif(part, drawn))
        else:
            with_place(path, lambda part: _mp4(part, encoder, drawn))


def _prepare(job: Path, level: Level, repeated: Repeated) -> int:
    """Write what is to be drawn; returns the number of frames."""
    way = way_of(repeated)
    step_s = level.explore.action_repeat / level.explore.physics_hz
    frames = int(np.clip(round((len(way) - 1) * step_s * FPS), 2, MAX_FRAMES))
    at = np.linspace(0, len(way) - 1, frames)
    places = np.stack([np.interp(at, np.arange(len(way)), way[:, axis]) for axis in range(3)], axis=1)
    exit_point = repeated.finding.exit_point
    marks = np.array([] if exit_point is None else [exit_point], dtype=np.float64).reshape(-1, 3)
    _write_job(job, level, places, marks)
    return frames


def _write_job(job: Path, level: Level, places: Floats, marks: Floats) -> None:
    """What `render` draws: the character at each of `places` [frames, 3], and `marks` [n, 3]."""
    centre = places.mean(axis=0)  # the graphics card counts in float32
    np.savez(
        job,
        triangles=_around(places, level.collision) - centre,
        solids=_around(places, _without_collision(level)) - centre,
        places=places - centre,
        headings=_headings(places),
        marks=marks - centre,
        size=np.array(SIZE),
        radius_m=level.character.radius_m,
        height_m=level.character.height_m,
    )


def _around(places: Floats, triangles: Floats) -> Floats:
    """Those of `triangles` [F, 3, 3] near a way, seen from above."""
    return triangles[near_from_above(triangles, [places], AROUND_M)]


def _without_collision(level: Level) -> Floats:
    """The triangles [G, 3, 3] of solids that are no collision geometry as well."""
    drawn = {triangle.tobytes() for triangle in level.collision}
    alone = [solid.triangles for solid in level.solids if solid.triangles[0].tobytes() not in drawn]
    return np.concatenate([np.zeros((0, 3, 3)), *alone])


def _headings(places: Floats) -> Floats:
    """Where the camera looks [frames] [degrees]: along the way, without haste."""
    ahead = places[np.minimum(np.arange(len(places)) + TURN_FRAMES, len(places) - 1)] - places
    behind = places - places[np.maximum(np.arange(len(places)) - TURN_FRAMES, 0)]
    along = (ahead + behind)[:, :2]
    along[np.linalg.norm(along, axis=1) < 0.5] = np.nan
    angle = np.arctan2(along[:, 1], along[:, 0])
    known = np.isfinite(angle)
    if not known.any():
        return np.full(len(places), 90.0)
    angle = np.interp(np.arange(len(places)), np.flatnonzero(known), np.unwrap(angle[known]))
    smooth = np.pad(angle, TURN_FRAMES, mode="edge")
    kernel = np.ones(2 * TURN_FRAMES + 1) / (2 * TURN_FRAMES + 1)
    return np.degrees(np.convolve(smooth, kernel, mode="valid"))


def _backends(chosen: str | None) -> list[str]:
    """What to try, the user's choice alone if there is one."""
    if chosen:
        return [chosen]
    return ["egl", "osmesa"] if sys.platform.startswith("linux") else [""]


def _draw(job: Path, frames: int, opengl: str | None) -> Iterator[bytes]:
    """The frames as raw RGB, from the first OpenGL that can draw. Raises BadInput where none can."""
    said = []
    size = SIZE[0] * SIZE[1] * 3
    for backend in _backends(opengl):
        environment = os.environ | ({"MUJOCO_GL": backend} if backend else {})
        with tempfile.TemporaryFile() as errors:
            command = [sys.executable, "-m", "reachtest.replaying.render", str(job)]
            worker = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=errors, env=environment)
            assert worker.stdout is not None
            try:
                first = worker.stdout.read(size)
                if len(first) == size:
                    yield first
                    for _ in range(frames - 1):
                        yield worker.stdout.read(size)
                    return
            finally:
                worker.stdout.close()
                worker.wait()
            errors.seek(0)
            last = errors.read().decode(errors="replace").strip().splitlines()[-1:] or ["no message"]
            said.append(f"{backend or 'default'}: {last[0]}")
    found = f"MuJoCo cannot draw here ({'; '.join(said)})"
    raise BadInput([Problem("command line: --video", found, _GL_HELP)])


def _gif(part: Path, frames: Iterator[bytes]) -> None:
    from PIL import Image

    images = [Image.frombytes("RGB", SIZE, frame).quantize(128) for frame in frames]
    images[0].save(
        part, format="GIF", save_all=True, append_images=images[1:], duration=round(1000 / FPS), loop=0
    )


def _encoder(path: Path) -> str | None:
    """The program that makes the film at `path`; None: no other. Raises BadInput."""
    if path.suffix.lower() not in (".mp4", ".gif"):
        found = f"'{path.name}' is no film that can be made"
        raise BadInput([Problem("command line: --video", found, "let it end in .mp4 or .gif")])
    return _ffmpeg() if path.suffix.lower() == ".mp4" else None


def _ffmpeg() -> str:
    """The encoder to run. Raises BadInput."""
    if path := shutil.which("ffmpeg"):
        return path
    try:
        from imageio_ffmpeg import get_ffmpeg_exe  # type: ignore[import-not-found, unused-ignore]

        return str(get_ffmpeg_exe())
    except (ImportError, RuntimeError) as error:
        found = "an MP4 needs ffmpeg, which is not there"
        raise BadInput([Problem("command line: --video", found, _FFMPEG_HELP)]) from error


def _mp4(part: Path, encoder: str, frames: Iterator[bytes]) -> None:
    size = f"{SIZE[0]}x{SIZE[1]}"
    source = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-s", size, "-r", str(FPS), "-i", "-"]
    target = ["-pix_fmt", "yuv420p", "-movflags", "+faststart", "-f", "mp4", str(part)]
    first = next(frames)  # no OpenGL: said before there is a file
    with tempfile.TemporaryFile() as errors:
        command = [encoder, "-y", "-loglevel", "error", *source, *target]
        process = subprocess.Popen(command, stdin=subprocess.PIPE, stderr=errors)
        assert process.stdin is not None
        try:
            process.stdin.write(first)
            for frame in frames:
                process.stdin.write(frame)
            process.stdin.close()
        except BrokenPipeError:
            pass  # it has said why
        if process.wait() != 0:
            errors.seek(0)
            found = f"ffmpeg failed: {errors.read().decode(errors='replace').strip()[-200:]}"
            raise BadInput([Problem("command line: --video", found, _FFMPEG_HELP)])
