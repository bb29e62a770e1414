"""The chunks of a recording: decompression, checksums, and the messages of their frames."""

from __future__ import annotations

import struct
import zlib
from fractions import Fraction
from pathlib import Path
from typing import BinaryIO, Dict, FrozenSet, List, NamedTuple, Optional, Tuple

import lz4.frame
import zstandard
from mcap.opcode import Opcode
from mcap.records import Channel, Schema

from ._errors import damaged
from ._provenance import StoredFrames
from ._records import MAX_CHANNELS, PREFIX, or_damaged, parsed

# Limits for the size that a chunk claims, as in `src/recording/limits.rs`.
ANY_RATIO_BYTES = 256 << 20
UNPACKED_RATIO = 192
MAX_CONTENT_BYTES = (4 << 30) + (64 << 20)
MAX_BODY_BYTES = MAX_CONTENT_BYTES + MAX_CONTENT_BYTES // 64
CLOCK, LOG = "/frame", "/log"

# Times, size and checksum of the content, and length of the name of the compression.
_HEAD = struct.Struct("<QQQII")
_MESSAGE = struct.Struct("<BQHIQQ")
_SIZE = struct.Struct("<Q")
# As plain numbers, which are compared for each message.
_IS_MESSAGE, _PREFIX_BYTES, _HEAD_BYTES = int(Opcode.MESSAGE), PREFIX.size, _MESSAGE.size
_SMALLEST = _HEAD_BYTES - _PREFIX_BYTES
_LONGEST_NAME = 4


class ChunkSpan(NamedTuple):
    """A chunk as the index describes it: its place in the file, its times, the size of its content, and its channels."""

    offset: int
    end: int
    start_time: int
    end_time: int
    size: int
    channels: FrozenSet[int]


class Content(NamedTuple):
    """The decompressed content of a chunk, with what its record states, and the size of the record."""

    data: bytes
    start_time: int
    end_time: int
    crc: int
    record_bytes: int


class Layout(NamedTuple):
    """What the messages of a recording have to agree with."""

    path: Path
    rate: Fraction
    stored: StoredFrames

    def log_time(self, frame: int) -> int:
        """Frame index over playback rate in ns, rounded to the nearest as the recorder does."""
        numerator, denominator = self.rate.numerator, self.rate.denominator
        return (2 * frame * 10**9 * denominator + numerator) // (2 * numerator)


class Descriptions:
    """The schemas and channels of a recording, in the order of their declaration."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.schemas: Dict[int, Schema] = {}
        self.channels: Dict[int, Channel] = {}

    def copy(self) -> "Descriptions":
        """A copy, to which others may be added."""
        other = Descriptions(self.path)
        other.schemas, other.channels = dict(self.schemas), dict(self.channels)
        return other

    def add(self, kind: int, body: bytes) -> None:
        """Adds a record; a second one of the same number has to be equal."""
        if kind == Opcode.SCHEMA:
            schema = parsed(self.path, body, Schema.read)
            if schema.id == 0 or self.schemas.setdefault(schema.id, schema) != schema:
                raise damaged(self.path, f"its schema {schema.id} is declared twice")
        else:
            channel = parsed(self.path, body, Channel.read)
            if channel.schema_id not in self.schemas:
                raise damaged(self.path, f"the channel {channel.topic!r} has no schema")
            if self.channels.setdefault(channel.id, channel) != channel:
                raise damaged(self.path, f"its channel {channel.id} is declared twice")
            if self.number_of(channel.topic) != channel.id:
                raise damaged(self.path, f"it has two channels {channel.topic!r}")
        if len(self.schemas) > MAX_CHANNELS or len(self.channels) > MAX_CHANNELS:
            raise damaged(self.path, "it has more channels than any recording")

    def known_before(self, earlier: FrozenSet[int]) -> "Descriptions":
        """What chunks with these channels have declared: a chunk declares the channels of which it has the first message."""
        other = Descriptions(self.path)
        other.channels = {number: channel for number, channel in self.channels.items() if number in earlier}
        used = {channel.schema_id for channel in other.channels.values()}
        other.schemas = {number: schema for number, schema in self.schemas.items() if number in used}
        return other

    def has_all_of(self, other: "Descriptions") -> bool:
        """Whether all schemas and channels of another one are the same here."""
        return other.schemas.items() <= self.schemas.items() and other.channels.items() <= self.channels.items()

    def are_scalars(self, channels: FrozenSet[int]) -> bool:
        """Whether a chunk with these channels has the clocks of its block, or the line of the log that follows the last block."""
        return self.number_of(CLOCK) in channels or self.number_of(LOG) in channels

    def number_of(self, topic: str) -> Optional[int]:
        """The number of a topic's channel."""
        return next((number for number, channel in self.channels.items() if channel.topic == topic), None)


