"""run.mcap as a viewer meets it: read back with the reference reader and decoder."""

from __future__ import annotations

import itertools
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory

from reachtest.errors import BadInput
from reachtest.interfaces import Observer
from reachtest.logs import McapLog
from reachtest.records import ReplayPath
from tests.unit.logs.make_log import AGENTS, ROUND_S, make_findings, make_round, write_log
from tests.unit.report.make import FLOOR, make_finding, make_level, make_path

ROUNDS = 20
SCHEMAS = {
    "/tf": "foxglove.FrameTransform",
    "/level": "foxglove.SceneUpdate",
    "/navmesh": "foxglove.SceneUpdate",
    "/coverage": "foxglove.PointCloud",
    "/agents": "foxglove.PosesInFrame",
    "/findings": "foxglove.SceneUpdate",
    "/findings/points": "foxglove.PointCloud",
    "/log": "foxglove.Log",
}


@pytest.fixture(scope="module")
def run_mcap(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_log(tmp_path_factory.mktemp("log") / "run.mcap", ROUNDS, make_findings())


def messages(path: Path, topic: str | None = None) -> list[Any]:
    """Decoded messages as (channel, message, decoded)."""
    with path.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True, decoder_factories=[DecoderFactory()])
        found = reader.iter_decoded_messages(topics=None if topic is None else [topic])
        return [(item.channel, item.message, item.decoded_message) for item in found]


def decoded(path: Path, topic: str) -> list[Any]:
    return [message for _, _, message in messages(path, topic)]


def summary(path: Path) -> Any:
    with path.open("rb") as stream:
        return make_reader(stream).get_summary()


def xyz(cloud: Any) -> np.ndarray[Any, np.dtype[np.float32]]:
    """Positions [n, 3] of a PointCloud, unpacked by its own description of its fields."""
    offsets = {field.name: field.offset for field in cloud.fields}
    dtype = np.dtype(
        {
            "names": list("xyz"),
            "formats": ["<f4"] * 3,
            "offsets": [offsets[axis] for axis in "xyz"],
            "itemsize": cloud.point_stride,
        }
    )
    packed = np.frombuffer(cloud.data, dtype=dtype)
    return np.stack([packed[axis] for axis in "xyz"], axis=1)


def column(cloud: Any, name: str) -> np.ndarray[Any, np.dtype[np.uint8]]:
    offset = next(field.offset for field in cloud.fields if field.name == name)
    return np.frombuffer(cloud.data, dtype=np.uint8).reshape(-1, cloud.point_stride)[:, offset]


def test_every_topic_has_its_well_known_schema(run_mcap: Path) -> None:
    found = summary(run_mcap)
    names = {channel.topic: found.schemas[channel.schema_id].name for channel in found.channels.values()}
    assert names == SCHEMAS
    assert {schema.encoding for schema in found.schemas.values()} == {"protobuf"}
    assert {channel.message_encoding for channel in found.channels.values()} == {"protobuf"}


