"""A whole MCAP file out of one that was cut off by a kill or a full disk."""

from __future__ import annotations

import os
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from reachtest.errors import BadInput, Problem
from reachtest.logs.channels import mcap_writer


def recover(source: Path, target: Path | None = None) -> int:
    """Copy every whole chunk of `source` into a finished file `target`; returns the number of messages saved.

    `target` defaults to the name that the run would have given the file (`.run.mcap.part` -> `run.mcap`),
    else to `<name>.recovered.mcap` beside `source`. With nothing to save, 0 is returned and nothing is
    written. A file that is not MCAP raises BadInput, one that cannot be read OSError.
    """
    target = target or default_target(source)
    part = target.with_name(f".{target.name}.recovering")
    _check_magic(source)
    with source.open("rb") as damaged, part.open("wb") as stream:
        writer = mcap_writer(stream)
        copy = _Copy(writer)
        saved = sum(copy.chunk(records) for records in _whole_chunks(damaged))
        writer.finish()
    if saved:
        os.replace(part, target)
    else:
        part.unlink()
    return saved


def default_target(source: Path) -> Path:
    """Where `recover` puts what it saves unless told otherwise."""
    if source.name.startswith(".") and source.name.endswith(".part"):
        return source.with_name(source.name[1 : -len(".part")])
    return source.with_name(f"{source.stem}.recovered.mcap")


def _check_magic(source: Path) -> None:
    from mcap.writer import MCAP0_MAGIC

    with source.open("rb") as stream:
        magic = stream.read(len(MCAP0_MAGIC))
    if magic != MCAP0_MAGIC:
        raise BadInput(
            [Problem(str(source), "not an MCAP file", "give the .part file that the run left")], source
        )


def _whole_chunks(stream: Any) -> Iterator[list[Any]]:
    """The records of each chunk, up to the first that is cut off or whose checksum is wrong."""
    from mcap.exceptions import McapError
    from mcap.records import Chunk
    from mcap.stream_reader import StreamReader, breakup_chunk
    from zstandard import ZstdError

    try:
        for record in StreamReader(stream, emit_chunks=True).records:
            if isinstance(record, Chunk):
                yield breakup_chunk(record, validate_crc=True)
    except (McapError, ZstdError, struct.error, ValueError):
        return  # the cut: nothing after it can be trusted


class _Copy:
    """Repeats records in another file, where schemas and channels may get other numbers."""

    def __init__(self, writer: Any) -> None:
        self._writer = writer
        self._schemas: dict[int, int] = {0: 0}  # 0: a channel without a schema
        self._channels: dict[int, int] = {}

    def chunk(self, records: list[Any]) -> int:
        """Copy one chunk's records; returns how many of them are messages."""
        from mcap.records import Channel, Message, Schema

        messages = 0
        for record in records:
            if isinstance(record, Schema) and record.id not in self._schemas:
                self._schemas[record.id] = self._writer.register_schema(
                    record.name, record.encoding, record.data
                )
            elif isinstance(record, Channel) and record.id not in self._channels:
                self._channels[record.id] = self._writer.register_channel(
                    record.topic, record.message_encoding, self._schemas[record.schema_id], record.metadata
                )
            elif isinstance(record, Message):
                self._message(record)
                messages += 1
        return messages

    def _message(self, message: Any) -> None:
        self._writer.add_message(
            channel_id=self._channels[message.channel_id],
            log_time=message.log_time,
            publish_time=message.publish_time,
            sequence=message.sequence,
            data=message.data,
        )