def read_chunk(path: Path, stream: BinaryIO, offset: int, end: int) -> Content:
    """The chunk at a byte, whose record ends before or at another; its checksum is not compared yet."""
    stream.seek(offset)
    head = stream.read(PREFIX.size + _HEAD.size)
    if len(head) < PREFIX.size + _HEAD.size:
        raise damaged(path, f"there is no chunk at byte {offset}")
    kind, length = PREFIX.unpack_from(head)
    if kind != Opcode.CHUNK or length > min(end - offset - PREFIX.size, MAX_BODY_BYTES):
        raise damaged(path, f"there is no chunk at byte {offset}")
    start_time, end_time, size, crc, name_length = _HEAD.unpack_from(head, PREFIX.size)
    if name_length > _LONGEST_NAME:
        raise damaged(path, f"the chunk at byte {offset} has an unknown compression")
    rest = stream.read(name_length + _SIZE.size)
    packed_size = length - _HEAD.size - len(rest)
    if len(rest) < name_length + _SIZE.size or _SIZE.unpack_from(rest, name_length)[0] != packed_size:
        raise damaged(path, f"the sizes of the chunk at byte {offset} contradict each other")
    packed = stream.read(packed_size)
    data = _unpacked(path, rest[:name_length], packed, size, offset)
    return Content(data, start_time, end_time, crc, PREFIX.size + length)


def check_content(path: Path, content: Content) -> None:
    """Compares the checksum of a chunk's content."""
    if zlib.crc32(content.data) != content.crc:
        raise damaged(path, "wrong checksum of a chunk")


def _unpacked(path: Path, compression: bytes, packed: bytes, size: int, offset: int) -> bytes:
    if size > min(max(ANY_RATIO_BYTES, UNPACKED_RATIO * len(packed)), MAX_CONTENT_BYTES):
        raise damaged(path, f"the chunk at byte {offset} claims {size} bytes")
    try:
        if compression == b"zstd":
            # The library allocates what the compressed data claim, whatever limit it is given.
            claimed = zstandard.frame_content_size(packed)
            if claimed not in (-1, size):
                raise damaged(path, f"the chunk at byte {offset} claims {claimed} bytes")
            content = zstandard.ZstdDecompressor().decompress(packed, max_output_size=size)
        elif compression == b"lz4":
            content = lz4.frame.LZ4FrameDecompressor().decompress(packed, max_length=size)
        elif compression == b"":
            content = packed
        else:
            raise damaged(path, f"the chunk at byte {offset} has an unknown compression")
    except MemoryError:
        raise
    except Exception as error:
        raise or_damaged(path, f"the chunk at byte {offset} cannot be decompressed", error) from error
    if len(content) != size:
        raise damaged(path, f"the chunk at byte {offset} has {len(content)} bytes instead of {size}")
    return content


