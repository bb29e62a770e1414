"""The frames of a topic, read when they are needed."""

from __future__ import annotations

from bisect import bisect_right
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import ExitStack
from typing import TYPE_CHECKING, BinaryIO, Dict, Iterator, List, Mapping, Optional, Sequence, Tuple, Union, overload

import numpy as np
import numpy.typing as npt

from . import _units
from ._chunks import ChunkSpan, Content, Messages, check_content, read_chunk
from ._container import Container
from ._decoding import CONSTANTS, PARTICLES, STATE, BadMessage, StateDecoder, Table, TableDecoder, decoder_of
from ._errors import KinetoscopeError, RecordingError, UnknownNameError, damaged
from ._records import or_damaged

if TYPE_CHECKING:
    import xarray


# The distances of a merged recording's runs from the first one.
SEPARATION = "/separation"


class Frames:
    """The frames of one topic: a sequence of NumPy structured arrays that are read when they are needed.

    Iteration holds one chunk of the file and one frame in memory. ``frames[i]`` reads one chunk, and a slice is again
    a lazy sequence. The arrays are copies: they may be changed and kept.

    >>> state = recording["/state"]
    >>> len(state), state.columns[:4]
    (251, ('x', 'y', 'vx', 'vy'))
    >>> [round(float(frame["y"].mean()), 4) for frame in state[::100]]
    [0.0184, 0.0009, 0.0005]
    >>> state.units["vx"]
    'm/s'
    """

    def __init__(self, container: Container, topic: str, selection: Optional[Sequence[int]] = None) -> None:
        self._container = container
        self.topic = topic
        channel = container.channel(topic)
        topics = container.topics()
        if channel is None:
            raise UnknownNameError.of("topic", topic, topics)
        self._channel = channel
        provenance = container.metadata["kinetoscope"]
        columns = provenance["state_columns"].split(",")
        self._state_units = dict(zip(columns, provenance["state_units"].split(",")))
        self._state_columns = columns
        # Rejects drawings before the first frame is requested.
        self.dtype: np.dtype[np.void] = self._decoder().dtype
        if self._has_particles():
            self.dtype = np.dtype([(name, "<f8") for name in columns])
        self._selection = self._recorded(topics) if selection is None else selection

    @property
    def columns(self) -> Tuple[str, ...]:
        """The names of the columns."""
        return self.dtype.names or ()

    @property
    def units(self) -> Mapping[str, str]:
        """The units of the columns: ``1`` for numbers and ratios, empty for the own units of a dimensionless model.

        >>> recording["/energy"].units["kinetic_j"], recording["/contact_statistics"].units["coordination_number"]
        ('J', '1')
        """
        if self.topic == STATE:
            return {name: self._state_units.get(name, "") for name in self.columns}
        if self.topic == SEPARATION:
            return _units.of_separation(self.columns, self._state_units.get("x", ""))
        provenance = self._container.metadata["kinetoscope"]
        return _units.of_fields(provenance["model"], self.columns, provenance["time_unit"])

    @property
    def indices(self) -> Sequence[int]:
        """The numbers of these frames in the run; 0 is the start. A recording of keyframes has a part of the states."""
        return self._selection

    @property
    def times(self) -> npt.NDArray[np.float64]:
        """The simulated time of each frame, in the unit of the recording."""
        clocks = Frames(self._container, "/frame", self._selection)
        return np.fromiter((clock["time"][0] for clock in clocks), np.float64, len(clocks))

    def _recorded(self, topics: Mapping[str, int]) -> Sequence[int]:
        """The numbers of the frames that the topic has: all, or those of the keyframes and the last one."""
        known = self._container.frames_of.get(self.topic)
        if known is not None:
            return known
        first, distance = self._container.layout.stored
        all_frames = range(first, first + topics.get("/frame", 0))
        count = topics[self.topic]
        keyframes = all_frames[::distance]
        if count == len(all_frames):
            return all_frames
        if count == len(keyframes) + 1:
            return (*keyframes, all_frames[-1])
        return keyframes[:count] if distance > 1 else range(first, first + count)

    def __len__(self) -> int:
        return len(self._selection)

    def __repr__(self) -> str:
        return f"<{len(self)} frames of {self.topic}: {', '.join(self.columns)}>"

    @overload
    def __getitem__(self, index: int) -> Table: ...

    @overload
    def __getitem__(self, index: slice) -> "Frames": ...

    def __getitem__(self, index: Union[int, slice]) -> Union[Table, "Frames"]:
        if isinstance(index, slice):
            return Frames(self._container, self.topic, self._selection[index])
        if isinstance(index, str):
            raise self._column_of_all(index)
        try:
            frame = self._selection[index]
        except IndexError:
            raise IndexError(f"frame {index} of {len(self)} frames{self._all_frames_help()}") from None
        return next(self._read((frame,)))

    def __iter__(self) -> Iterator[Table]:
        return self._read(self._selection)

    def _all_frames_help(self) -> str:
        """What restores the other frames, in an error on a recording of keyframes."""
        distance, path = self._container.layout.stored.distance, self._container.path
        if distance == 1 or self.topic != STATE or self._container.frames_of:
            return ""
        return (
            f": this recording has the states of every {distance}th frame, whose numbers are `.indices`\n"
            f"help: `kinetoscope fill {path}` restores those of all frames"
        )

    def _column_of_all(self, name: str) -> KinetoscopeError:
        """The error for a column of all frames, which would be the whole file."""
        if name not in self.columns:
            return UnknownNameError.of("column", name, self.columns)
        topic = f'["{self.topic}"]'
        return KinetoscopeError(
            f"`{topic}` has frames, and each frame has the column `{name}`",
            f'`run{topic}[0]["{name}"]` is that of one frame; `run{topic}.array()["{name}"]` is that of all frames in memory',
        )

    def array(self) -> Table:
        """All frames in memory: one row per frame, one column per particle.

        >>> recording["/state"][:5].array().shape
        (5, 20)
        """
        whole: Table = np.empty((0, 0), self.dtype)
        for row, frame in enumerate(self):
            if row == 0:
                whole = np.empty((len(self), len(frame)), self.dtype)
            if len(frame) != whole.shape[1]:
                raise KinetoscopeError(
                    f"frame {self.indices[row]} of `{self.topic}` has {len(frame)} rows, the first one {whole.shape[1]}",
                    "iterate over the frames instead",
                )
            whole[row] = frame
        return whole

    def to_xarray(self, index: Optional[int] = None) -> "xarray.Dataset":
        """An ``xarray.Dataset`` of one frame, or of all frames with the coordinates ``frame`` and ``time``."""
        try:
            import xarray
        except ImportError as error:
            raise KinetoscopeError(
                "the package `xarray` is not installed", "`pip install 'kinetoscope[xarray]'`"
            ) from error
        selected = self
        if index is not None:
            # Negative numbers and numbers beyond the end as for lists.
            frame = self._selection[index]
            selected = Frames(self._container, self.topic, (frame,))
        whole, dimensions = selected.array(), ("frame", "particle" if self.topic == "/state" else "row")
        variables = {
            name: (dimensions, whole[name], {"units": self.units[name]} if self.units.get(name) else {})
            for name in self.columns
        }
        unit = self._container.metadata["kinetoscope"]["time_unit"]
        times = ("frame", selected.times, {"units": unit} if unit else {})
        dataset = xarray.Dataset(variables, {"frame": list(selected.indices), "time": times})
        return dataset if index is None else dataset.isel(frame=0)

    def _rows(self) -> Tuple[Table, List[int], npt.NDArray[np.float64]]:
        """The rows of all frames in memory, their number in each frame, and the time of each."""
        decode, clock = self._decoder(), Frames(self._container, "/frame", ())._decoder()
        if isinstance(decode, TableDecoder) and isinstance(clock, TableDecoder) and not decode.has_columns():
            values: List[Tuple[object, ...]] = []
            times: List[object] = []
            at = clock.dtype.names.index("time") if clock.dtype.names else 0
            with self._container.open() as stream:
                places = Places(self._container, self._channel.id, stream)
                for frame in self._selection:
                    log_time = self._container.layout.log_time(frame)
                    content, start, end = places.find(frame, log_time)
                    found = places.clock(log_time)
                    if found is None:
                        break
                    try:
                        values.append(decode.values(content[start:end]))
                        times.append(clock.values(content[found[0] : found[1]])[at])
                    except Exception as error:
                        raise damaged(self._container.path, f"frame {frame} of {self.topic}: {error}") from error
            if len(values) == len(self._selection):
                return np.array(values, decode.dtype), [1] * len(values), np.array(times, np.float64)
        tables = list(self)
        whole = np.concatenate(tables) if tables else np.empty(0, self.dtype)
        return whole, [len(table) for table in tables], self.times

    def _has_particles(self) -> bool:
        return self.topic == STATE and any(name in CONSTANTS for name in self._state_columns)

    def _decoder(self) -> Union[StateDecoder, TableDecoder]:
        try:
            return decoder_of(self.topic, self._container.schemas[self._channel.schema_id], self._state_columns)
        except ImportError:
            # A missing package is no damage.
            raise
        except Exception as error:
            what = f"the schema of {self.topic} cannot be read"
            raise or_damaged(self._container.path, what, error) from error

    def _read(self, selection: Sequence[int]) -> Iterator[Table]:
        if len(selection) == 0:
            return
        decode = self._decoder()
        with ExitStack() as stack:
            stream = stack.enter_context(self._container.open())
            places = Places(self._container, self._channel.id, stream)
            particles = None
            if self._has_particles():
                own_stream = stack.enter_context(self._container.open())
                particles = _Particles(self._container, own_stream, self.dtype)
            if len(selection) > 1 and places.are_several():
                _keep_freed_memory()
                places.read_ahead = stack.enter_context(ThreadPoolExecutor(1))
            for frame in selection:
                log_time = self._container.layout.log_time(frame)
                content, start, end = places.find(frame, log_time)
                constants = None if particles is None else particles.find(log_time)
                try:
                    table = decode(content, start, end)
                    if particles is not None:
                        table = particles.joined(table, constants)
                except MemoryError:
                    raise
                except Exception as error:
                    raise damaged(self._container.path, f"frame {frame} of {self.topic}: {error}") from error
                yield table


