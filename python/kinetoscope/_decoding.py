"""Messages as NumPy structured arrays."""

from __future__ import annotations

import re
from typing import Any, Callable, Iterator, List, Mapping, Sequence, Tuple, Union

import numpy as np
import numpy.typing as npt
from mcap.records import Schema

from ._errors import KinetoscopeError

Table = npt.NDArray[np.void]
# Decodes the message between two places of a chunk's content.
Decoder = Callable[[bytes, int, int], Table]

# Protobuf: the wire types.
VARINT, FIXED64, LENGTH, FIXED32 = 0, 1, 2, 5
# The wire types of a message's fields, and the layouts of the messages in them.
Layout = Tuple[Mapping[int, int], Mapping[int, Any]]
TIMESTAMP: Layout = ({1: VARINT, 2: VARINT}, {})
# One with its fields in their order, each at most once: a pattern is faster than a parser.
USUAL_TIMESTAMP = re.compile(rb"(?:\x08[\x80-\xff]{0,9}[\x00-\x7f])?(?:\x10[\x80-\xff]{0,9}[\x00-\x7f])?", re.DOTALL)
VECTOR: Layout = ({1: FIXED64, 2: FIXED64, 3: FIXED64}, {})
QUATERNION: Layout = ({1: FIXED64, 2: FIXED64, 3: FIXED64, 4: FIXED64}, {})
POSE: Layout = ({1: LENGTH, 2: LENGTH}, {1: VECTOR, 2: QUATERNION})
# `foxglove.PointCloud`, and `foxglove.PackedElementField` with its type FLOAT64.
FIELD_TIMESTAMP, FIELD_FRAME, FIELD_POSE, FIELD_STRIDE, FIELD_COLUMNS, FIELD_DATA = range(1, 7)
POINT_CLOUD = {1: LENGTH, 2: LENGTH, 3: LENGTH, 4: FIXED32, 5: LENGTH, 6: LENGTH}
MESSAGES = {FIELD_TIMESTAMP: TIMESTAMP, FIELD_POSE: POSE}
PACKED_FIELD = {1: LENGTH, 2: FIXED32, 3: VARINT}
FLOAT64 = 8
TAG_TIMESTAMP = 0x0A

# Types of protobuf fields in a descriptor, with those of NumPy. The only texts are units of time.
TEXT, LONGEST_TEXT = 9, 16
NUMPY_TYPES = {1: "<f8", 4: "<u8", TEXT: f"U{LONGEST_TEXT}"}
PARTICLES, STATE = "/particles", "/state"
# Names of the columns of the state that are on `/particles`, as in `src/recording/column.rs`.
CONSTANTS = ("id", "mass", "radius")
DISPLAYED = "`run.show()` displays the run; the exact state is in `/state`"


class BadMessage(ValueError):
    """A message that does not have its declared layout."""


def _varint(data: bytes, at: int, end: int) -> Tuple[int, int]:
    """A number and the place after it."""
    value = shift = 0
    while at < end:
        byte = data[at]
        value |= (byte & 0x7F) << shift
        at += 1
        if byte < 0x80:
            return value & 0xFFFF_FFFF_FFFF_FFFF, at
        shift += 7
        if shift > 63:
            raise BadMessage("a number with more than 64 bits")
    raise BadMessage("a number without its end")


# A field and its value: a number, or start and end of its bytes.
Field = Tuple[int, int, int]


def _fields(data: bytes, at: int, end: int, wires: Mapping[int, int]) -> Iterator[Field]:
    """The fields of a message, each with the start and the end of its value; `wires` are the wire types of known fields."""
    while at < end:
        tag, at = _varint(data, at, end)
        number, wire = tag >> 3, tag & 7
        if number == 0 or wires.get(number, wire) != wire:
            raise BadMessage(f"field {number} has wire type {wire}")
        start = at
        if wire == LENGTH:
            length, start = _varint(data, at, end)
            at = start + length
        elif wire == VARINT:
            _, at = _varint(data, at, end)
        elif wire in (FIXED32, FIXED64):
            at += 4 if wire == FIXED32 else 8
        else:
            raise BadMessage(f"wire type {wire}")
        if at > end:
            raise BadMessage("a field without its end")
        yield number, start, at


