"""The MCAP container of a recording: what it contains, and its messages chunk by chunk."""

from __future__ import annotations

import os
import stat
import struct
import zlib
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path
from typing import BinaryIO, Dict, Iterator, List, NamedTuple, Optional, Tuple

import lz4.frame
import zstandard
from mcap.data_stream import ReadDataStream
from mcap.exceptions import InvalidMagic
from mcap.opcode import Opcode
from mcap.reader import SeekingReader
from mcap.records import Attachment, Channel, Chunk, Metadata, Schema

from ._errors import RecordingError

# Layout of recordings that this package reads; `SCHEMA_VERSION` of the recorder.
SCHEMA_VERSION = 3
MAGIC = b"\x89MCAP0\r\n"
# Limits of the recorder for the size that a chunk claims, as in `src/recording/limits.rs`.
ANY_RATIO_BYTES = 256 << 20
UNPACKED_RATIO = 192
MAX_RECORD_BYTES = 4 << 30

_RECORD = struct.Struct("<BQ")
_MESSAGE = struct.Struct("<HIQQ")


class ChunkSpan(NamedTuple):
    """Place of a chunk in the file, the log time of its first message, and the size of its content."""

    offset: int
    start_time: int
    size: int


class Payload(NamedTuple):
    """A message within the bytes of its chunk."""

    channel: int
    log_time: int
    start: int
    end: int


@dataclass
class Container:
    """Contents of a recording without its messages."""

    path: Path
    is_finished: bool
    chunks: List[ChunkSpan] = field(default_factory=list)
    channels: Dict[int, Channel] = field(default_factory=dict)
    schemas: Dict[int, Schema] = field(default_factory=dict)
    message_counts: Dict[int, int] = field(default_factory=dict)
    metadata: Dict[str, Dict[str, str]] = field(default_factory=dict)
    manifest: str = ""

    def topics(self) -> Dict[str, int]:
        """The topics with their numbers of messages, in alphabetical order."""
        counts = {channel.topic: self.message_counts.get(id, 0) for id, channel in self.channels.items()}
        return dict(sorted(counts.items()))

    def channel(self, topic: str) -> Optional[Channel]:
        """The channel of a topic."""
        return next((channel for channel in self.channels.values() if channel.topic == topic), None)


def load(path: Path, allow_torn: bool) -> Container:
    """Reads everything except the messages."""
    with open_file(path) as stream:
        size = os.fstat(stream.fileno()).st_size
        stream.seek(max(0, size - len(MAGIC)))
        is_whole = stream.read() == MAGIC and size > len(MAGIC)
        stream.seek(0)
        try:
            if stream.read(len(MAGIC)) != MAGIC:
                raise InvalidMagic(())
            stream.seek(0)
            reader = SeekingReader(stream, validate_crcs=True)
            library = reader.get_header().library
        except Exception as error:
            raise RecordingError(f"{path} is not an MCAP file", "pass a recording (*.mcap)") from error
        if library != "kinetoscope":
            raise RecordingError(
                f"{path} was written by `{library}`, not by Kinetoscope",
                "read it with the package `mcap`",
            )
        if is_whole:
            try:
                container = _from_summary(path, reader)
            except RecordingError:
                raise
            except Exception as error:
                raise damaged(path, f"its index cannot be read ({error!r})") from error
            if container is not None:
                return container
        if not allow_torn:
            raise RecordingError(
                f"{path} has no end: the file is torn, or its run is in progress or was interrupted",
                "run the same experiment again to complete it, or read its intact frames with "
                "`kinetoscope.Run(path, allow_torn=True)`",
            )
        return _from_records(path, stream, size)


def open_file(path: Path) -> BinaryIO:
    """Opens a regular file; a pipe or a device in its place does not block."""
    try:
        if not stat.S_ISREG(os.stat(path).st_mode):
            raise RecordingError(f"{path} is not a file", "pass a recording (*.mcap)")
        return open(path, "rb")
    except OSError as error:
        raise RecordingError(
            f"{path} cannot be read: {error.strerror}", "check the path, or run the experiment first"
        ) from error


def damaged(path: Path, what: str) -> RecordingError:
    """The error for bytes that differ from the recorded ones."""
    return RecordingError(
        f"{path} is damaged: {what}",
        "`kinetoscope verify FILE` reports what is intact; `kinetoscope run --force` records it again",
    )


def check_schema(path: Path, metadata: Dict[str, Dict[str, str]]) -> None:
    """Rejects a recording of another schema version, with both versions."""
    provenance = metadata.get("kinetoscope")
    if provenance is None or "schema_version" not in provenance:
        raise damaged(path, "it has no provenance")
    version = provenance["schema_version"]
    if version == str(SCHEMA_VERSION):
        return
    is_newer = version.isdecimal() and int(version) > SCHEMA_VERSION
    written_by = provenance.get("program_version", "an unknown version")
    raise RecordingError(
        f"{path} has schema version {version} (written by Kinetoscope {written_by}); "
        f"this package reads version {SCHEMA_VERSION}",
        "upgrade: `pip install --upgrade kinetoscope`" if is_newer else "record it again",
    )


def _from_summary(path: Path, reader: SeekingReader) -> Optional[Container]:
    summary = reader.get_summary()
    if summary is None:
        return None
    container = Container(path, is_finished=True)
    container.metadata = {record.name: record.metadata for record in reader.iter_metadata()}
    check_schema(path, container.metadata)
    for attachment in reader.iter_attachments():
        _keep_manifest(container, attachment)
    container.channels, container.schemas = summary.channels, summary.schemas
    if summary.statistics is not None:
        container.message_counts = summary.statistics.channel_message_counts
    container.chunks = [
        ChunkSpan(chunk.chunk_start_offset, chunk.message_start_time, chunk.uncompressed_size)
        for chunk in summary.chunk_indexes
    ]
    return container


