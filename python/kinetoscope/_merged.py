"""The runs of a recording that `kinetoscope compare --mcap` merged for a viewer, each as if it had a file of its own."""

from __future__ import annotations

import contextlib
import dataclasses
import re
import struct
import zlib
from pathlib import Path
from typing import BinaryIO, Dict, Iterator, List, NamedTuple, NoReturn, Optional, Tuple

import zstandard
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import Channel, Schema, Statistics

from . import _folder, _programs
from ._chunks import (
    ANY_RATIO_BYTES,
    CLOCK,
    LOG,
    UNPACKED_RATIO,
    ChunkSpan,
    Descriptions,
    Layout,
    check_content,
    read_chunk,
)
from ._container import MANIFEST, Container, open_file
from ._errors import KinetoscopeError, RecordingError, damaged
from ._experiment import Experiment
from ._provenance import MERGED, OUTCOME, PROVENANCE, check_provenance, outcome_of, playback_rate, stored_frames
from ._records import MAGIC, PREFIX, attachment_of, body_of, checksum, metadata_of, parsed, place_at
from ._run import Run

# `MAX_RUNS` of the program.
MAX_RUNS = 7
_CHUNK_BYTES = 1 << 20
_TOPIC = re.compile(r"/(run_[1-9])(/.+)", re.DOTALL)
# Kind and length, channel, sequence and two times; and the head of a chunk with its compression.
_MESSAGE = struct.Struct("<BQHIQQ")
_CHUNK = struct.Struct("<BQQQQII4sQ")
# Channel and sequence, which is the number of the frame.
_NUMBERS = struct.Struct("<HI")
# Drawings are for viewers; states and lines of the log have schemas of Foxglove as well.
_DRAWN = re.compile(r"foxglove\.(?!PointCloud$|Log$)")
_MERGE_AGAIN = "merge the recordings again: `kinetoscope compare --mcap`"


class MergedRun(Run):
    """One of several runs that were merged for a viewer: its numbers as those of its own recording, and, except for the
    first run, its distance from that one as ``/separation``."""

    def __init__(self, container: Container, label: str, programs: Optional[_programs.PathLike]) -> None:
        self._open(container, container.path, programs)
        self.label = label

    def __repr__(self) -> str:
        return f"<run {self.label}: {self.model}, {len(self)} frames, {self.outcome}>"

    @property
    def coordinates(self) -> Dict[str, _folder.Coordinate]:
        """Empty: what tells the run from the others is its ``label``."""
        return {}

    def metric(self, name: str) -> float:
        """An error: the runs of a merged recording are not analyzed."""
        _refuse(self.path)

    def _with_all_frames(self) -> Run:
        return self

    @contextlib.contextmanager
    def _file(self) -> Iterator[Path]:
        yield _refuse(self.path)


class MergedExperiment(Experiment):
    """Several runs in one recording."""

    def __init__(self, path: Path, runs: List[MergedRun], programs: Optional[_programs.PathLike]) -> None:
        super().__init__(path, [path], programs=programs)
        self._runs = tuple(runs)

    def __repr__(self) -> str:
        return f"<experiment {self.name}: {len(self.runs)} runs, merged in {self.path}>"

    @property
    def name(self) -> str:
        """The name of the file."""
        return self.path.stem

    @property
    def _has_keyframes(self) -> bool:
        return False

    @contextlib.contextmanager
    def _input(self) -> Iterator[Path]:
        yield _refuse(self.path)

    def _stored(self) -> Dict[str, object]:
        _refuse(self.path)


def _refuse(path: Path) -> NoReturn:
    raise KinetoscopeError(
        f"{path} holds several runs, merged for a viewer: it has frames, but cannot be analyzed or verified",
        "open the recording of one run, or the folder of the experiment",
    )


