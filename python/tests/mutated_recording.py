"""Structure-aware changes of recordings: the records are decoded, one to three are changed, and all are encoded again.

Most files have correct checksums, and an index that points to the changed records. Raw damage is found by checksums; these changes
are not. The same idea in Rust: `tests/shared/mutated_recording.rs`.
"""

from __future__ import annotations

import struct
import zlib
from collections import Counter
from dataclasses import dataclass
from random import Random
from typing import Any, Dict, Iterable, Iterator, List, Tuple

import zstandard

MAGIC = b"\x89MCAP0\r\n"
PREFIX = struct.Struct("<BQ")
HEADER, FOOTER, SCHEMA, CHANNEL, MESSAGE, CHUNK, MESSAGE_INDEX, CHUNK_INDEX = range(1, 9)
ATTACHMENT, ATTACHMENT_INDEX, STATISTICS, METADATA, METADATA_INDEX, SUMMARY_OFFSET, DATA_END = range(9, 16)

# Fields of the records (https://mcap.dev/spec). B, H, I, Q: numbers; s: text; d: bytes after 4 bytes of length; r: after 8;
# m: texts by text; n: numbers of 64 bits by numbers of 16 bits; *: the remaining bytes.
LAYOUTS = {
    HEADER: "ss",
    FOOTER: "QQI",
    SCHEMA: "Hssd",
    CHANNEL: "HHssm",
    MESSAGE: "HIQQ*",
    CHUNK: "QQQIsr",
    MESSAGE_INDEX: "Hd",
    CHUNK_INDEX: "QQQQnQsQQ",
    ATTACHMENT: "QQssrI",
    ATTACHMENT_INDEX: "QQQQQss",
    STATISTICS: "QHIIIIQQn",
    METADATA: "sm",
    METADATA_INDEX: "QQs",
    SUMMARY_OFFSET: "BQQ",
    DATA_END: "I",
}
WIDTHS = {"B": 8, "H": 16, "I": 32, "Q": 64}
TEXTS = ["", "-1", "nan", "99999999999999999999", "x" * 70, "interrupted", "complete", "x,y", "/state", "zstd", "kinetoscope.DemEnergy"]
DOUBLES = [struct.pack("<d", value) for value in (float("nan"), float("inf"), 0.0, -1.0, 1e300, 5e-324)]


@dataclass
class Record:
    """A record with its fields; that of a chunk with the records of its content."""

    kind: int
    fields: List[Any]
    content: List["Record"]
    original: bytes = b""

    def copy(self) -> "Record":
        """A copy whose fields may be changed."""
        fields = [dict(field) if isinstance(field, dict) else field for field in self.fields]
        return Record(self.kind, fields, [record.copy() for record in self.content], self.original)

    def encoded(self) -> bytes:
        """The bytes of the record."""
        body = b"".join(_encoded(code, value) for code, value in zip(LAYOUTS[self.kind], self.fields))
        return PREFIX.pack(self.kind, len(body)) + body


def _decoded(code: str, data: bytes, at: int) -> Tuple[Any, int]:
    if code in WIDTHS:
        size = WIDTHS[code] // 8
        return int.from_bytes(data[at : at + size], "little"), at + size
    if code == "*":
        return data[at:], len(data)
    size = 8 if code == "r" else 4
    start = at + size
    end = start + int.from_bytes(data[at:start], "little")
    if code == "s":
        return data[start:end].decode(), end
    if code in "dr":
        return data[start:end], end
    entries: Dict[Any, Any] = {}
    while start < end:
        key, start = _decoded("s" if code == "m" else "H", data, start)
        entries[key], start = _decoded("s" if code == "m" else "Q", data, start)
    return entries, end