def test_the_statistics_count_what_is_there(run_mcap: Path) -> None:
    found = summary(run_mcap)
    counts = {
        channel.topic: found.statistics.channel_message_counts[number]
        for number, channel in found.channels.items()
    }
    once = {"/tf": 1, "/level": 1, "/navmesh": 1, "/findings": 1, "/findings/points": 1}
    assert counts == {**once, "/coverage": ROUNDS, "/agents": 8 * ROUNDS, "/log": ROUNDS // 10 + 2}
    assert len(messages(run_mcap)) == sum(counts.values()) == found.statistics.message_count
    assert found.statistics.chunk_count == len(found.chunk_indexes) > 1


def test_the_header_names_the_library(run_mcap: Path) -> None:
    with run_mcap.open("rb") as stream:
        assert "reachtest" in make_reader(stream).get_header().library


def test_time_is_simulated_and_never_goes_back(run_mcap: Path) -> None:
    with run_mcap.open("rb") as stream:
        found = [message for _, _, message in make_reader(stream).iter_messages(log_time_order=False)]
    times = [message.log_time for message in found]
    assert times == sorted(times)
    assert times == [message.publish_time for message in found]
    assert times[0] == 0
    assert times[-1] == ROUNDS * ROUND_S * 1e9


def test_sequence_numbers_have_no_gaps(run_mcap: Path) -> None:
    for topic in SCHEMAS:
        sequences = [message.sequence for _, message, _ in messages(run_mcap, topic)]
        assert sequences == list(range(len(sequences)))


def test_seeking_by_topic_and_time(run_mcap: Path) -> None:
    begin, end = round(5 * ROUND_S * 1e9), round(8 * ROUND_S * 1e9)
    with run_mcap.open("rb") as stream:
        found = list(make_reader(stream).iter_messages(["/coverage"], starting_at=begin, ending_before=end))
    assert [message.log_time for _, _, message in found] == [round(k * ROUND_S * 1e9) for k in (5, 6, 7)]


def test_coverage_holds_the_new_points_of_each_round(run_mcap: Path) -> None:
    for number, cloud in enumerate(decoded(run_mcap, "/coverage")):
        record = make_round(number)
        np.testing.assert_array_equal(xyz(cloud), record.new_points.astype(np.float32))
        np.testing.assert_array_equal(column(cloud, "expected"), record.new_expected)
        assert cloud.frame_id == "level"


def test_unexpected_points_have_another_colour(run_mcap: Path) -> None:
    cloud = decoded(run_mcap, "/coverage")[0]
    expected = column(cloud, "expected").astype(bool)
    greener = column(cloud, "green") > column(cloud, "red")
    np.testing.assert_array_equal(greener, expected)
    assert set(column(cloud, "alpha")) == {255}


def test_agents_are_where_they_were_at_that_time(run_mcap: Path) -> None:
    record = make_round(2)
    found = messages(run_mcap, "/agents")[16:24]
    for step, (_, message, poses) in zip(range(15, 128, 16), found, strict=True):
        assert message.log_time == round((2 + (step + 1) / 128) * ROUND_S * 1e9)
        known = record.trajectories[step][np.isfinite(record.trajectories[step]).all(axis=1)]
        assert len(known) == (AGENTS if step < 64 else AGENTS - 1)
        shown = [[pose.position.x, pose.position.y, pose.position.z] for pose in poses.poses]
        np.testing.assert_array_equal(shown, known.astype(np.float32))


@pytest.mark.parametrize(("topic", "lift"), [("/level", 0.0), ("/navmesh", 0.05)])
def test_triangles_are_those_of_the_level(run_mcap: Path, topic: str, lift: float) -> None:
    [entity] = decoded(run_mcap, topic)[0].entities
    [mesh] = entity.triangles
    vertices = np.array([[vertex.x, vertex.y, vertex.z] for vertex in mesh.points])
    assert len(vertices) == 4  # a square's two triangles share two corners
    corners = vertices[list(mesh.indices)].reshape(-1, 3, 3)
    np.testing.assert_allclose(corners, FLOOR + np.array([0.0, 0.0, lift]), atol=1e-6)


def test_a_transform_ties_the_level_to_the_world(run_mcap: Path) -> None:
    [transform] = decoded(run_mcap, "/tf")
    assert (transform.parent_frame_id, transform.child_frame_id) == ("world", "level")
    assert transform.rotation.w == 1.0


def test_findings_are_marked_named_and_traced(run_mcap: Path) -> None:
    fell, stuck = decoded(run_mcap, "/findings")[0].entities
    position, path = make_finding().position, make_path().positions
    sphere = fell.spheres[0].pose.position
    assert [sphere.x, sphere.y, sphere.z] == position.tolist()
    assert fell.texts[0].text == make_finding().title
    line = np.array([[point.x, point.y, point.z] for point in fell.lines[0].points])
    np.testing.assert_allclose(line, path, atol=1e-5)
    assert not stuck.lines
    assert fell.spheres[0].color != stuck.spheres[0].color
    np.testing.assert_array_equal(xyz(decoded(run_mcap, "/findings/points")[0]), [position, position])


def test_a_long_path_is_thinned_but_keeps_its_ends(tmp_path: Path) -> None:
    steps = np.cumsum(np.full((20_000, 3), 0.125), axis=0)
    steps[7] = np.nan
    path = ReplayPath(steps[0], (), steps, 2_700.0, 1, 1)
    target = write_log(tmp_path / "run.mcap", 1, (make_finding(path=path),))
    points = decoded(target, "/findings")[0].entities[0].lines[0].points
    assert 500 <= len(points) <= 1_000
    assert (points[0].x, points[-1].x) == (steps[0, 0], steps[-1, 0])


def test_log_lines_tell_progress_and_findings(run_mcap: Path) -> None:
    lines = decoded(run_mcap, "/log")
    level = lines[0].DESCRIPTOR.enum_types_by_name["Level"].values_by_number
    assert [level[line.level].name for line in lines] == ["INFO", "INFO", "ERROR", "WARNING"]
    assert "10 rounds: 250 positions, 9 of 20 goals, 1 falls" in lines[0].message
    assert make_finding().title in lines[2].message


def test_a_name_with_broken_unicode_does_not_cost_the_log(tmp_path: Path) -> None:
    target = write_log(tmp_path / "run.mcap", 1, (make_finding(title="half a pair \ud83d", id="\udc00"),))
    assert "half a pair" in decoded(target, "/findings")[0].entities[0].texts[0].text


def test_same_run_same_bytes(run_mcap: Path, tmp_path: Path) -> None:
    again = write_log(tmp_path / "run.mcap", ROUNDS, make_findings())
    assert again.read_bytes() == run_mcap.read_bytes()


def test_nothing_has_the_final_name_before_the_end(tmp_path: Path) -> None:
    target = tmp_path / "new folder" / "run.mcap"
    log: Observer = McapLog(target, make_level(), ROUND_S)
    assert isinstance(log, McapLog)
    log.on_round(make_round(0))
    assert [path.name for path in target.parent.iterdir()] == [".run.mcap.part"]
    log.close()
    assert [path.name for path in target.parent.iterdir()] == ["run.mcap"]


def test_an_exception_leaves_a_finished_file(tmp_path: Path) -> None:
    target = tmp_path / "run.mcap"

    def run() -> None:
        with McapLog(target, make_level(), ROUND_S) as log:
            log.on_round(make_round(0))
            raise RuntimeError("simulator died")

    with pytest.raises(RuntimeError, match="simulator died"):
        run()
    assert len(decoded(target, "/coverage")) == 1
    assert summary(target).statistics.message_count == len(messages(target))


def test_a_run_without_rounds_still_shows_the_level(tmp_path: Path) -> None:
    target = write_log(tmp_path / "run.mcap", 0)
    assert len(decoded(target, "/level")) == 1


def test_a_resumed_run_begins_where_it_was_resumed(tmp_path: Path) -> None:
    target = tmp_path / "run.mcap"
    with McapLog(target, make_level(), ROUND_S) as log:
        for number in (40, 41):
            log.on_round(make_round(number))
    times = [message.log_time for _, message, _ in messages(target)]
    assert (min(times), max(times)) == (round(40 * ROUND_S * 1e9), round(42 * ROUND_S * 1e9))


def test_a_round_without_new_points_writes_no_empty_cloud(tmp_path: Path) -> None:
    target = tmp_path / "run.mcap"
    with McapLog(target, make_level(), ROUND_S) as log:
        log.on_round(make_round(0, new=0))
    assert not decoded(target, "/coverage")
    assert len(decoded(target, "/agents")) == 8


def test_a_hundred_rounds_fit_in_a_megabyte(tmp_path: Path) -> None:
    assert write_log(tmp_path / "run.mcap", 100, make_findings()).stat().st_size < 1_000_000


def test_chunks_overlap_in_no_time(run_mcap: Path) -> None:
    chunks = summary(run_mcap).chunk_indexes
    for earlier, later in itertools.pairwise(chunks):
        assert earlier.message_end_time <= later.message_start_time


def test_two_runs_do_not_write_one_file(tmp_path: Path) -> None:
    first = McapLog(tmp_path / "run.mcap", make_level(), ROUND_S)
    first.on_round(make_round(0))
    with pytest.raises(BadInput, match="another run is writing there"):
        McapLog(tmp_path / "run.mcap", make_level(), ROUND_S)
    first.close()
    assert summary(tmp_path / "run.mcap") is not None
    McapLog(tmp_path / "run.mcap", make_level(), ROUND_S).close()  # once it is done the place is free
