"""Reads recordings with the readers of other projects and reports the result.

Usage: python check_recording.py RECORDING.mcap ...    (packages: requirements.txt)

For each file: every checksum of the container is validated, the summary is compared with the data as by `mcap doctor`, every message
is decoded by the schema that the file itself contains, and the rules of recordings/README.md are checked. Exit code 1 at the first file that violates a rule.
"""

import io
import sys
from itertools import groupby
from pathlib import Path

from mcap.reader import make_reader
from mcap.records import Channel, Chunk, ChunkIndex, DataEnd, Message, Schema, Statistics
from mcap.stream_reader import StreamReader, breakup_chunk
from mcap_protobuf.decoder import DecoderFactory

MAGIC = b"\x89MCAP0\r\n"
CHUNK_HEAD = 9 + 8 + 8 + 8 + 4 + 4 + 8  # bytes of a chunk record without the name of its compression and its content
CONSTANTS = {"id", "mass", "radius"}  # columns of the state that are on `/particles`
FLOAT64 = 8  # foxglove.PackedElementField.NumericType
DRAWN_AT_THE_START = {"/walls", "/legend"}  # moving walls are drawn in every frame
DRAWN_EVERY_FRAME = {"/discs", "/velocity", "/force_chains", "/trail"}


def require(holds, what):
    if not holds:
        raise AssertionError(what)


def check_container(path):
    """All checksums, with chunks unpacked: chunks, data section, attachments."""
    messages, chunks = 0, 0
    with open(path, "rb") as stream:
        for record in StreamReader(stream, validate_crcs=True).records:
            messages += isinstance(record, Message)
    with open(path, "rb") as stream:
        for record in StreamReader(stream, emit_chunks=True, validate_crcs=True).records:
            if isinstance(record, Chunk):
                chunks += 1
                # Only the first block, with a chunk for each of three groups, can consist of the start alone.
                require(
                    (record.message_start_time, record.message_end_time) != (0, 0) or chunks <= 3,
                    f"chunk {chunks} has no time range",
                )
    return messages, chunks


def check_index(path):
    """The errors that `mcap doctor` reports: indexes, channels and statistics of the summary against the data section."""
    with open(path, "rb") as stream:
        content = stream.read()
    chunks, indexes, counts, times = {}, {}, {}, []
    declared, repeated, used, statistics, is_summary = {}, {}, {}, None, False
    offset, kinds = len(MAGIC), (Channel, Schema)
    for record in StreamReader(io.BytesIO(content), emit_chunks=True, validate_crcs=True).records:
        if isinstance(record, Chunk):
            start = content.index(record.data, offset) - len(record.compression) - CHUNK_HEAD
            chunks[start], offset = record, start
            used[start] = set()
            for inner in breakup_chunk(record, validate_crc=True):
                if isinstance(inner, kinds):
                    require(declared.setdefault((type(inner), inner.id), inner) == inner, f"{inner} is declared twice")
                else:
                    require((Channel, inner.channel_id) in declared, f"channel {inner.channel_id} is not declared")
                    used[start].add(inner.channel_id)
                    counts[inner.channel_id] = counts.get(inner.channel_id, 0) + 1
                    require(
                        record.message_start_time <= inner.log_time <= record.message_end_time,
                        f"a message is outside of the times of the chunk at {start}",
                    )
                    times.append(inner.log_time)
        elif isinstance(record, DataEnd):
            is_summary = True
        elif is_summary and isinstance(record, kinds):
            require(statistics is None, "the statistics precede a channel")
            repeated[type(record), record.id] = record
        elif isinstance(record, ChunkIndex):
            indexes[record.chunk_start_offset] = record
        elif isinstance(record, Statistics):
            statistics = record
    require(repeated == declared, "the summary does not repeat the schemas and channels")
    require(indexes.keys() == chunks.keys(), "the index does not name the chunks")
    for start, chunk in chunks.items():
        index = indexes[start]
        length = CHUNK_HEAD + len(chunk.compression) + len(chunk.data)
        found = chunk.message_start_time, chunk.message_end_time, chunk.compression, chunk.uncompressed_size
        stated = index.message_start_time, index.message_end_time, index.compression, index.uncompressed_size
        require(found == stated, f"the index contradicts the chunk at {start}")
        require((index.chunk_length, index.compressed_size) == (length, len(chunk.data)), f"sizes of chunk {start}")
        require(index.message_index_offsets.keys() == used[start], f"channels of the chunk at {start}")
    require(statistics.channel_message_counts == counts, "the statistics miscount the messages of a channel")
    require((statistics.message_start_time, statistics.message_end_time) == (min(times), max(times)), "time range")
    require((statistics.schema_count, statistics.channel_count) == count_kinds(declared), "number of channels")


def count_kinds(declared):
    kinds = [kind for kind, _ in declared]
    return kinds.count(Schema), kinds.count(Channel)


