"""Messages as NumPy structured arrays."""

from __future__ import annotations

from typing import Any, Callable, List, Sequence, Tuple, Union

import numpy as np
import numpy.typing as npt
from mcap.records import Schema

from ._errors import KinetoscopeError

Table = npt.NDArray[np.void]
# Decodes the message between two places of a chunk's content.
Decoder = Callable[[bytes, int, int], Table]

# Protobuf: tags of `foxglove.PointCloud`, and the wire types.
TAG_TIMESTAMP = 0x0A
FIELD_STRIDE = 4
FIELD_DATA = 6
VARINT, FIXED64, LENGTH, FIXED32 = 0, 1, 2, 5

# Types of protobuf fields in a descriptor, with those of NumPy. The only texts are units of time.
NUMPY_TYPES = {1: "<f8", 4: "<u8", 9: "U16"}


class BadMessage(ValueError):
    """A message that does not have its declared layout."""


def _varint(data: bytes, at: int) -> Tuple[int, int]:
    """A number and the place after it."""
    value = shift = 0
    while True:
        byte = data[at]
        value |= (byte & 0x7F) << shift
        at += 1
        if byte < 0x80:
            return value, at
        shift += 7
        if shift > 63:
            raise BadMessage("a number with more than 64 bits")


class StateDecoder:
    """Decodes `/state`, a `foxglove.PointCloud` whose data are rows of little-endian float64.

    Between time stamp and data, the messages of a run are equal unless the number of particles changes. These bytes are
    compared with those of the last message; only if they differ is the message parsed.
    """

    def __init__(self, columns: Sequence[str]) -> None:
        self.dtype = np.dtype([(name, "<f8") for name in columns])
        self._between = b""
        self._data_bytes = -1

    def __call__(self, content: bytes, start: int, end: int) -> Table:
        if end - start >= 2 and content[start] == TAG_TIMESTAMP:
            between = start + 2 + content[start + 1]
            data = between + len(self._between)
            if data + self._data_bytes == end and content[between:data] == self._between:
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
        at, data, stride = start, (start, start), 0
        while at < end:
            tag, at = _varint(content, at)
            number, wire = tag >> 3, tag & 7
            if wire == LENGTH:
                length, at = _varint(content, at)
                if number == FIELD_DATA:
                    data = (at, at + length)
                at += length
            elif wire == FIXED32:
                if number == FIELD_STRIDE:
                    stride = int.from_bytes(content[at : at + 4], "little")
                at += 4
            elif wire == FIXED64:
                at += 8
            elif wire == VARINT:
                _, at = _varint(content, at)
            else:
                raise BadMessage(f"wire type {wire}")
        size = self.dtype.itemsize
        if at != end or stride != size or (data[1] - data[0]) % size:
            raise BadMessage(f"rows of {stride} bytes, expected {size}")
        return data


class TableDecoder:
    """Decodes a message of Kinetoscope by the descriptor in the file: one row, or one row per entry of its columns."""

    def __init__(self, schema: Schema) -> None:
        # Imported here: recordings of states alone are read without protobuf.
        from mcap_protobuf.decoder import DecoderFactory

        decoder = DecoderFactory().decoder_for("protobuf", schema)
        if decoder is None:
            raise KinetoscopeError(f"the schema {schema.name} is not Protobuf")
        self._decode: Callable[[bytes], Any] = decoder
        fields = self._decode(b"").DESCRIPTOR.fields
        self._columns: List[str] = [entry.name for entry in fields if _is_repeated(entry)]
        self._scalars: List[str] = [entry.name for entry in fields if not _is_repeated(entry)]
        self.dtype = np.dtype([(entry.name, NUMPY_TYPES[entry.type]) for entry in fields])

    def __call__(self, content: bytes, start: int, end: int) -> Table:
        message = self._decode(content[start:end])
        columns = {name: np.asarray(getattr(message, name)) for name in self._columns}
        lengths = {len(column) for column in columns.values()} or {1}
        if len(lengths) > 1:
            raise BadMessage(f"columns of different lengths {sorted(lengths)}")
        table: Table = np.empty(lengths.pop(), self.dtype)
        for name, column in columns.items():
            table[name] = column
        for name in self._scalars:
            table[name] = getattr(message, name)
        return table


def _is_repeated(entry: Any) -> bool:
    repeated = getattr(entry, "is_repeated", None)
    # Releases of protobuf before 6.31 have the label only.
    return bool(entry.label == 3) if repeated is None else bool(repeated)


def decoder_of(topic: str, schema: Schema, columns: Sequence[str]) -> Union[StateDecoder, TableDecoder]:
    """The decoder of a topic."""
    if schema.name == "foxglove.PointCloud":
        return StateDecoder(columns)
    if not schema.name.startswith("kinetoscope."):
        help = "`run.show()` displays the run; the exact state is in `/state`"
        if schema.name == "foxglove.Log":
            help = "its text is read with the package `mcap`, and viewers such as Foxglove show it"
        raise KinetoscopeError(f"`{topic}` contains {schema.name}, not numbers", help)
    return TableDecoder(schema)
