"""The run as an MCAP file: one writer, its messages, and the rescue of a cut-off file."""

from reachtest.logs.mcap_log import McapLog
from reachtest.logs.recover import recover

__all__ = ["McapLog", "recover"]
