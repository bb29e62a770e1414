"""Guarantee: a damaged recording gives its recorded data or an error of this package, never other data or another exception.

Setup: small recordings of the four models. Bits of the summary are flipped one by one, and records are changed behind correct
checksums (`mutated_recording.py`). What is read from a changed file must be what another reader, `mcap.stream_reader`, finds in
it, and the program must read the file to its end. Control: the unchanged recordings are read.

`DAMAGE=full` flips every bit and reads 5,000 changed recordings; otherwise, a sample of them.
"""

from __future__ import annotations

import os
import random
import subprocess
from pathlib import Path
from typing import Any, Callable, Dict, List, Optional, Tuple

import numpy as np
import pytest
from mcap.records import Channel, Message, Metadata, Schema
from mcap.stream_reader import StreamReader
from mcap_protobuf.decoder import DecoderFactory
from mutated_recording import CHANNEL, CHUNK, MAGIC, MESSAGE, MutatedRecording, Record, encoded

import kinetoscope as k

SMALL = {
    "dem": "discs = 6\nwidth_m = 0.006\nheight_m = 0.006\nduration_s = 0.004\n",
    "gas": "particles = 6\nduration_s = 0.003\n",
    "packing": "discs = 6\nwidth = 10.0\nheight = 10.0\nevents_per_disc = 20\n",
    "orbit": "duration_days = 20.0\n",
}
IS_FULL = os.environ.get("DAMAGE") == "full"
FLIPS_PER_MODEL = 500
CHANGED_PER_MODEL = 1250 if IS_FULL else 100


@pytest.fixture(scope="module", params=SMALL)
def small(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory, programs: Optional[str]) -> Path:
    """A recording with state, clock and numbers, whose summary is small."""
    folder = tmp_path_factory.mktemp("small")
    manifest = folder / "small.toml"
    numbers = "temperature" if request.param == "packing" else "energy"
    record = f'[record]\nframes = 4\nchannels = ["state", "{numbers}"]\n'
    manifest.write_text(f"[model.{request.param}]\n{SMALL[request.param]}{record}", encoding="utf-8")
    return k.run(manifest, output=folder, programs=programs).runs[0].path


def contents(path: Path) -> Dict[str, Any]:
    """Everything that the package reads from a recording."""
    run = k.Run(path)
    found: Dict[str, Any] = {
        "": (run.model, run.run_key, run.time_unit, run.outcome, run.seed, run.manifest, run.topics, len(run))
    }
    for topic in run.topics:
        try:
            frames = run[topic]
        except k.RecordingError:
            raise
        except k.KinetoscopeError as error:
            # A drawing, a log, or the particles, which are read with the states.
            if "not numbers" not in str(error) and topic != "/particles":
                raise
            continue
        found[topic] = (frames.columns, tuple(frames.units.items()), [frame.tobytes() for frame in frames])
    return found


def found_by_another_reader(path: Path) -> Dict[str, Any]:
    """The tables of the numeric topics, by reading all records in order."""
    schemas: Dict[int, Schema] = {}
    channels: Dict[int, Channel] = {}
    found: Dict[str, Tuple[Tuple[str, ...], List[bytes]]] = {}
    particles: List[Tuple[Tuple[str, ...], bytes]] = []
    order: Tuple[str, ...] = ()
    factory = DecoderFactory()
    with path.open("rb") as stream:
        for record in StreamReader(stream, validate_crcs=True).records:
            if isinstance(record, Schema):
                schemas[record.id] = record
            elif isinstance(record, Channel):
                channels[record.id] = record
            elif isinstance(record, Metadata) and record.name == "kinetoscope":
                order = tuple(record.metadata["state_columns"].split(","))
            elif isinstance(record, Message):
                channel = channels[record.channel_id]
                schema = schemas[channel.schema_id]
                decode = factory.decoder_for("protobuf", schema)
                assert decode is not None
                columns, data = table(decode(record.data), schema.name)
                if channel.topic == "/particles":
                    particles = [(columns, data)]
                    continue
                if channel.topic == "/state":
                    columns, data = order, joined(order, [(columns, data), *particles])
                found.setdefault(channel.topic, (columns, []))[1].append(data)
    return found


