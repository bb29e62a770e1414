"""MCAP records of an untrusted file: every size that the file claims is compared with a limit before memory is used."""

from __future__ import annotations

import struct
import zlib
from io import BytesIO
from pathlib import Path
from typing import BinaryIO, Callable, Dict, Iterator, NamedTuple, Tuple, TypeVar

from mcap.data_stream import ReadDataStream
from mcap.exceptions import EndOfFile
from mcap.opcode import Opcode
from mcap.records import Attachment, Metadata

from ._errors import KinetoscopeError, damaged

MAGIC = b"\x89MCAP0\r\n"
PREFIX = struct.Struct("<BQ")
# Limits of the reader in `src/recording/limits.rs`.
MAX_RECORD_BYTES = 16 << 20
MAX_TEXT_BYTES = 1 << 20
MAX_ATTACHMENT_BYTES = (16 << 20) + (4 << 10)
MAX_CHANNELS = 64
_TEXTS = (Opcode.HEADER, Opcode.METADATA, Opcode.METADATA_INDEX, Opcode.DATA_END)
# Sparse files and zeroed disks read as records of kind 0.
_IN_CHUNKS = (0, Opcode.CHUNK, Opcode.MESSAGE)

Record = TypeVar("Record")


class Place(NamedTuple):
    """A record's kind, its first byte, and the byte after it."""

    kind: int
    start: int
    end: int


class ExactStream(ReadDataStream):
    """Reads fields; a field that is shorter than its length is an error."""

    def read(self, length: int) -> bytes:
        data: bytes = super().read(length)
        if len(data) != length:
            raise EndOfFile()
        return data


def parsed(path: Path, body: bytes, read: Callable[[ReadDataStream], Record]) -> Record:
    """The record with this body; damage is an error of this package."""
    try:
        stream = ExactStream(BytesIO(body))
        record = read(stream)
        if stream.count != len(body):
            raise ValueError("a record is too long")
        return record
    except Exception as error:
        raise damaged(path, f"a record outside the chunks cannot be read ({error!r})") from error


def place_at(path: Path, stream: BinaryIO, at: int, end: int) -> Place:
    """The record at a byte of a part of the file where no chunk is expected."""
    stream.seek(at)
    prefix = stream.read(PREFIX.size) if end - at >= PREFIX.size else b""
    if len(prefix) < PREFIX.size:
        raise damaged(path, f"it ends inside the record at byte {at}")
    kind, length = PREFIX.unpack(prefix)
    if length > end - at - PREFIX.size:
        raise damaged(path, f"it ends inside the record at byte {at}")
    limit = MAX_TEXT_BYTES if kind in _TEXTS else MAX_ATTACHMENT_BYTES if kind == Opcode.ATTACHMENT else MAX_RECORD_BYTES
    if kind in _IN_CHUNKS or length > limit:
        raise damaged(path, f"the record at byte {at} is at a place, or of a size, that no recording has")
    return Place(kind, at, at + PREFIX.size + length)


def places(path: Path, stream: BinaryIO, at: int, end: int) -> Iterator[Place]:
    """The records between two bytes."""
    while at < end:
        place = place_at(path, stream, at, end)
        yield place
        at = place.end


def body_of(stream: BinaryIO, place: Place) -> bytes:
    """The body of a record."""
    stream.seek(place.start + PREFIX.size)
    return stream.read(place.end - place.start - PREFIX.size)


def metadata_of(path: Path, stream: BinaryIO, place: Place) -> Tuple[str, Dict[str, str]]:
    """Name and entries of a metadata record."""
    record = parsed(path, body_of(stream, place), Metadata.read)
    return record.name, record.metadata


def attachment_of(path: Path, stream: BinaryIO, place: Place) -> Tuple[str, bytes]:
    """Name and content of an attachment, whose checksum is compared."""
    body = body_of(stream, place)
    record = parsed(path, body, Attachment.read)
    if zlib.crc32(body[:-4]) != int.from_bytes(body[-4:], "little"):
        raise damaged(path, f"wrong checksum of the attachment at byte {place.start}")
    return record.name, record.data


def checksum(stream: BinaryIO, start: int, end: int, value: int = 0) -> int:
    """Continues a CRC-32 with a part of the file."""
    stream.seek(start)
    while start < end:
        part = stream.read(min(end - start, 1 << 20))
        if not part:
            break
        value = zlib.crc32(part, value)
        start += len(part)
    return value


def or_damaged(path: Path, what: str, error: Exception) -> KinetoscopeError:
    """An error of a decoder as one of this package."""
    return error if isinstance(error, KinetoscopeError) else damaged(path, f"{what} ({error!r})")