def _keep_manifest(container: Container, attachment: Attachment) -> None:
    if attachment.name == "manifest.toml":
        container.manifest = attachment.data.decode("utf-8")


def _from_records(path: Path, stream: BinaryIO, size: int) -> Container:
    """Reads a file without an index up to its first record that is not intact."""
    container = Container(path, is_finished=False)
    at = len(MAGIC)
    while at + _RECORD.size <= size:
        stream.seek(at)
        opcode, length = _RECORD.unpack(stream.read(_RECORD.size))
        end = at + _RECORD.size + length
        if end > size or opcode in (0, Opcode.DATA_END, Opcode.FOOTER):
            break
        try:
            _keep_record(container, stream, opcode, at)
        except Exception:
            break
        at = end
    check_schema(path, container.metadata)
    return container


def _keep_record(container: Container, stream: BinaryIO, opcode: int, at: int) -> None:
    source = ReadDataStream(stream)
    if opcode == Opcode.METADATA:
        record = Metadata.read(source)
        container.metadata[record.name] = record.metadata
    elif opcode == Opcode.ATTACHMENT:
        _keep_manifest(container, Attachment.read(source))
    elif opcode == Opcode.CHUNK:
        chunk, content = unpack_chunk(container.path, stream, at)
        check_content(container.path, chunk, content)
        counts: Dict[int, int] = {}
        for kind, start, end in _records(container.path, content):
            if kind == Opcode.MESSAGE:
                channel_id = _MESSAGE.unpack_from(content, start)[0]
                counts[channel_id] = counts.get(channel_id, 0) + 1
            else:
                _keep_description(container, kind, content[start:end])
        # A chunk counts once all of it is intact.
        for channel_id, count in counts.items():
            container.message_counts[channel_id] = container.message_counts.get(channel_id, 0) + count
        container.chunks.append(ChunkSpan(at, chunk.message_start_time, chunk.uncompressed_size))


def _keep_description(container: Container, kind: int, body: bytes) -> None:
    source = ReadDataStream(BytesIO(body))
    if kind == Opcode.SCHEMA:
        schema = Schema.read(source)
        container.schemas[schema.id] = schema
    elif kind == Opcode.CHANNEL:
        channel = Channel.read(source)
        container.channels[channel.id] = channel


def unpack_chunk(path: Path, stream: BinaryIO, offset: int) -> Tuple[Chunk, bytes]:
    """A chunk and its decompressed content, whose checksum has not been compared yet."""
    stream.seek(offset)
    opcode, length = _RECORD.unpack(stream.read(_RECORD.size))
    if opcode != Opcode.CHUNK or length > MAX_RECORD_BYTES:
        raise damaged(path, f"there is no chunk at byte {offset}")
    chunk = Chunk.read(ReadDataStream(stream))
    return chunk, _unpacked(path, chunk, offset)


def check_content(path: Path, chunk: Chunk, content: bytes) -> None:
    """Compares the checksum of a chunk's content."""
    if chunk.uncompressed_crc != 0 and zlib.crc32(content) != chunk.uncompressed_crc:
        raise damaged(path, "wrong checksum of a chunk")


def _unpacked(path: Path, chunk: Chunk, offset: int) -> bytes:
    size = chunk.uncompressed_size
    if size > max(ANY_RATIO_BYTES, UNPACKED_RATIO * len(chunk.data)):
        raise damaged(path, f"the chunk at byte {offset} claims {size} bytes")
    if chunk.compression == "zstd":
        # The library allocates what the compressed data claim, whatever limit it is given.
        claimed = zstandard.frame_content_size(chunk.data)
        if claimed not in (-1, size):
            raise damaged(path, f"the chunk at byte {offset} claims {claimed} bytes")
        content = zstandard.ZstdDecompressor().decompress(chunk.data, max_output_size=size)
    elif chunk.compression == "lz4":
        content = lz4.frame.LZ4FrameDecompressor().decompress(chunk.data, max_length=size)
    elif chunk.compression == "":
        content = chunk.data
    else:
        raise damaged(path, f"unknown compression `{chunk.compression}`")
    if len(content) != size:
        raise damaged(path, f"the chunk at byte {offset} has {len(content)} bytes instead of {size}")
    return content


def _records(path: Path, content: bytes) -> Iterator[Tuple[int, int, int]]:
    """Kind, start and end of each record of a chunk."""
    at, size = 0, len(content)
    while at < size:
        if at + _RECORD.size > size:
            raise damaged(path, "a chunk ends inside a record")
        kind, length = _RECORD.unpack_from(content, at)
        start = at + _RECORD.size
        at = start + length
        if at > size or (kind == Opcode.MESSAGE and length < _MESSAGE.size):
            raise damaged(path, "a chunk ends inside a record")
        yield kind, start, at


def payloads(path: Path, content: bytes, channel_id: int) -> Iterator[Payload]:
    """The messages of a channel in the content of a chunk."""
    for kind, start, end in _records(path, content):
        if kind == Opcode.MESSAGE:
            channel, _, log_time, _ = _MESSAGE.unpack_from(content, start)
            if channel == channel_id:
                yield Payload(channel, log_time, start + _MESSAGE.size, end)