class _Part:
    """A run's part of the file, which becomes the content of a recording in memory."""

    def __init__(self, path: Path, provenance: Dict[str, str], manifest: str) -> None:
        layout = Layout(path, playback_rate(path, provenance), stored_frames(path, provenance))
        metadata = {PROVENANCE: provenance, OUTCOME: provenance}
        self.container = Container(path, b"", layout, Descriptions(path), manifest, metadata, is_finished=True)
        self.content = bytearray()
        self._frame: Optional[int] = None
        # The records of the open frame, and of the open chunk with its numbers of messages and times.
        self._records: List[Tuple[bool, bytes]] = []
        self._chunk = bytearray()
        self._counts: Dict[int, int] = {}
        self._times: List[int] = []

    def declare(self, channel: Channel, schema: Schema) -> None:
        """Adds a channel before its first message."""
        known = self.container.descriptions
        for is_new, record in ((schema.id not in known.schemas, schema), (True, channel)):
            if is_new:
                builder = RecordBuilder()
                record.write(builder)
                written: bytes = builder.end()  # type: ignore[no-untyped-call]
                known.add(written[0], written[PREFIX.size :])
                self._chunk += written

    def add(self, channel: int, frame: int, payload: bytes) -> None:
        """Adds a message; all of a frame follow each other."""
        if frame != self._frame:
            self._close_frame()
            self._frame = frame
        topic = self.container.descriptions.channels[channel].topic
        frames = self.container.frames_of.setdefault(topic, [])
        if frames and frames[-1] >= frame and topic != LOG:
            raise damaged(self.container.path, f"the frames of {topic} are not in order")
        if not frames or frames[-1] != frame:
            frames.append(frame)
        time = self.container.layout.log_time(frame)
        if time >= 1 << 64:
            raise damaged(self.container.path, f"frame {frame} has no time of playback")
        length = _MESSAGE.size - PREFIX.size + len(payload)
        record = _MESSAGE.pack(Opcode.MESSAGE, length, channel, frame, time, time) + payload
        # The clock comes first.
        self._records.append((topic != CLOCK, record))
        self._counts[channel] = self._counts.get(channel, 0) + 1
        self._times.append(time)

    def _close_frame(self) -> None:
        self._chunk += b"".join(record for _, record in sorted(self._records, key=lambda record: record[0]))
        self._records = []
        if len(self._chunk) >= _CHUNK_BYTES:
            self._close_chunk()

    def _close_chunk(self) -> None:
        if not self._counts:
            return
        packed, start = zstandard.ZstdCompressor(level=1).compress(bytes(self._chunk)), len(self.content)
        times, length = (self._times[0], self._times[-1]), _CHUNK.size - PREFIX.size + len(packed)
        sizes = len(self._chunk), zlib.crc32(self._chunk), 4
        self.content += _CHUNK.pack(Opcode.CHUNK, length, *times, *sizes, b"zstd", len(packed)) + packed
        span = ChunkSpan(start, len(self.content), *times, len(self._chunk), frozenset(self._counts))
        self.container.chunks.append(span)
        for channel, count in self._counts.items():
            self.container.message_counts[channel] = self.container.message_counts.get(channel, 0) + count
        self._chunk, self._counts, self._times = bytearray(), {}, []

    def finished(self) -> Container:
        """The recording of the run in memory."""
        self._close_frame()
        self._close_chunk()
        self.container.content = bytes(self.content)
        return self.container


class _Head(NamedTuple):
    """What precedes the messages."""

    manifests: Dict[str, str]
    entries: Dict[str, str]
    end: int


def open_merged(path: Path, programs: Optional[_programs.PathLike]) -> Optional[MergedExperiment]:
    """The runs of a merged recording, read into memory; none if the file is another one."""
    with open_file(path) as stream:
        size = stream.seek(0, 2)
        try:
            head = _head(path, stream, size)
        except RecordingError:
            # The reader of one run says what it is.
            head = None
        if head is None:
            return None
        try:
            names = [f"run_{number}" for number in range(1, MAX_RUNS + 1)]
            parts = {name: _part(path, name, head) for name in names if f"{name}.label" in head.entries}
            if not parts:
                raise damaged(path, "it has no runs")
            _distribute(path, stream, head.end, size, parts)
        except RecordingError as error:
            raise RecordingError(error.message, _MERGE_AGAIN) from error
    runs = [MergedRun(part.finished(), head.entries[f"{name}.label"], programs) for name, part in parts.items()]
    return MergedExperiment(path, runs, programs)


def _head(path: Path, stream: BinaryIO, size: int) -> Optional[_Head]:
    """The manifests and the description of the runs; none if the file is not a merged recording."""
    stream.seek(0)
    if stream.read(len(MAGIC)) != MAGIC:
        return None
    at = len(MAGIC)
    manifests: Dict[str, str] = {}
    while MANIFEST not in manifests:
        place = place_at(path, stream, at, size)
        at = place.end
        if place.kind == Opcode.ATTACHMENT:
            name, content = attachment_of(path, stream, place)
            manifests[name] = content.decode("utf-8", "replace")
        elif place.kind == Opcode.METADATA:
            name, entries = metadata_of(path, stream, place)
            return _Head(manifests, entries, at) if name == MERGED else None
        elif place.kind != Opcode.HEADER:
            return None
    return None


