"""The MCAP container of a recording: what it contains without its messages."""

from __future__ import annotations

import os
import stat
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path
from typing import Any, BinaryIO, Dict, FrozenSet, List, NamedTuple, Optional, Tuple

from mcap.opcode import Opcode
from mcap.records import Channel, Header, Schema

from ._chunks import ChunkSpan, Descriptions, Layout, Messages, check_content, read_chunk
from ._errors import RecordingError, damaged
from ._provenance import (
    MERGED,
    OUTCOME,
    PROVENANCE,
    check_provenance,
    outcome_of,
    playback_rate,
    stored_frames,
)
from ._records import MAGIC, Place, attachment_of, body_of, checksum, metadata_of, parsed, place_at
from ._summary import Summary, read_summary

MANIFEST = "manifest.toml"
# A file up to this size is compared with its checksum when it is opened. Each chunk of a larger one has a checksum of its own.
MAX_CHECKED_BYTES = 16 << 20


class Head(NamedTuple):
    """What precedes the first chunk."""

    manifest: str
    provenance: Dict[str, str]
    end: int
    metadata: List[Tuple[Place, str]]
    attachments: List[Tuple[Place, str]]


@dataclass
class Container:
    """Contents of a recording without its messages."""

    path: Path
    # The whole recording, if it is in memory.
    content: Optional[bytes]
    layout: Layout
    descriptions: Descriptions
    manifest: str
    metadata: Dict[str, Dict[str, str]]
    chunks: List[ChunkSpan] = field(default_factory=list)
    message_counts: Dict[int, int] = field(default_factory=dict)
    is_finished: bool = False
    # What precedes each chunk, once it is known: the descriptions, and the last log time of the blocks before.
    before: List[Tuple[Descriptions, Optional[int]]] = field(default_factory=list)
    # The numbers of the frames of each topic, where they do not follow from the numbers of messages.
    frames_of: Dict[str, List[int]] = field(default_factory=dict)
    # The constants of the particles, once they are read, if the recording has them only once.
    particles: Any = None

    @property
    def schemas(self) -> Dict[int, Schema]:
        """The schemas by their numbers."""
        return self.descriptions.schemas

    def before_chunk(self, number: int) -> Tuple[Descriptions, Optional[int]]:
        """What precedes a chunk: a copy of the descriptions in earlier chunks, and the last log time of the blocks before."""
        if len(self.before) != len(self.chunks):
            self.before, known, end = [], self.descriptions.known_before(frozenset()), None
            earlier: FrozenSet[int] = frozenset()
            for chunk in self.chunks:
                self.before.append((known, end))
                if not chunk.channels <= earlier:
                    earlier |= chunk.channels
                    known = self.descriptions.known_before(earlier)
                if self.descriptions.are_scalars(chunk.channels):
                    end = chunk.end_time
        known, end = self.before[number]
        return known.copy(), end

    def open(self) -> BinaryIO:
        """The recording, to be read."""
        return open_recording(self.path, self.content)

    def topics(self) -> Dict[str, int]:
        """The topics with their numbers of messages, in alphabetical order."""
        channels = self.descriptions.channels
        counts = {channel.topic: self.message_counts.get(id, 0) for id, channel in channels.items()}
        return dict(sorted(counts.items()))

    def channel(self, topic: str) -> Optional[Channel]:
        """The channel of a topic."""
        number = self.descriptions.number_of(topic)
        return None if number is None else self.descriptions.channels[number]


def load(path: Path, allow_torn: bool, content: Optional[bytes] = None) -> Container:
    """Reads everything except the messages; with `content`, the path is a name only."""
    with open_recording(path, content) as stream:
        size = stream.seek(0, os.SEEK_END)
        stream.seek(max(0, size - len(MAGIC)))
        is_whole = stream.read() == MAGIC and size > len(MAGIC)
        header = _header(path, stream, size)
        try:
            head = _head(path, stream, size)
        except RecordingError as error:
            if header.profile != "" or not header.library.startswith("kinetoscope"):
                raise RecordingError(
                    f"{path} was written by `{header.library}`, not by Kinetoscope",
                    "read it with the package `mcap`",
                ) from error
            if is_whole or allow_torn:
                raise
            raise _without_end(path) from error
        if is_whole:
            try:
                summary = read_summary(path, stream, size, head.end)
                if summary is not None:
                    return _from_summary(path, stream, head, summary, content)
            except RecordingError:
                # The frames before the damage can still be read.
                if not allow_torn:
                    raise
        if not allow_torn:
            raise _without_end(path)
        return _from_records(path, stream, head, size)


def open_recording(path: Path, content: Optional[bytes]) -> BinaryIO:
    """A file, or a recording in memory."""
    return open_file(path) if content is None else BytesIO(content)


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


def _without_end(path: Path) -> RecordingError:
    return RecordingError(
        f"{path} has no end: the file is torn, or its run is in progress or was interrupted",
        "run the same experiment again to complete it, or read its intact frames with "
        "`kinetoscope.Run(path, allow_torn=True)`",
    )


