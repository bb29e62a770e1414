"""The index at the end of a finished recording, which is used only if it agrees with its checksum, with itself and with the file."""

from __future__ import annotations

import struct
from dataclasses import dataclass, field
from pathlib import Path
from typing import BinaryIO, Dict, List, Optional, Tuple

from mcap.opcode import Opcode
from mcap.records import AttachmentIndex, ChunkIndex, MetadataIndex, Statistics

from ._chunks import CLOCK, LOG, ChunkSpan, Descriptions, Layout
from ._errors import damaged
from ._provenance import check_end
from ._records import MAGIC, PREFIX, Place, attachment_of, body_of, checksum, metadata_of, parsed, place_at, places

_FOOTER = struct.Struct("<QQI")
_DATA_END = struct.Struct("<BQI")
# Kind, length, channel, sequence and two times.
_MIN_MESSAGE_BYTES = 31


@dataclass
class Summary:
    """The index, and the records after the head and between the chunks."""

    path: Path
    descriptions: Descriptions
    data_end: int
    data_checksum: int
    statistics: Statistics
    indexes: List[ChunkIndex]
    metadata_indexes: List[MetadataIndex]
    attachment_indexes: List[AttachmentIndex]
    chunks: List[ChunkSpan] = field(default_factory=list)
    outcome: Dict[str, str] = field(default_factory=dict)
    metadata: List[Tuple[Place, str]] = field(default_factory=list)
    attachments: List[Tuple[Place, str]] = field(default_factory=list)

    def read_places(self, stream: BinaryIO, head_end: int) -> None:
        """The chunks, and what is between them: no byte of the data is left out, and no chunk is missing in the index."""
        at, entries = head_end, []
        self._open_block: List[ChunkSpan] = []
        self._block_end: Optional[int] = None
        self._latest: Dict[int, int] = {}
        for index in sorted(self.indexes, key=lambda index: index.chunk_start_offset):
            span = self._span(index, at)
            entries += self._between(stream, at, span.offset)
            self.chunks.append(span)
            self._add_to_block(span)
            at = span.end + index.message_index_length
            if at > self.data_end:
                raise damaged(self.path, "its index describes chunks beyond the end of the data")
        if self._open_block:
            raise damaged(self.path, "its index describes a block without its clocks")
        entries += self._between(stream, at, self.data_end)
        check_end(self.path, [name for _, name in self.metadata], entries)
        self.outcome = entries[-1]

    def _span(self, index: ChunkIndex, at: int) -> ChunkSpan:
        start, end = index.message_start_time, index.message_end_time
        offset, after = index.chunk_start_offset, index.chunk_start_offset + index.chunk_length
        if offset < at or index.chunk_length < PREFIX.size or start > end:
            raise damaged(self.path, "its index describes chunks that overlap")
        ends = (after, after + index.message_index_length)
        for channel, place in index.message_index_offsets.items():
            if channel not in self.descriptions.channels or not ends[0] <= place < ends[1]:
                raise damaged(self.path, "its index describes messages that are not in the chunk")
        return ChunkSpan(offset, after, start, end, index.uncompressed_size, frozenset(index.message_index_offsets))

    def _add_to_block(self, span: ChunkSpan) -> None:
        """Checks that chunks with a channel follow each other in time, and that the clocks of a block come after its other chunks."""
        log = self.descriptions.number_of(LOG)
        is_remark = span.channels == {log} and span.start_time == span.end_time == self._block_end
        is_early = self._block_end is not None and span.start_time <= self._block_end and not is_remark
        if is_early or any(self._latest.get(channel, -1) >= span.start_time for channel in span.channels - {log}):
            raise damaged(self.path, "its index describes chunks that are not in order")
        self._latest.update(dict.fromkeys(span.channels, span.end_time))
        if not self.descriptions.are_scalars(span.channels):
            self._open_block.append(span)
            return
        if any(not span.start_time <= other.start_time <= other.end_time <= span.end_time for other in self._open_block):
            raise damaged(self.path, "its index describes chunks that are not in order")
        self._block_end, self._open_block = span.end_time, []

    def _between(self, stream: BinaryIO, at: int, end: int) -> List[Dict[str, str]]:
        """Reads records between chunks, and returns the entries of the metadata among them."""
        found = []
        for place in places(self.path, stream, at, end):
            if place.kind == Opcode.METADATA:
                name, entries = metadata_of(self.path, stream, place)
                self.metadata.append((place, name))
                found.append(entries)
            elif place.kind == Opcode.ATTACHMENT:
                self.attachments.append((place, attachment_of(self.path, stream, place)[0]))
            elif place.kind in (Opcode.FOOTER, Opcode.DATA_END):
                raise damaged(self.path, f"the record at byte {place.start} is at a wrong place")
        return found

    def check_places(self, metadata: List[Tuple[Place, str]], attachments: List[Tuple[Place, str]]) -> None:
        """Compares the indexes and the statistics with the records, of which those of the head are given."""
        for indexes, found in (
            (self.metadata_indexes, metadata + self.metadata),
            (self.attachment_indexes, attachments + self.attachments),
        ):
            listed = sorted((index.offset, index.offset + index.length, index.name) for index in indexes)
            if listed != sorted((place.start, place.end, name) for place, name in found):
                raise damaged(self.path, "its index does not list its records")
        statistics, descriptions = self.statistics, self.descriptions
        counted = (
            statistics.metadata_count,
            statistics.attachment_count,
            statistics.chunk_count,
            statistics.channel_count,
            statistics.schema_count,
        )
        found_counts = (
            len(self.metadata_indexes),
            len(self.attachment_indexes),
            len(self.chunks),
            len(descriptions.channels),
            len(descriptions.schemas),
        )
        if counted != found_counts:
            raise damaged(self.path, f"its statistics {counted} are not those of its index {found_counts}")

    def check_frames(self, layout: Layout) -> None:
        """Compares the numbers of messages with the chunks, and the number of frames with their times."""
        statistics, counts = self.statistics, self.statistics.channel_message_counts
        times = (0, 0)
        if self.chunks:
            times = min(chunk.start_time for chunk in self.chunks), max(chunk.end_time for chunk in self.chunks)
        content = sum(chunk.size for chunk in self.chunks)
        indexed = {channel for index in self.indexes for channel in index.message_index_offsets}
        if (
            statistics.message_count != sum(counts.values())
            or (statistics.message_start_time, statistics.message_end_time) != times
            or statistics.message_count * _MIN_MESSAGE_BYTES > content
            or indexed != {channel for channel, count in counts.items() if count > 0}
        ):
            raise damaged(self.path, "its statistics do not count the messages of its chunks")
        clock, log = self.descriptions.number_of(CLOCK), self.descriptions.number_of(LOG)
        frames = 0 if clock is None else counts.get(clock, 0)
        if any(count > frames for channel, count in counts.items() if channel != log):
            raise damaged(self.path, "its statistics count more messages than frames")
        first = layout.stored.first
        if frames > 0 and times != (layout.log_time(first), layout.log_time(first + frames - 1)):
            raise damaged(self.path, f"its {frames} frames do not fill the time of the recording")
        self._check_states(frames, layout.stored.distance)

    def _check_states(self, frames: int, distance: int) -> None:
        """Compares the number of states with that of the frames: the last frame of a complete run has one as well."""
        channel = self.descriptions.number_of("/state")
        if channel is None or frames == 0:
            return
        states, regular = self.statistics.channel_message_counts.get(channel, 0), -(-frames // distance)
        with_last = regular if (frames - 1) % distance == 0 else regular + 1
        is_complete = self.outcome.get("outcome") == "complete"
        if states != with_last and (is_complete or states != regular):
            raise damaged(self.path, f"its statistics count {states} states of {frames} frames")


def read_summary(path: Path, stream: BinaryIO, size: int, head_end: int) -> Optional[Summary]:
    """Reads and checks the index; none if the file has none."""
    tail = size - len(MAGIC) - PREFIX.size - _FOOTER.size
    footer = place_at(path, stream, max(tail, 0), size - len(MAGIC))
    if footer.kind != Opcode.FOOTER or footer.end != size - len(MAGIC):
        raise damaged(path, "it does not end like an MCAP file")
    start, _, expected = _FOOTER.unpack(body_of(stream, footer))
    if start == 0:
        return None
    # The end of the data precedes the index; what does not is not read.
    data_end = start - _DATA_END.size
    if not head_end <= data_end < tail:
        raise damaged(path, "its index is not where its footer says")
    stream.seek(data_end)
    kind, length, data_checksum = _DATA_END.unpack(stream.read(_DATA_END.size))
    if (kind, length) != (Opcode.DATA_END, 4):
        raise damaged(path, "its index is not where its footer says")
    if checksum(stream, start, size - len(MAGIC) - 4) != expected:
        raise damaged(path, "wrong checksum of its index")
    summary = _parsed_summary(path, stream, start, tail, data_checksum)
    summary.read_places(stream, head_end)
    return summary


def _parsed_summary(path: Path, stream: BinaryIO, start: int, end: int, data_checksum: int) -> Summary:
    statistics: List[Statistics] = []
    indexes: List[ChunkIndex] = []
    metadata: List[MetadataIndex] = []
    attachments: List[AttachmentIndex] = []
    descriptions = Descriptions(path)
    for place in places(path, stream, start, end):
        body = body_of(stream, place)
        if place.kind in (Opcode.SCHEMA, Opcode.CHANNEL):
            descriptions.add(place.kind, body)
        elif place.kind == Opcode.STATISTICS:
            statistics.append(parsed(path, body, Statistics.read))
        elif place.kind == Opcode.CHUNK_INDEX:
            indexes.append(parsed(path, body, ChunkIndex.read))
        elif place.kind == Opcode.METADATA_INDEX:
            metadata.append(parsed(path, body, MetadataIndex.read))
        elif place.kind == Opcode.ATTACHMENT_INDEX:
            attachments.append(parsed(path, body, AttachmentIndex.read))
        elif place.kind == Opcode.FOOTER:
            raise damaged(path, "it has two ends")
    if len(statistics) != 1:
        raise damaged(path, f"its index has {len(statistics)} records of statistics")
    data_end = start - _DATA_END.size
    return Summary(path, descriptions, data_end, data_checksum, statistics[0], indexes, metadata, attachments)