def joined(order: Tuple[str, ...], tables: List[Tuple[Tuple[str, ...], bytes]]) -> bytes:
    """The rows of a state with the constants of the particles."""
    parts = [np.frombuffer(data, [(name, "<f8") for name in columns]) for columns, data in tables]
    rows = np.empty(len(parts[0]), [(name, "<f8") for name in order])
    for part in parts:
        for name in part.dtype.names or ():
            rows[name] = part[name]
    return rows.tobytes()


def table(message: Any, schema: str) -> Tuple[Tuple[str, ...], bytes]:
    """Columns and bytes of a message as the package returns them."""
    if schema == "foxglove.PointCloud":
        return tuple(field.name for field in message.fields), message.data
    fields = message.DESCRIPTOR.fields
    if not schema.startswith("kinetoscope."):
        return (), b""
    types = {1: "<f8", 4: "<u8", 9: "U16"}
    columns = [np.atleast_1d(getattr(message, field.name)) for field in fields]
    rows = np.empty(max(len(column) for column in columns), [(field.name, types[field.type]) for field in fields])
    for field, column in zip(fields, columns):
        rows[field.name] = column
    return tuple(field.name for field in fields), rows.tobytes()


def is_read_by_the_program(path: Path, programs: Optional[str]) -> bool:
    """Whether the program reads the recording to its end."""
    program = "kinetoscope" if programs is None else os.path.join(programs, "kinetoscope")
    return subprocess.run([program, "info", str(path)], capture_output=True).returncode == 0


class Tally:
    """What became of the changed files."""

    def __init__(self, original: Path, changed: Path, programs: Optional[str]) -> None:
        self.expected = contents(original)
        self.changed = changed
        self.programs = programs
        self.counts = dict.fromkeys(["same data", "data of the file", "error", "silent", "foreign"], 0)
        self.findings: List[str] = []

    def read(self, data: bytes, name: str) -> None:
        """Reads a changed file."""
        # A new file: ext4 writes a file that is truncated and written again to the disk at once.
        self.changed.unlink(missing_ok=True)
        self.changed.write_bytes(data)
        try:
            found = contents(self.changed)
        except k.KinetoscopeError:
            self.counts["error"] += 1
        except Exception as error:
            self._add("foreign", name, repr(error))
        else:
            self._compare(found, name)

    def _compare(self, found: Dict[str, Any], name: str) -> None:
        if found == self.expected:
            self.counts["same data"] += 1
        elif not is_read_by_the_program(self.changed, self.programs):
            self._add("silent", name, "the program rejects the file")
        else:
            self._compare_with_another_reader(found, name)

    def _compare_with_another_reader(self, found: Dict[str, Any], name: str) -> None:
        try:
            other = found_by_another_reader(self.changed)
        except Exception as error:
            self._add("silent", name, f"another reader: {error!r}")
            return
        tables = {topic: (value[0], value[2]) for topic, value in found.items() if topic}
        if tables == {topic: other.get(topic, (columns, [])) for topic, (columns, _) in tables.items()}:
            self.counts["data of the file"] += 1
        else:
            self._add("silent", name, "other data than another reader")

    def _add(self, kind: str, name: str, what: str) -> None:
        self.counts[kind] += 1
        self.findings.append(f"{kind}, {name}: {what}")

    def check(self) -> None:
        """Prints the tally, and fails if it has findings."""
        print(self.counts)
        assert self.counts["error"] > 0
        assert not self.findings, f"{self.counts}\n" + "\n".join(self.findings[:40])