def _part(path: Path, name: str, head: _Head) -> _Part:
    own = {key[len(name) + 1 :]: value for key, value in head.entries.items() if key.startswith(f"{name}.")}
    if "schema_version" not in own:
        version = own.get("program_version", "an unknown version")
        raise RecordingError(f"{path} was merged by Kinetoscope {version}, without what its frames need")
    check_provenance(path, own)
    if "outcome" in own:
        outcome_of(path, own)
    if f"{name}.toml" not in head.manifests:
        raise damaged(path, f"it has no manifest of {name}")
    return _Part(path, own, head.manifests[f"{name}.toml"])


class _Distributor:
    """Gives each run its messages."""

    def __init__(self, path: Path, parts: Dict[str, _Part]) -> None:
        self.counts: Dict[int, int] = {}
        self._path, self._parts = path, parts
        self._schemas: Dict[int, Schema] = {}
        # None for drawings.
        self._owners: Dict[int, Optional[_Part]] = {}

    def add(self, kind: int, body: bytes) -> None:
        """Adds a record of a chunk."""
        path = self._path
        if kind == Opcode.SCHEMA:
            schema = parsed(path, body, Schema.read)
            self._schemas[schema.id] = schema
        elif kind == Opcode.CHANNEL:
            self._declare(parsed(path, body, Channel.read))
        elif kind == Opcode.MESSAGE:
            number, frame = _NUMBERS.unpack_from(body)
            if number not in self._owners:
                raise damaged(path, "a message has no channel")
            self.counts[number] = self.counts.get(number, 0) + 1
            owner = self._owners[number]
            if owner is not None:
                owner.add(number, frame, body[_MESSAGE.size - PREFIX.size :])

    def _declare(self, channel: Channel) -> None:
        match, schema = _TOPIC.fullmatch(channel.topic), self._schemas.get(channel.schema_id)
        if match is None or match[1] not in self._parts or schema is None or channel.id in self._owners:
            raise damaged(self._path, f"its channel {channel.topic!r} is that of no run, or is declared twice")
        owner = None if _DRAWN.match(schema.name) else self._parts[match[1]]
        self._owners[channel.id] = owner
        if owner is not None:
            owner.declare(dataclasses.replace(channel, topic=match[2]), schema)


def _distribute(path: Path, stream: BinaryIO, at: int, size: int, parts: Dict[str, _Part]) -> None:
    """Reads all chunks, which have to be those of the end of the file."""
    distributor, unpacked = _Distributor(path, parts), 0
    while True:
        stream.seek(at)
        if stream.read(1) != bytes([Opcode.CHUNK]):
            place = place_at(path, stream, at, size)
            if place.kind == Opcode.DATA_END:
                break
            at = place.end
            continue
        content = read_chunk(path, stream, at, size)
        unpacked += len(content.data)
        if unpacked > max(ANY_RATIO_BYTES, UNPACKED_RATIO * size):
            raise damaged(path, "its chunks have more bytes than those of any recording")
        check_content(path, content)
        for kind, start, end in _records(path, content.data):
            distributor.add(kind, content.data[start:end])
        at += content.record_bytes
    if int.from_bytes(body_of(stream, place), "little") != checksum(stream, 0, place.start):
        raise damaged(path, "its bytes do not match their checksum")
    while place.kind not in (Opcode.STATISTICS, Opcode.FOOTER):
        place = place_at(path, stream, place.end, size)
    if place.kind == Opcode.FOOTER or parsed(path, body_of(stream, place), Statistics.read).channel_message_counts != (
        distributor.counts
    ):
        raise damaged(path, "it has other numbers of messages than its statistics")
    stream.seek(size - len(MAGIC))
    if stream.read() != MAGIC:
        raise damaged(path, "its end is missing")


def _records(path: Path, content: bytes) -> Iterator[Tuple[int, int, int]]:
    """The records of a chunk: their kinds, and where their bodies start and end."""
    at = 0
    while at < len(content):
        if len(content) - at < PREFIX.size:
            raise damaged(path, "a chunk ends inside a record")
        kind, length = PREFIX.unpack_from(content, at)
        start = at + PREFIX.size
        at = start + length
        if at > len(content) or (kind == Opcode.MESSAGE and length < _MESSAGE.size - PREFIX.size):
            raise damaged(path, "a chunk ends inside a record")
        yield kind, start, at
