"""Protobuf messages into an MCAP file: channels, sequence numbers and simulated time."""

from __future__ import annotations

from collections import defaultdict
from importlib.metadata import version
from typing import IO, Any

# A kill loses the chunk in progress, so chunks are much smaller than the usual 1 MiB: see McapLog.
CHUNK_BYTES = 32 * 1024


def mcap_writer(stream: IO[bytes]) -> Any:
    """A started `mcap.writer.Writer`: zstd chunks of `CHUNK_BYTES` before compression, checksums, indexes."""
    from mcap.writer import CompressionType, Writer

    writer = Writer(stream, chunk_size=CHUNK_BYTES, compression=CompressionType.ZSTD)
    writer.start(library=f"reachtest mcap-python/{version('mcap')}")
    return writer


class Channels:
    """Writes messages to topics; a topic's channel and schema are registered with its first message."""

    def __init__(self, stream: IO[bytes]) -> None:
        self._stream = stream
        self._writer = mcap_writer(stream)
        self._schemas: dict[str, int] = {}
        self._topics: dict[str, int] = {}
        self._sequence: defaultdict[str, int] = defaultdict(int)
        self.time_ns = 0  # of the last message: log times never go back, whatever the topic

    def write(self, topic: str, message: Any, time_ns: int) -> None:
        """Append `message` at simulated time `time_ns` [ns], or at the last message's time if later."""
        if topic not in self._topics:
            self._topics[topic] = self._register(topic, type(message))
        self.time_ns = max(self.time_ns, time_ns)
        self._writer.add_message(
            channel_id=self._topics[topic],
            log_time=self.time_ns,
            publish_time=self.time_ns,
            sequence=self._sequence[topic],
            data=message.SerializeToString(deterministic=True),
        )
        self._sequence[topic] += 1

    def flush(self) -> None:
        """Hand every finished chunk to the operating system, where a kill of this process cannot lose it."""
        self._stream.flush()

    def finish(self) -> None:
        """Write the last chunk, the indexes and the footer."""
        self._writer.finish()
        self._stream.flush()

    def _register(self, topic: str, message_class: Any) -> int:
        from mcap_protobuf.schema import register_schema

        name = message_class.DESCRIPTOR.full_name
        if name not in self._schemas:
            self._schemas[name] = register_schema(self._writer, message_class)
        channel: int = self._writer.register_channel(
            topic=topic, message_encoding="protobuf", schema_id=self._schemas[name]
        )
        return channel