def _keep_freed_memory() -> None:
    """Makes glibc keep freed blocks of a chunk's size instead of returning them to the system for every chunk.

    It keeps blocks up to the size of the largest one that was freed. This one is never written, so it takes no memory.
    Measured: a tenth of the time of an iteration (2026-11).
    """
    bytearray(24 << 20)


class _Particles:
    """The constants of the particles, which are recorded when they change, as columns of the states until then."""

    def __init__(self, container: Container, stream: BinaryIO, dtype: np.dtype[np.void]) -> None:
        channel = container.channel(PARTICLES)
        if channel is None:
            raise damaged(container.path, f"it has states without `{PARTICLES}`")
        self._container = container
        self._is_single = container.message_counts.get(channel.id) == 1
        self._places = Places(container, channel.id, stream)
        self._dtype = dtype
        self._decode = StateDecoder([name for name in dtype.names or () if name in CONSTANTS])
        self._place: Tuple[bytes, int, int] = (b"", 0, 0)
        self._table: Optional[Table] = None

    def find(self, log_time: int) -> Optional[Tuple[bytes, int, int]]:
        """The place of the message of a state; none if it is not needed, or if there is none."""
        if self._container.particles is not None:
            return None
        return self._places.find_last(log_time)

    def joined(self, state: Table, place: Optional[Tuple[bytes, int, int]]) -> Table:
        """All columns of a state."""
        constants = self._container.particles
        if constants is None:
            constants = self._read(place)
            layout = self._container.layout
            if self._is_single and self._places.find_last(layout.log_time(layout.stored.first)) is not None:
                # Those of all frames: a jump would read their chunk again.
                self._container.particles = constants
        if len(constants) != len(state):
            raise BadMessage(f"{len(state)} particles, but {len(constants)} in `{PARTICLES}`")
        table: Table = np.empty(len(state), self._dtype)
        for part in (state, constants):
            for name in part.dtype.names or ():
                table[name] = part[name]
        return table

    def _read(self, place: Optional[Tuple[bytes, int, int]]) -> Table:
        if place is None:
            raise BadMessage(f"there is no message of `{PARTICLES}` before it")
        if self._table is None or place[0] is not self._place[0] or place != self._place:
            self._table, self._place = self._decode(*place), place
        return self._table


