"""The log of a run."""

from __future__ import annotations

from typing import Any, List, NamedTuple, Tuple

from ._chunks import LOG
from ._container import Container
from ._errors import damaged
from ._frames import Places

# Levels of `foxglove.Log`.
LEVELS = ("unknown", "debug", "info", "warning", "error", "fatal")


class LogEntry(NamedTuple):
    """A message of the log: the frame that it belongs to, its level, such as ``warning``, and its text."""

    frame: int
    level: str
    message: str


def read(container: Container) -> Tuple[LogEntry, ...]:
    """All messages of the log."""
    channel = container.channel(LOG)
    if channel is None:
        return ()
    entries: List[LogEntry] = []
    with container.open() as stream:
        for content, log_time, start, end in Places(container, channel.id, stream).lines():
            try:
                message = _decoded(container.schemas[channel.schema_id], content[start:end])
                entries.append(LogEntry(_frame(container, log_time), LEVELS[message.level], message.message))
            except ImportError:
                raise
            except Exception as error:
                raise damaged(container.path, f"a message of {LOG} cannot be read ({error!r})") from error
    return tuple(entries)


def _decoded(schema: Any, data: bytes) -> Any:
    # Imported here: recordings of states alone are read without protobuf.
    from mcap_protobuf.decoder import DecoderFactory

    decode = DecoderFactory().decoder_for("protobuf", schema)
    if decode is None:
        raise ValueError(f"the schema {schema.name} is not Protobuf")
    return decode(data)


def _frame(container: Container, log_time: int) -> int:
    """The frame that is played at a time."""
    return round(log_time * container.layout.rate / 10**9)
