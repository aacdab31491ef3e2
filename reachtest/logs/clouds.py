"""Points, poses and log lines as Foxglove messages: what Foxglove, Lichtblick and Rerun all show.

Positions are written as float32 (PointCloud) or as doubles holding a float32 (poses): at 1 km from the origin
that is still 0.06 mm, and it halves the file.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from foxglove_schemas_protobuf.FrameTransform_pb2 import FrameTransform
from foxglove_schemas_protobuf.Log_pb2 import Log
from foxglove_schemas_protobuf.PackedElementField_pb2 import PackedElementField
from foxglove_schemas_protobuf.Point3_pb2 import Point3
from foxglove_schemas_protobuf.PointCloud_pb2 import PointCloud
from foxglove_schemas_protobuf.Pose_pb2 import Pose
from foxglove_schemas_protobuf.PosesInFrame_pb2 import PosesInFrame
from foxglove_schemas_protobuf.Quaternion_pb2 import Quaternion
from foxglove_schemas_protobuf.Vector3_pb2 import Vector3
from google.protobuf.timestamp_pb2 import Timestamp
from numpy.typing import NDArray

from reachtest.records import Bools, Floats

FRAME, WORLD = "level", "world"
EXPECTED_RGBA = (60, 170, 90, 255)
UNEXPECTED_RGBA = (230, 60, 40, 255)

# One point: 20 bytes, a multiple of 4 because some viewers read x, y, z as an aligned float32 array.
POINT = np.dtype(
    {
        "names": ["x", "y", "z", "red", "green", "blue", "alpha", "expected"],
        "formats": ["<f4", "<f4", "<f4", "u1", "u1", "u1", "u1", "u1"],
        "offsets": [0, 4, 8, 12, 13, 14, 15, 16],
        "itemsize": 20,
    }
)


def stamp(time_ns: int) -> Timestamp:
    """Simulated time [ns] as a protobuf timestamp."""
    return Timestamp(seconds=time_ns // 10**9, nanos=time_ns % 10**9)


def utf8(text: str) -> str:
    """`text` without halves of surrogate pairs, which a level file can hold and protobuf refuses."""
    return text.encode("utf-8", errors="replace").decode()


def pose(position: NDArray[Any]) -> Pose:
    """An upright pose at `position` [3]."""
    x, y, z = _float32(position)
    return Pose(position=Vector3(x=x, y=y, z=z), orientation=Quaternion(w=1.0))


def point(position: NDArray[Any]) -> Point3:
    """A position [3]."""
    x, y, z = _float32(position)
    return Point3(x=x, y=y, z=z)


def _float32(position: NDArray[Any]) -> list[float]:
    rounded: list[float] = np.asarray(position, dtype=np.float32).tolist()
    return rounded


def transform(time_ns: int) -> FrameTransform:
    """world -> level, the identity: without one, Rerun places nothing."""
    return FrameTransform(
        timestamp=stamp(time_ns),
        parent_frame_id=WORLD,
        child_frame_id=FRAME,
        translation=Vector3(),
        rotation=Quaternion(w=1.0),
    )


def cloud(points: Floats, expected: Bools, time_ns: int) -> PointCloud:
    """Points [n, 3], green where `expected` [n], red elsewhere."""
    packed = np.zeros(len(points), dtype=POINT)
    for axis, name in enumerate("xyz"):
        packed[name] = points[:, axis]
    colours = np.where(np.asarray(expected)[:, None], EXPECTED_RGBA, UNEXPECTED_RGBA)
    for channel, name in enumerate(("red", "green", "blue", "alpha")):
        packed[name] = colours[:, channel]
    packed["expected"] = expected
    return PointCloud(
        timestamp=stamp(time_ns),
        frame_id=FRAME,
        pose=pose(np.zeros(3)),
        point_stride=POINT.itemsize,
        fields=[_field(name) for name in POINT.names or ()],
        data=packed.tobytes(),
    )


def _field(name: str) -> PackedElementField:
    dtype, offset = POINT.fields[name][:2]  # type: ignore[index]
    numeric = PackedElementField.FLOAT32 if dtype.kind == "f" else PackedElementField.UINT8
    return PackedElementField(name=name, offset=offset, type=numeric)


def poses(positions: Floats, time_ns: int) -> PosesInFrame:
    """The agents at one instant: `positions` [B, 3]; an agent without a position (NaN) is left out."""
    known = positions[np.isfinite(positions).all(axis=1)]
    return PosesInFrame(timestamp=stamp(time_ns), frame_id=FRAME, poses=[pose(row) for row in known])


def log_line(message: str, severity: str, time_ns: int) -> Log:
    """One line for the viewers' log panel; `severity` is "info", "warning" or "error"."""
    return Log(
        timestamp=stamp(time_ns),
        level=Log.Level.Value(severity.upper()),
        message=utf8(message),
        name="reachtest",
    )