class Places:
    """The messages of a channel in the chunk that was read last; chunks without the channel are not read.

    While its frames are used, a thread decompresses the next chunk, unless it is small or has one large frame. When all
    chunks were read in order, the number of messages is compared with the statistics of the file.
    """

    MIN_AHEAD_BYTES = 256 << 10
    MAX_AHEAD_BYTES = 16 << 20

    def __init__(self, container: Container, channel_id: int, stream: BinaryIO) -> None:
        self.read_ahead: Optional[ThreadPoolExecutor] = None
        self._container = container
        self._channel_id = channel_id
        self._stream = stream
        chunks = enumerate(container.chunks)
        # Numbers of the chunks with the channel.
        self._numbers: List[int] = [number for number, chunk in chunks if channel_id in chunk.channels]
        self._starts: List[int] = [container.chunks[number].start_time for number in self._numbers]
        self._chunk = -1
        self._next: Optional[Tuple[int, "Future[Content]"]] = None
        self._content = b""
        self._messages: Dict[int, Tuple[int, int]] = {}
        self._lines: List[Tuple[int, int, int]] = []
        self._clocks: Dict[int, Tuple[int, int]] = {}
        self._count = 0
        self._in_order = 0

    def are_several(self) -> bool:
        """Whether more than one chunk has the channel."""
        return len(self._numbers) > 1

    def find(self, frame: int, log_time: int) -> Tuple[bytes, int, int]:
        """The content of the chunk with a frame, and the place of the frame's message in it."""
        place = self._messages.get(log_time)
        if place is None:
            self._read(bisect_right(self._starts, log_time) - 1)
            place = self._messages.get(log_time)
        if place is None:
            if self._container.layout.stored != (0, 1):
                raise RecordingError(
                    f"{self._container.path} does not have frame {frame}: it keeps a part of the frames",
                    f"`kinetoscope fill {self._container.path}` restores all frames of a recording of keyframes",
                )
            raise damaged(self._container.path, f"frame {frame} is missing")
        return self._content, place[0], place[1]

    def clock(self, log_time: int) -> Optional[Tuple[int, int]]:
        """The place of a frame's clock in the content that was read last; none if it is in another chunk."""
        return self._clocks.get(log_time)

    def find_last(self, log_time: int) -> Optional[Tuple[bytes, int, int]]:
        """The same of the last message up to a time; none if there is none."""
        for position in range(bisect_right(self._starts, log_time) - 1, -1, -1):
            self._read(position)
            earlier = [time for time in self._messages if time <= log_time]
            if earlier:
                start, end = self._messages[earlier[-1]]
                return self._content, start, end
        return None

    def lines(self) -> Iterator[Tuple[bytes, int, int, int]]:
        """The messages of the log, with their log times and places in the content of their chunks."""
        for position in range(len(self._numbers)):
            self._read(position)
            for line in self._lines:
                yield (self._content, *line)

    def _read(self, position: int) -> None:
        if position in (self._chunk, -1):
            return
        # The last chunk is released before the next one is decompressed.
        self._content, self._messages, self._chunk = b"", {}, position
        container, number = self._container, self._numbers[position]
        try:
            content = self._unpacked(position)
            check_content(container.path, content)
            messages = self._scanned(number, content)
        except MemoryError:
            raise
        except Exception as error:
            raise or_damaged(container.path, f"chunk {number} cannot be read", error) from error
        self._content, self._messages, self._lines = content.data, messages.places, messages.lines
        self._clocks = messages.clocks
        if position == self._in_order:
            self._count_in_order(messages.counts.get(self._channel_id, 0))

    def _scanned(self, number: int, content: Content) -> Messages:
        """The messages of a chunk, which agree with the index."""
        container = self._container
        span = container.chunks[number]
        known, end = container.before_chunk(number)
        messages = Messages(container.layout, known, self._channel_id)
        messages.scan(content.data, end)
        times = content.start_time, content.end_time
        found = ChunkSpan(span.offset, span.end, *times, len(content.data), frozenset(messages.counts))
        if times != (messages.first_time, messages.last_time) or found != span:
            raise damaged(container.path, f"chunk {number} is not that of the index")
        if not container.descriptions.has_all_of(known):
            raise damaged(container.path, f"chunk {number} has other channels than the index")
        return messages

    def _count_in_order(self, messages: int) -> None:
        """Counts the messages of chunks that are read in order."""
        container = self._container
        self._count += messages
        self._in_order += 1
        if self._in_order == len(self._numbers) and self._count != container.message_counts.get(self._channel_id, 0):
            raise damaged(container.path, "it has other numbers of messages than its statistics")

    def _unpacked(self, position: int) -> Content:
        if self.read_ahead is None or (self._next is None and self._size(position) < self.MIN_AHEAD_BYTES):
            return self._unpack(position)
        # The thread is the only one that reads the file.
        ready, self._next = self._next, None
        future = ready[1] if ready and ready[0] == position else self.read_ahead.submit(self._unpack, position)
        is_sequential = ready is None or ready[0] == position
        following = position + 1
        if is_sequential and following < len(self._numbers):
            if self.MIN_AHEAD_BYTES <= self._size(following) <= self.MAX_AHEAD_BYTES:
                self._next = (following, self.read_ahead.submit(self._unpack, following))
        return future.result()

    def _size(self, position: int) -> int:
        return self._container.chunks[self._numbers[position]].size

    def _unpack(self, position: int) -> Content:
        container, number = self._container, self._numbers[position]
        span = container.chunks[number]
        content = read_chunk(container.path, self._stream, span.offset, span.end)
        if span.offset + content.record_bytes != span.end:
            raise damaged(container.path, f"chunk {number} is not that of the index")
        return content
