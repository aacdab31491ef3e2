"""What is left of run.mcap after a kill."""

from __future__ import annotations

import io
import os
import signal
import struct
import subprocess
import sys
from pathlib import Path

import pytest
from mcap.exceptions import McapError
from mcap.reader import make_reader
from mcap.records import Chunk, Message
from mcap.stream_reader import StreamReader, breakup_chunk

from reachtest.errors import BadInput
from reachtest.logs import McapLog, recover
from tests.unit.logs.make_log import ROUND_S, make_findings, make_round, write_log
from tests.unit.report.make import make_level

ROUNDS = 30


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_log(tmp_path_factory.mktemp("log") / "run.mcap", ROUNDS, make_findings())


def contents(path: Path) -> list[tuple[str, int, int, bytes]]:
    with path.open("rb") as stream:
        found = make_reader(stream, validate_crcs=True).iter_messages(log_time_order=False)
        return [
            (channel.topic, message.log_time, message.sequence, message.data) for _, channel, message in found
        ]


def chunk_ends(path: Path) -> list[int]:
    """Byte offset just behind each chunk."""
    with path.open("rb") as stream:
        summary = make_reader(stream).get_summary()
    assert summary is not None
    return [index.chunk_start_offset + index.chunk_length for index in summary.chunk_indexes]


def messages_in_chunks(path: Path) -> list[int]:
    """Number of messages in each chunk of a whole file."""
    with path.open("rb") as stream:
        chunks = [
            record for record in StreamReader(stream, emit_chunks=True).records if isinstance(record, Chunk)
        ]
    return [sum(isinstance(record, Message) for record in breakup_chunk(chunk)) for chunk in chunks]


def test_the_reference_stream_reader_gets_as_far(whole: Path) -> None:
    cut = io.BytesIO(whole.read_bytes()[: chunk_ends(whole)[2] + 50])
    found: list[object] = []
    with pytest.raises((McapError, struct.error)):
        found.extend(StreamReader(cut).records)
    assert sum(isinstance(record, Message) for record in found) == sum(messages_in_chunks(whole)[:3])


@pytest.mark.parametrize("share", [0.0, 0.02, 0.5, 0.9, 0.999])
@pytest.mark.parametrize("chunk", [1, 3, 5])
def test_a_cut_chunk_loses_itself_only(whole: Path, tmp_path: Path, chunk: int, share: float) -> None:
    before, end = chunk_ends(whole)[chunk - 1 : chunk + 1]
    damaged = tmp_path / ".run.mcap.part"
    damaged.write_bytes(whole.read_bytes()[: before + int(share * (end - before))])
    kept = sum(messages_in_chunks(whole)[:chunk])
    assert recover(damaged) == kept > 0
    assert contents(tmp_path / "run.mcap") == contents(whole)[:kept]


def test_a_flipped_bit_is_not_recovered_as_data(whole: Path, tmp_path: Path) -> None:
    data = bytearray(whole.read_bytes())
    ends = chunk_ends(whole)
    data[(ends[1] + ends[2]) // 2] ^= 0x10
    damaged = tmp_path / "run.mcap"
    damaged.write_bytes(data)
    kept = recover(damaged)
    assert kept == sum(messages_in_chunks(whole)[:2])
    assert contents(tmp_path / "run.recovered.mcap") == contents(whole)[:kept]


def test_a_whole_file_is_recovered_whole(whole: Path, tmp_path: Path) -> None:
    target = tmp_path / "copy.mcap"
    assert recover(whole, target) == len(contents(whole))
    assert contents(target) == contents(whole)


def test_a_cut_before_the_first_chunk_leaves_nothing(whole: Path, tmp_path: Path) -> None:
    damaged = tmp_path / ".run.mcap.part"
    damaged.write_bytes(whole.read_bytes()[:60])
    assert recover(damaged) == 0
    assert list(tmp_path.iterdir()) == [damaged]


def test_another_kind_of_file_is_refused(tmp_path: Path) -> None:
    other = tmp_path / "notes.txt"
    other.write_text("not a log")
    with pytest.raises(BadInput, match="not an MCAP file"):
        recover(other)
    assert list(tmp_path.iterdir()) == [other]


KILLED_RUN = """
import sys, time
from pathlib import Path
from reachtest.logs import McapLog
from tests.unit.logs.make_log import ROUND_S, make_round
from tests.unit.report.make import make_level
log = McapLog(Path(sys.argv[1]), make_level(), ROUND_S)
for number in range(30):
    log.on_round(make_round(number))
print("written", flush=True)
time.sleep(60)
"""


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="needs SIGKILL")
def test_a_kill_loses_the_last_few_rounds_only(tmp_path: Path) -> None:
    target = tmp_path / "run.mcap"
    root = Path(__file__).parents[3]
    command = [sys.executable, "-c", KILLED_RUN, str(target)]
    with subprocess.Popen(command, cwd=root, stdout=subprocess.PIPE, text=True) as run:
        assert run.stdout is not None
        assert run.stdout.readline() == "written\n"
        os.kill(run.pid, signal.SIGKILL)
    assert not target.exists()
    recover(tmp_path / ".run.mcap.part")
    rounds = max(time for topic, time, _, _ in contents(target) if topic == "/coverage") / 1e9 / ROUND_S
    assert 30 - rounds <= 5


def test_an_abandoned_log_can_be_written_again(tmp_path: Path) -> None:
    target = tmp_path / "run.mcap"
    McapLog(target, make_level(), ROUND_S).on_round(make_round(0))
    assert len(contents(write_log(target, 2))) > 0
    assert list(tmp_path.iterdir()) == [target]