def _encoded(code: str, value: Any) -> bytes:
    if code in WIDTHS:
        return int(value % 2 ** WIDTHS[code]).to_bytes(WIDTHS[code] // 8, "little")
    if code == "*":
        return bytes(value)
    if code == "s":
        value = value.encode()
    elif code in "mn":
        key, entry = ("s", "s") if code == "m" else ("H", "Q")
        value = b"".join(_encoded(key, name) + _encoded(entry, item) for name, item in value.items())
    return len(value).to_bytes(8 if code == "r" else 4, "little") + bytes(value)


def records_of(data: bytes, at: int, end: int) -> Iterator[Record]:
    """The records between two places of a file or of a chunk's content."""
    while at < end:
        kind, length = PREFIX.unpack_from(data, at)
        body, place = data[at + PREFIX.size : at + PREFIX.size + length], 0
        fields = []
        for code in LAYOUTS[kind]:
            value, place = _decoded(code, body, place)
            fields.append(value)
        original = zstandard.decompress(fields[5], fields[2]) if kind == CHUNK else b""
        yield Record(kind, fields, list(records_of(original, 0, len(original))), original)
        at += PREFIX.size + length


class MutatedRecording:
    """A valid recording, whose records are changed."""

    def __init__(self, data: bytes) -> None:
        self.records = list(records_of(data, len(MAGIC), len(data) - len(MAGIC)))

    def changed(self, numbers: Random) -> bytes:
        """The file with one to three changes."""
        records = [record.copy() for record in self.records]
        for _ in range(numbers.randint(1, 3)):
            change(records, numbers)
        has_checksums = numbers.random() < 0.8
        return encoded(records, has_checksums, has_checksums and numbers.random() < 0.9)

    @property
    def chunks(self) -> int:
        """The number of chunks."""
        return sum(record.kind == CHUNK for record in self.records)

    def with_chunks(self, order: Iterable[int]) -> bytes:
        """The file with these chunks in this order, each with its indexes, and with their numbers of messages in the statistics."""
        groups: List[List[Record]] = []
        indexes: List[Record] = []
        others: List[Record] = []
        for record in self.records:
            if record.kind == CHUNK:
                groups.append([record])
            elif record.kind == MESSAGE_INDEX:
                groups[-1].append(record)
            elif record.kind == CHUNK_INDEX:
                indexes.append(record)
            else:
                others.append(record.copy())
        chosen = list(order)
        counts = Counter(
            message.fields[0] for number in chosen for message in groups[number][0].content if message.kind == MESSAGE
        )
        records: List[Record] = []
        for record in others:
            if record.kind == METADATA and record.fields[0] == "kinetoscope.outcome":
                records += [part.copy() for number in chosen for part in groups[number]]
            records.append(record)
            if record.kind == STATISTICS:
                record.fields[0], record.fields[5] = sum(counts.values()), len(chosen)
                record.fields[8] = {channel: counts[channel] for channel in record.fields[8] if counts[channel]}
                records += [indexes[number].copy() for number in chosen]
        return encoded(records, True, True)

    def with_moved_message(self, source: int, target: int) -> bytes:
        """The file with the last message of a chunk at the end of another chunk."""
        records = [record.copy() for record in self.records]
        chunks = [record for record in records if record.kind == CHUNK]
        chunks[target].content.append(chunks[source].content.pop())
        return encoded(records, True, True)

    def unchanged(self) -> bytes:
        """The file without a change, encoded again."""
        return encoded([record.copy() for record in self.records], True, True)


def change(records: List[Record], numbers: Random) -> None:
    """Changes one record, or the order of two."""
    chunks = [record for record in records if record.kind == CHUNK and record.content]
    place = records
    if chunks and numbers.random() < 0.5:
        place = numbers.choice(chunks).content
    if not place:
        return
    # Every kind is changed equally often, not every record.
    kind = numbers.choice(sorted({record.kind for record in place}))
    chosen = [index for index, record in enumerate(place) if record.kind == kind]
    index, other = numbers.choice(chosen), numbers.choice(chosen)
    action = numbers.randrange(10)
    if action == 0:
        del place[index]
    elif action == 1:
        place.insert(other, place[index].copy())
    elif action == 2:
        place[index], place[other] = place[other], place[index]
    else:
        field = numbers.randrange(len(place[index].fields))
        code, old = LAYOUTS[kind][field], place[index].fields[field]
        if place[index].content and code == "r":
            return
        value = changed_field(code, old, numbers)
        # One record, or all of its kind that have this value.
        for each in chosen if numbers.random() < 0.3 else [index]:
            if place[each].fields[field] == old:
                place[each].fields[field] = value


def changed_field(code: str, value: Any, numbers: Random) -> Any:
    """Another value of a field."""
    if code in WIDTHS:
        width = WIDTHS[code]
        return numbers.choice([0, 1, value + 1, value - 1, value ^ 1 << numbers.randrange(width), numbers.getrandbits(width)])
    if code == "s":
        changed = changed_bytes(value.encode(), numbers).decode(errors="replace")
        return numbers.choice([changed, *TEXTS]) if numbers.random() < 0.5 else changed
    if code in "mn":
        entries = dict(value)
        key = numbers.choice([*entries, "name" if code == "m" else 1])
        if numbers.random() < 0.3:
            entries.pop(key, None)
        else:
            entries[key] = changed_field("s" if code == "m" else "Q", entries.get(key, "" if code == "m" else 0), numbers)
        return entries
    return changed_bytes(value, numbers)


def changed_bytes(data: bytes, numbers: Random) -> bytes:
    """Bytes with another bit, without their end, with one byte more, with a special number, or none."""
    changed, place = bytearray(data), numbers.randrange(len(data) or 1)
    action = numbers.randrange(5)
    if action == 0 and data:
        changed[place] ^= 1 << numbers.randrange(8)
    elif action == 1:
        del changed[place:]
    elif action == 2:
        changed.insert(place, numbers.randrange(256))
    elif action == 3:
        changed[place : place + 8] = numbers.choice(DOUBLES)
    else:
        changed[place : place + 1] = numbers.choice([b"", b"\x00", b"\xff" * 9])
    return bytes(changed)


def encoded(records: List[Record], has_checksums: bool, has_index: bool) -> bytes:
    """The file of these records."""
    data = bytearray(MAGIC)
    places: Dict[int, List[int]] = {CHUNK: [], ATTACHMENT: [], METADATA: []}
    summary_start = 0
    for record in records:
        if record.kind == CHUNK:
            _pack(record, has_checksums)
        elif record.kind == ATTACHMENT and has_checksums:
            record.fields[5] = zlib.crc32(record.encoded()[PREFIX.size : -4])
        elif record.kind == DATA_END and has_checksums:
            record.fields[0] = zlib.crc32(data)
        elif record.kind == FOOTER:
            if has_index:
                record.fields[0] = summary_start
            if has_checksums:
                record.fields[2] = zlib.crc32(data[summary_start:] + record.encoded()[:-4])
        elif has_index and record.kind in (CHUNK_INDEX, ATTACHMENT_INDEX, METADATA_INDEX):
            _point(record, places, data)
        if record.kind in places:
            places[record.kind].append(len(data))
        data += record.encoded()
        if record.kind == DATA_END:
            summary_start = len(data)
    return bytes(data + MAGIC)


def _pack(record: Record, has_checksums: bool) -> None:
    content = b"".join(inner.encoded() for inner in record.content)
    if content != record.original:
        record.fields[5] = zstandard.compress(content) if record.fields[4] == "zstd" else content
        if has_checksums:
            record.fields[2], record.fields[3] = len(content), zlib.crc32(content)


def _point(record: Record, places: Dict[int, List[int]], data: bytearray) -> None:
    """Makes an index point to the next record of its kind."""
    kind = {CHUNK_INDEX: CHUNK, ATTACHMENT_INDEX: ATTACHMENT, METADATA_INDEX: METADATA}[record.kind]
    if not places[kind]:
        return
    at = places[kind].pop(0)
    end = at + PREFIX.size + PREFIX.unpack_from(data, at)[1]
    if kind != CHUNK:
        record.fields[:2] = at, end - at
        return
    following, offsets = end, record.fields[4]
    while data[following] == MESSAGE_INDEX:
        channel = struct.unpack_from("<H", data, following + PREFIX.size)[0]
        if channel in offsets:
            offsets[channel] = following
        following += PREFIX.size + PREFIX.unpack_from(data, following)[1]
    record.fields[2:4] = at, end - at
    record.fields[5] = following - end
    record.fields[7] = end - at - PREFIX.size - 40 - len(record.fields[6])
    record.fields[8] = struct.unpack_from("<Q", data, at + PREFIX.size + 16)[0]