class StateDecoder:
    """Decodes `/state` or `/particles`, a `foxglove.PointCloud` whose data are rows of little-endian float64.

    Between time stamp and data, the messages of a run are equal unless the number of particles changes. These bytes are
    compared with those of the last message; only if they differ is the message parsed.
    """

    def __init__(self, columns: Sequence[str]) -> None:
        self.dtype: np.dtype[np.void] = np.dtype([(name, "<f8") for name in columns])
        self._expected = [(name.encode(), 8 * index, FLOAT64) for index, name in enumerate(columns)]
        self._between = b""
        self._data_bytes = -1

    def __call__(self, content: bytes, start: int, end: int) -> Table:
        if end - start >= 2 and content[start] == TAG_TIMESTAMP:
            between = start + 2 + content[start + 1]
            data = between + len(self._between)
            if data + self._data_bytes == end and content[between:data] == self._between:
                if not USUAL_TIMESTAMP.fullmatch(content, start + 2, between):
                    _check_message(content, start + 2, between, TIMESTAMP)
                return self._rows(content, data, end)
            data, end_of_data = self._parse(content, start, end)
            if end_of_data == end and data >= between and content[start + 1] < 0x80:
                self._between, self._data_bytes = content[between:data], end - data
            return self._rows(content, data, end_of_data)
        return self._rows(content, *self._parse(content, start, end))

    def _rows(self, content: bytes, start: int, end: int) -> Table:
        # A copy is aligned, may be changed, and does not keep the chunk in memory.
        rows: Table = np.empty((end - start) // self.dtype.itemsize, self.dtype)
        # As bytes: a copy of records would be one per column.
        rows.view(np.uint8)[:] = np.frombuffer(content, np.uint8, end - start, start)
        return rows

    def _parse(self, content: bytes, start: int, end: int) -> Tuple[int, int]:
        """Start and end of the data; an empty range if there are no particles."""
        data, stride, columns = (start, start), 0, []
        for number, at, after in _fields(content, start, end, POINT_CLOUD):
            if number == FIELD_DATA:
                data = (at, after)
            elif number == FIELD_STRIDE:
                stride = int.from_bytes(content[at:after], "little")
            elif number == FIELD_COLUMNS:
                columns.append(_column(content, at, after))
            elif number == FIELD_FRAME:
                content[at:after].decode("utf-8")
            elif number in MESSAGES:
                _check_message(content, at, after, MESSAGES[number])
        size = self.dtype.itemsize
        if stride != size or (data[1] - data[0]) % size:
            raise BadMessage(f"rows of {stride} bytes, expected {size}")
        if columns != self._expected:
            raise BadMessage("its columns are not those of the recording")
        return data


def _column(content: bytes, start: int, end: int) -> Tuple[bytes, int, int]:
    """Name, offset and type of a column."""
    name, offset, kind = b"", 0, 0
    for number, at, after in _fields(content, start, end, PACKED_FIELD):
        if number == 1:
            name = content[at:after]
        elif number == 2:
            offset = int.from_bytes(content[at:after], "little")
        elif number == 3:
            kind, _ = _varint(content, at, after)
    return name, offset, kind


def _check_message(content: bytes, start: int, end: int, layout: Layout) -> None:
    """Rejects a message whose fields have other wire types."""
    wires, inner = layout
    for number, at, after in _fields(content, start, end, wires):
        if number in inner:
            _check_message(content, at, after, inner[number])


class TableDecoder:
    """Decodes a message of Kinetoscope by the descriptor in the file: one row, or one row per entry of its columns."""

    def __init__(self, topic: str, schema: Schema) -> None:
        # Imported here: recordings of states alone are read without protobuf.
        from mcap_protobuf.decoder import DecoderFactory

        decoder = DecoderFactory().decoder_for("protobuf", schema)
        if decoder is None:
            raise KinetoscopeError(f"the schema {schema.name} is not Protobuf")
        self._decode: Callable[[bytes], Any] = decoder
        fields = self._decode(b"").DESCRIPTOR.fields
        self._columns: List[str] = [entry.name for entry in fields if _is_repeated(entry)]
        self._scalars: List[str] = [entry.name for entry in fields if not _is_repeated(entry)]
        if not all(entry.type in NUMPY_TYPES for entry in fields):
            raise not_numbers(topic, schema.name, DISPLAYED)
        self.dtype: np.dtype[np.void] = np.dtype([(entry.name, NUMPY_TYPES[entry.type]) for entry in fields])
        self._texts = [entry.name for entry in fields if entry.type == TEXT and not _is_repeated(entry)]

    def has_columns(self) -> bool:
        """Whether a message has several rows."""
        return bool(self._columns)

    def values(self, data: bytes) -> Tuple[object, ...]:
        """The fields of a message of one row."""
        message = self._decode(data)
        row = tuple([getattr(message, name) for name in self._scalars])
        self._check_texts(message)
        return row

    def _check_texts(self, message: Any) -> None:
        for name in self._texts:
            if len(getattr(message, name)) > LONGEST_TEXT:
                raise BadMessage(f"{name} is no unit")

    def __call__(self, content: bytes, start: int, end: int) -> Table:
        message = self._decode(content[start:end])
        columns = {name: np.asarray(getattr(message, name), self.dtype[name]) for name in self._columns}
        lengths = {len(column) for column in columns.values()} or {1}
        if len(lengths) > 1:
            raise BadMessage(f"columns of different lengths {sorted(lengths)}")
        table: Table = np.empty(lengths.pop(), self.dtype)
        for name, column in columns.items():
            table[name] = column
        self._check_texts(message)
        for name in self._scalars:
            table[name] = getattr(message, name)
        return table


def _is_repeated(entry: Any) -> bool:
    repeated = getattr(entry, "is_repeated", None)
    # Releases of protobuf before 6.31 have the label only.
    return bool(entry.label == 3) if repeated is None else bool(repeated)


def not_numbers(topic: str, schema: str, help: str) -> KinetoscopeError:
    """The error for a topic without numbers."""
    return KinetoscopeError(f"`{topic}` contains {schema}, not numbers", help)


def decoder_of(topic: str, schema: Schema, columns: Sequence[str]) -> Union[StateDecoder, TableDecoder]:
    """The decoder of a topic."""
    if schema.name == "foxglove.PointCloud":
        if topic == PARTICLES:
            raise KinetoscopeError(f"`{PARTICLES}` is read with `{STATE}`", f"`{STATE}` has its columns in every frame")
        return StateDecoder([name for name in columns if name not in CONSTANTS])
    if not schema.name.startswith("kinetoscope."):
        help = DISPLAYED
        if schema.name == "foxglove.Log":
            help = "`run.log` has its messages"
        raise not_numbers(topic, schema.name, help)
    return TableDecoder(topic, schema)