class Messages:
    """The messages in the content of a chunk. In a chunk of scalars, a frame begins with its clock."""

    def __init__(self, layout: Layout, descriptions: Descriptions, wanted: Optional[int]) -> None:
        self.counts: Dict[int, int] = {}
        # Log times of the wanted channel, with start and end of the payloads.
        self.places: Dict[int, Tuple[int, int]] = {}
        # The same of the clocks.
        self.clocks: Dict[int, Tuple[int, int]] = {}
        # The same of the log, of which a frame may have several messages.
        self.lines: List[Tuple[int, int, int]] = []
        self.first_time: Optional[int] = None
        self.last_time: Optional[int] = None
        self.are_scalars = False
        self._layout = layout
        self._descriptions = descriptions
        self._wanted = wanted
        self._last_number: Optional[int] = None
        self._previous_time: Optional[int] = None

    def scan(self, content: bytes, previous_time: Optional[int]) -> None:
        """Reads the content; `previous_time` is the log time of the last frame in the block before."""
        at, size, time, is_frame, is_first = 0, len(content), previous_time, False, True
        has_clocks = False
        read_prefix, read_head = PREFIX.unpack_from, _MESSAGE.unpack_from
        self._previous_time = previous_time
        clock, log = self._numbers()
        # The log time of the last message of each channel.
        latest: Dict[int, int] = dict.fromkeys(self._descriptions.channels, -1)
        while at < size:
            if size - at < _PREFIX_BYTES:
                raise self._damaged("a chunk ends inside a record")
            kind, length = read_prefix(content, at)
            start, end = at + _PREFIX_BYTES, at + _PREFIX_BYTES + length
            if end > size or (kind == _IS_MESSAGE and length < _SMALLEST):
                raise self._damaged("a chunk ends inside a record")
            if kind != _IS_MESSAGE:
                self._describe(kind, content[start:end])
                clock, log = self._numbers()
                latest = {number: latest.get(number, -1) for number in self._descriptions.channels}
                at = end
                continue
            _, _, channel, _, log_time, _ = read_head(content, at)
            start = at + _HEAD_BYTES
            if is_first:
                has_clocks, is_first = channel in (clock, log), False
            if not has_clocks:
                if channel in (clock, log) or (time is not None and log_time < time):
                    raise self._damaged("a message is outside of its frame")
                time = log_time
            elif channel == clock:
                if time is not None and log_time <= time:
                    raise self._damaged("the frames are not in order")
                time, is_frame = log_time, True
                self._check_clock(log_time, frame_number(content, start, end))
                self.clocks[log_time] = (start, end)
            elif log_time != time or (not is_frame and channel != log):
                raise self._damaged("a message is outside of its frame")
            if latest.get(channel, log_time) == log_time and channel != log:
                raise self._damaged("a message has no channel, or a frame has two messages of one topic")
            latest[channel] = log_time
            self.counts[channel] = self.counts.get(channel, 0) + 1
            if channel == self._wanted:
                self.places[log_time] = (start, end)
                if channel == log:
                    self.lines.append((log_time, start, end))
            if self.first_time is None:
                self.first_time = log_time
            at = end
        self.last_time = time if self.first_time is not None else None
        self.are_scalars = has_clocks

    def _damaged(self, what: str) -> Exception:
        return damaged(self._layout.path, what)

    def _numbers(self) -> Tuple[Optional[int], Optional[int]]:
        return self._descriptions.number_of(CLOCK), self._descriptions.number_of(LOG)

    def _describe(self, kind: int, body: bytes) -> None:
        if kind not in (Opcode.SCHEMA, Opcode.CHANNEL):
            raise self._damaged("a chunk contains a record that does not belong in a chunk")
        self._descriptions.add(kind, body)

    def _check_clock(self, log_time: int, number: int) -> None:
        """A frame plays at the time of its number, and follows the one before."""
        layout, last, self._last_number = self._layout, self._last_number, number
        if log_time != layout.log_time(number):
            raise self._damaged(f"frame {number} has the time of another one")
        if last is None and self._previous_time is None:
            follows = number == layout.stored.first
        else:
            follows = number == last + 1 if last is not None else layout.log_time(number - 1) == self._previous_time
        if not follows:
            raise self._damaged(f"a frame before frame {number} is missing")


def frame_number(content: bytes, start: int, end: int) -> int:
    """The first field of a clock, which is absent if it is 0."""
    if start == end or content[start] != 0x08:
        return 0
    value = shift = 0
    for at in range(start + 1, min(end, start + 11)):
        value |= (content[at] & 0x7F) << shift
        shift += 7
        if content[at] < 0x80:
            break
    return value