def check_scene(topic, scene):
    require(len(scene.entities) == 1, f"{topic} has {len(scene.entities)} entities")
    entity = scene.entities[0]
    require(entity.id == topic[1:], f"{topic}: entity {entity.id}")
    for cylinder in entity.cylinders:
        require(cylinder.bottom_scale == cylinder.top_scale == 1.0, f"{topic}: an invisible disc")
        require(cylinder.color.a == 1.0, f"{topic}: a disc that is an outline")
        require(cylinder.size.x == cylinder.size.y > 0.0, f"{topic}: a disc without a size")
    for line in entity.lines:
        require(line.color.a == 1.0 and line.scale_invariant, f"{topic}: a line that can't be seen")
    return entity


def check_table(topic, cloud, columns):
    """The number of rows."""
    names = [field.name for field in cloud.fields]
    columns = [name for name in columns if (name in CONSTANTS) == (topic == "/particles")]
    require(names == columns, f"{topic} has columns {names}, the provenance {columns}")
    require(all(field.type == FLOAT64 for field in cloud.fields), f"{topic} is not FLOAT64")
    require(cloud.point_stride == 8 * len(columns), f"{topic} has a wrong stride")
    require(len(cloud.data) % cloud.point_stride == 0, f"{topic} ends inside a row")
    return len(cloud.data) // cloud.point_stride


def in_frames(reader):
    """Channels and messages in the order of log times, those of a frame in the order of their channels."""
    for _, frame in groupby(reader.iter_decoded_messages(), lambda found: found[2].log_time):
        yield from sorted((found[1:] for found in frame), key=lambda found: found[0].id)


def check_messages(reader, provenance, statistics):
    rate = float(provenance["playback_fps"])
    columns = provenance["state_columns"].split(",")
    frame, log_time, counts, particles = -1, None, {}, None
    for channel, message, decoded in in_frames(reader):
        topic = channel.topic
        counts[topic] = counts.get(topic, 0) + 1
        if topic == "/frame":
            frame, log_time = frame + 1, message.log_time
            require(decoded.frame == frame, f"frame {decoded.frame} stands where {frame} should")
            require(abs(log_time - frame * 1e9 / rate) <= 1, f"frame {frame} plays at {log_time} ns")
        require(message.log_time == message.publish_time == log_time, f"{topic} is outside of its frame")
        if hasattr(decoded, "timestamp") and topic != "/particles":
            stamp = decoded.timestamp.seconds * 10**9 + decoded.timestamp.nanos
            require(stamp == log_time, f"{topic}: timestamp {stamp}, log time {log_time}")
        if topic == "/particles":
            particles = check_table(topic, decoded, columns)
        elif topic == "/state":
            rows = check_table(topic, decoded, columns)
            require(rows == particles or not CONSTANTS & set(columns), f"{rows} rows, {particles} in /particles")
        elif topic in DRAWN_EVERY_FRAME | DRAWN_AT_THE_START:
            check_scene(topic, decoded)
    for topic in counts:
        every_frame = topic in {"/frame", "/state"} | DRAWN_EVERY_FRAME
        require(not every_frame or counts[topic] == frame + 1, f"{topic}: {counts[topic]} messages")
        moves = topic == "/walls" and counts[topic] == frame + 1
        at_start = topic in DRAWN_AT_THE_START
        require(not at_start or counts[topic] == 1 or moves, f"{topic}: {counts[topic]} messages")
    require(statistics.message_start_time == 0, "the time range does not start at 0")
    require(statistics.message_end_time == log_time, "the time range does not end at the last frame")
    return frame + 1, counts


def check(path):
    messages, chunks = check_container(path)
    check_index(path)
    with open(path, "rb") as stream:
        reader = make_reader(stream, validate_crcs=True, decoder_factories=[DecoderFactory()])
        require(reader.get_header().library == "kinetoscope", "another program's file")
        attachments = {attachment.name: attachment for attachment in reader.iter_attachments()}
        require(attachments["manifest.toml"].data.decode("utf-8"), "no manifest")
        metadata = {record.name: record.metadata for record in reader.iter_metadata()}
        outcome = metadata["kinetoscope.outcome"]["outcome"]
        require(outcome in {"complete", "fault", "interrupted"}, f"outcome {outcome}")
        statistics = reader.get_summary().statistics
        require(statistics.message_count == messages, "the statistics miscount the messages")
        require(statistics.chunk_count == chunks, "the statistics miscount the chunks")
        frames, counts = check_messages(reader, metadata["kinetoscope"], statistics)
    topics = ", ".join(f"{topic} {count}" for topic, count in counts.items())
    print(f"{path}: {outcome}, {frames} frames, {messages} messages, {chunks} chunks: {topics}")


def main():
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    for name in sys.argv[1:]:
        try:
            check(Path(name))
        except Exception as error:  # any failure of another reader is a finding
            sys.exit(f"{name}: {type(error).__name__}: {error}")


if __name__ == "__main__":
    main()