def test_each_bit_of_the_summary_is_checked(small: Path, tmp_path: Path, programs: Optional[str]) -> None:
    data = bytearray(small.read_bytes())
    # The footer has 29 bytes, and begins with the place of the summary.
    footer = len(data) - len(MAGIC) - 29
    start = int.from_bytes(data[footer + 9 : footer + 17], "little")
    bits = range(8 * start, 8 * len(data))
    tally = Tally(small, tmp_path / "changed.mcap", programs)
    for bit in bits if IS_FULL else random.Random(1).sample(bits, FLIPS_PER_MODEL):
        data[bit // 8] ^= 1 << bit % 8
        tally.read(bytes(data), f"bit {bit % 8} of byte {bit // 8 - start} of the summary")
        data[bit // 8] ^= 1 << bit % 8
    tally.check()


def test_changed_records_are_errors_or_what_other_readers_find(
    small: Path, tmp_path: Path, programs: Optional[str]
) -> None:
    original = MutatedRecording(small.read_bytes())
    # Control: all records, decoded and encoded again.
    assert original.unchanged() == small.read_bytes()
    tally = Tally(small, tmp_path / "changed.mcap", programs)
    for seed in range(CHANGED_PER_MODEL):
        tally.read(original.changed(random.Random(f"{small.stem} {seed}")), f"seed {seed}")
    tally.check()


@pytest.fixture(scope="module")
def blocks(tmp_path_factory: pytest.TempPathFactory, programs: Optional[str]) -> Path:
    """A recording of five blocks, each with a chunk of drawings, of states and of scalars."""
    folder = tmp_path_factory.mktemp("blocks")
    manifest = folder / "blocks.toml"
    record = '[record]\nframes = 4\nchannels = ["state", "discs", "energy"]\nkeep = "keyframes"\nkeyframe_distance = 1\n'
    manifest.write_text(f"[model.gas]\n{SMALL['gas']}{record}", encoding="utf-8")
    return k.run(manifest, output=folder, programs=programs).runs[0].path


def test_missing_repeated_and_reordered_chunks_are_errors_or_what_other_readers_find(
    blocks: Path, tmp_path: Path, programs: Optional[str]
) -> None:
    original = MutatedRecording(blocks.read_bytes())
    count = original.chunks
    assert count == 15
    # Control: all chunks in their order.
    assert original.with_chunks(range(count)) == blocks.read_bytes()
    tally = Tally(blocks, tmp_path / "changed.mcap", programs)
    for chunk in range(count):
        others = [other for other in range(count) if other != chunk]
        tally.read(original.with_chunks(others), f"without chunk {chunk}")
        for place in range(count + 1):
            repeated = [*range(place), chunk, *range(place, count)]
            tally.read(original.with_chunks(repeated), f"chunk {chunk} again before {place}")
        for other in range(chunk):
            swapped = list(range(count))
            swapped[chunk], swapped[other] = other, chunk
            tally.read(original.with_chunks(swapped), f"chunks {other} and {chunk} swapped")
    tally.check()


def test_messages_in_chunks_of_other_groups_and_blocks_are_errors_or_what_other_readers_find(
    blocks: Path, tmp_path: Path, programs: Optional[str]
) -> None:
    original = MutatedRecording(blocks.read_bytes())
    tally = Tally(blocks, tmp_path / "changed.mcap", programs)
    for source in range(original.chunks):
        for target in range(original.chunks):
            if source != target:
                tally.read(original.with_moved_message(source, target), f"from chunk {source} to {target}")
    tally.check()


@pytest.mark.parametrize("small", ["dem", "packing"], indirect=True)
def test_particles_that_are_missing_late_or_of_another_number_are_errors(small: Path, tmp_path: Path) -> None:
    def read(change: Callable[[List[Record], List[Record]], None]) -> int:
        records = [record.copy() for record in MutatedRecording(small.read_bytes()).records]
        states = next(record.content for record in records if record.kind == CHUNK and has_particles(record.content))
        change(records, states)
        path = tmp_path / "changed.mcap"
        path.write_bytes(encoded(records, True, True))
        return len(list(k.Run(path)["/state"]))

    def has_particles(content: List[Record]) -> bool:
        return any(record.kind == CHANNEL and record.fields[2] == "/particles" for record in content)

    def messages(states: List[Record]) -> List[int]:
        return [place for place, record in enumerate(states) if record.kind == MESSAGE]

    def rename(records: List[Record], states: List[Record]) -> None:
        for record in records + states:
            if record.kind == CHANNEL and record.fields[2] == "/particles":
                record.fields[2] = "/other"

    def delay(records: List[Record], states: List[Record]) -> None:
        particles, first, second = messages(states)[:3]
        states[particles].fields[2:4] = states[second].fields[2:4]
        states[particles], states[first] = states[first], states[particles]

    def empty(records: List[Record], states: List[Record]) -> None:
        particles = states[messages(states)[0]]
        data = 6 * 8 * (3 if "mass" in k.Run(small)["/state"].columns else 1)
        # The data are the last field, after a tag and their length.
        particles.fields[4] = particles.fields[4][: -data - (3 if data >= 128 else 2)]

    assert read(lambda records, states: None) == 5
    for change, what in [
        (rename, "it has states without `/particles`"),
        (delay, "there is no message of `/particles` before it"),
        (empty, "6 particles, but 0 in `/particles`"),
    ]:
        with pytest.raises(k.RecordingError, match=what):
            read(change)