def _header(path: Path, stream: BinaryIO, size: int) -> Header:
    """The first record, which names the writer."""
    try:
        stream.seek(0)
        is_mcap = stream.read(len(MAGIC)) == MAGIC
        place = place_at(path, stream, len(MAGIC), size)
        if is_mcap and place.kind == Opcode.HEADER:
            header: Header = parsed(path, body_of(stream, place), Header.read)
            return header
    except RecordingError:
        pass
    raise RecordingError(f"{path} is not an MCAP file", "pass a recording (*.mcap)")


def _head(path: Path, stream: BinaryIO, size: int) -> Head:
    """The manifest and the provenance, which precede the first chunk."""
    at, manifest, provenance = len(MAGIC), None, None
    metadata: List[Tuple[Place, str]] = []
    attachments: List[Tuple[Place, str]] = []
    while manifest is None or provenance is None:
        place = place_at(path, stream, at, size)
        if place.kind == Opcode.ATTACHMENT:
            name, content = attachment_of(path, stream, place)
            attachments.append((place, name))
            if name == MANIFEST:
                manifest = _text(path, content)
        elif place.kind == Opcode.METADATA:
            name, entries = metadata_of(path, stream, place)
            metadata.append((place, name))
            if name == MERGED:
                raise RecordingError(
                    f"{path} holds several runs, merged for a viewer",
                    "`kinetoscope.open(path).runs` has their frames",
                )
            if name == PROVENANCE:
                check_provenance(path, entries)
                provenance = entries
        elif place.kind != Opcode.HEADER:
            raise damaged(path, "it has no provenance")
        at = place.end
    return Head(manifest, provenance, at, metadata, attachments)


def _text(path: Path, content: bytes) -> str:
    try:
        return content.decode("utf-8")
    except UnicodeDecodeError as error:
        raise damaged(path, "its manifest is not UTF-8") from error


def _of_head(path: Path, head: Head, content: Optional[bytes]) -> Container:
    layout = Layout(path, playback_rate(path, head.provenance), stored_frames(path, head.provenance))
    return Container(path, content, layout, Descriptions(path), head.manifest, {PROVENANCE: head.provenance})


def _from_summary(
    path: Path, stream: BinaryIO, head: Head, summary: Summary, content: Optional[bytes]
) -> Container:
    container = _of_head(path, head, content)
    summary.check_places(head.metadata, head.attachments)
    summary.check_frames(container.layout)
    container.is_finished = True
    container.metadata[OUTCOME] = summary.outcome
    container.descriptions = summary.descriptions
    container.message_counts = summary.statistics.channel_message_counts
    container.chunks = summary.chunks
    if summary.data_end <= MAX_CHECKED_BYTES and checksum(stream, 0, summary.data_end) != summary.data_checksum:
        raise damaged(path, "its bytes do not match their checksum")
    return container


def _from_records(path: Path, stream: BinaryIO, head: Head, size: int) -> Container:
    """Reads a file without an index up to its first record that is not intact."""
    container = _of_head(path, head, None)
    at, block = head.end, OpenBlock(container.descriptions)
    while True:
        try:
            at = _keep_record(container, block, stream, at, size)
        except RecordingError:
            return container
        if at == size:
            return container


class OpenBlock:
    """The chunks of a block that precede the one with its clocks."""

    def __init__(self, descriptions: Descriptions) -> None:
        self.descriptions = descriptions
        self.spans: List[ChunkSpan] = []
        self.counts: Dict[int, int] = {}
        self.end_time: Optional[int] = None


def _keep_record(container: Container, block: OpenBlock, stream: BinaryIO, at: int, size: int) -> int:
    """Reads a record, and returns its end."""
    path = container.path
    stream.seek(at)
    if stream.read(1) != bytes([Opcode.CHUNK]):
        place = place_at(path, stream, at, size)
        if place.kind in (Opcode.DATA_END, Opcode.FOOTER):
            return size
        if place.kind == Opcode.METADATA:
            name, entries = metadata_of(path, stream, place)
            if name == OUTCOME:
                outcome_of(path, entries)
            container.metadata.setdefault(name, entries)
        return place.end
    content = read_chunk(path, stream, at, size)
    check_content(path, content)
    descriptions = block.descriptions.copy()
    messages = Messages(container.layout, descriptions, None)
    messages.scan(content.data, block.end_time)
    block.descriptions = descriptions
    for channel, count in messages.counts.items():
        block.counts[channel] = block.counts.get(channel, 0) + count
    end = at + content.record_bytes
    if messages.first_time is not None and messages.last_time is not None:
        times, channels = (messages.first_time, messages.last_time), frozenset(messages.counts)
        block.spans.append(ChunkSpan(at, end, *times, len(content.data), channels))
    if messages.are_scalars:
        # A block counts once all of it is intact.
        container.descriptions, block.end_time = block.descriptions, messages.last_time
        container.chunks += block.spans
        for channel, count in block.counts.items():
            container.message_counts[channel] = container.message_counts.get(channel, 0) + count
        block.spans, block.counts = [], {}
    return end
