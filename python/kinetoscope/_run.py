"""One run: its recording."""

from __future__ import annotations

import contextlib
import os
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Dict, Iterator, List, Literal, Optional, Tuple, overload

import numpy as np
import numpy.typing as npt

from . import _folder, _log, _player, _programs, _tables, _toml
from ._container import Container, load
from ._errors import RecordingError, damaged
from ._frames import Frames

if TYPE_CHECKING:
    import pandas
    import polars

    from ._experiment import Experiment


@dataclass(frozen=True)
class Verification:
    """Whether a rerun gave the same recording; true if it did."""

    is_equal: bool
    findings: Tuple[str, ...]

    def __bool__(self) -> bool:
        return self.is_equal

    def __str__(self) -> str:
        return "\n".join(self.findings)


class Run:
    """One run, by its recording.

    A recording is unfinished if its run was interrupted or is in progress, or if the end of the file is missing, as in an
    incomplete copy (a torn file). Opening it is an error unless ``allow_torn=True``: then the frames before the end, or
    before the first damage, can be read, and ``outcome`` is ``interrupted`` or ``unfinished``.

    >>> recording.model, recording.seed, recording.outcome
    ('dem', 1, 'complete')
    >>> recording.manifest["model"]["dem"]["discs"]
    20
    >>> recording.topics[:3]
    ('/contact_statistics', '/discs', '/energy')
    """

    def __init__(
        self,
        path: _programs.PathLike,
        *,
        allow_torn: bool = False,
        programs: Optional[_programs.PathLike] = None,
        experiment: Optional["Experiment"] = None,
    ) -> None:
        place = _programs.absolute(path)
        self._open(load(place, allow_torn), place, programs, experiment)
        outcome = self._outcome
        if outcome == "interrupted" and not allow_torn:
            raise RecordingError(
                f"{self.path} is the recording of an interrupted run",
                "run the same experiment again to complete it, or read its frames with "
                "`kinetoscope.Run(path, allow_torn=True)`",
            )

    def _open(
        self,
        container: Container,
        path: Path,
        programs: Optional[_programs.PathLike],
        experiment: Optional["Experiment"] = None,
    ) -> None:
        self.path: Path = path
        self._programs = programs
        self._experiment = experiment
        self._container = container
        self._provenance = container.metadata["kinetoscope"]
        self._outcome = container.metadata.get("kinetoscope.outcome", {}).get("outcome", "unfinished")

    def _has_keyframes(self) -> bool:
        return self._container.layout.stored.distance != 1

    def _with_all_frames(self) -> "Run":
        """The recording in which `kinetoscope fill` restored the frames of this one of keyframes; else this one."""
        if not self._has_keyframes():
            return self
        path = _folder.restored(self.path, self._container.manifest, self._provenance)
        if path is None or not path.is_file():
            return self
        return Run(path, programs=self._programs, experiment=self._experiment)

    def __repr__(self) -> str:
        return f"<run {self.path.stem}: {self.model}, {len(self)} frames, {self.outcome}>"

    def __len__(self) -> int:
        """The number of frames."""
        return self._container.topics().get("/frame", 0)

    def __getitem__(self, topic: str) -> Frames:
        """The frames of a topic, such as ``/state``."""
        return Frames(self._container, topic)

    # Without it, `in` and `iter` would ask for topics 0, 1, 2, …
    __iter__ = None

    def __contains__(self, topic: object) -> bool:
        return topic in self._container.topics()

    @property
    def topics(self) -> Tuple[str, ...]:
        """The recorded topics."""
        return tuple(self._container.topics())

    @property
    def manifest(self) -> Dict[str, _toml.Value]:
        """The complete manifest of this run, with defaults, as it is in the recording."""
        try:
            manifest: Dict[str, _toml.Value] = _toml.parsed(self._container.manifest)
            return manifest
        except (ValueError, RecursionError) as error:
            raise damaged(self.path, "its manifest is not TOML") from error

    @property
    def model(self) -> str:
        """The model: dem, gas, packing or orbit."""
        return self._provenance["model"]

    @property
    def seed(self) -> int:
        """The seed of the run's random streams."""
        seed = self.manifest.get("seed")
        if not isinstance(seed, int):
            raise damaged(self.path, "its manifest has no seed")
        return seed

    @property
    def replicate(self) -> int:
        """The number of the replicate, from 0; 0 without replicates.

        >>> recording.replicate, recording.coordinates
        (0, {})
        """
        replicate = self.manifest.get("replicate")
        return replicate if isinstance(replicate, int) else 0

    @property
    def coordinates(self) -> Dict[str, _folder.Coordinate]:
        """The values of the swept keys, by the names that metrics use, such as ``temperature_k``; empty without a sweep."""
        if self._experiment is not None and self._experiment.path.is_dir():
            return self._experiment._coordinates_of(self)
        folder = self.path.parent
        return _folder.coordinates_of(self.path.name, folder, _folder.description(folder))

    def metric(self, name: str) -> float:
        """The value of one metric of this run.

        >>> recording.metric("energy.kinetic") == experiment.metric("energy.kinetic")
        True
        """
        if self._experiment is None:
            # Imported here: experiments have runs.
            from ._experiment import open

            self._experiment = open(self.path, programs=self._programs)
        return self._experiment._metric_of(self, name)

    @property
    def times(self) -> npt.NDArray[np.float64]:
        """The simulated time of every frame of the run, also of those whose state is not recorded.

        >>> len(recording.times), float(recording.times[0])
        (251, 0.0)
        """
        return self["/frame"].times

    @property
    def run_key(self) -> str:
        """SHA-256 of all inputs that affect the result."""
        return self._provenance["run_key"]

    @property
    def time_unit(self) -> str:
        """Unit of the simulated time: s, d, or empty for a dimensionless model."""
        return self._provenance["time_unit"]

    @property
    def outcome(self) -> str:
        """``complete``, ``fault``, ``interrupted``, or ``unfinished`` for a torn file."""
        return self._outcome

    @property
    def log(self) -> Tuple[_log.LogEntry, ...]:
        """The messages of the run, such as its warnings and the reason of its end.

        >>> recording.log[0].level, recording.log[0].message.splitlines()[0]
        ('info', '1 s of playback = 40 ms simulated')
        """
        return _log.read(self._container)

    @overload
    def series(self, topic: str, library: Literal["polars"]) -> "polars.DataFrame": ...

    @overload
    def series(self, topic: str, library: Literal["pandas"]) -> "pandas.DataFrame": ...

    @overload
    def series(self, topic: str, library: None = ...) -> _tables.Table: ...

    def series(self, topic: str, library: Optional[_tables.TableLibrary] = None) -> _tables.Table:
        """A topic over time as a Polars data frame, or as pandas if only that is installed or requested.

        One row per frame, or one per entry for topics with columns of numbers such as ``/speeds``.

        >>> energy = recording.series("/energy")
        >>> list(energy.columns)[:3], len(energy)
        (['frame', 'time', 'kinetic_j'], 251)
        """
        _tables.library_module(library)
        frames = self[topic]
        rows, lengths, times = frames._rows()
        columns: Dict[str, Any] = {
            "frame": np.repeat(np.asarray(frames.indices, dtype=np.int64), lengths),
            "time": np.repeat(times, lengths),
        }
        for name in frames.columns:
            # The clock of `/frame` has these two itself.
            if name not in columns:
                column = np.ascontiguousarray(rows[name])
                columns[name] = column.tolist() if column.dtype.kind == "U" else column
        return _tables.frame_of_columns(columns, library)

    def verify(self) -> Verification:
        """Reruns the run and compares; the result is true if both are equal, and its text names the first difference."""
        with self._file() as path:
            finished = _programs.call(["verify", "--json", os.fspath(path)], self._programs)
        if finished.code not in (_programs.EXIT_OK, _programs.EXIT_DIFFERENCE):
            raise finished.error()
        result = finished.json()
        findings: List[str] = [str(line) for line in result.get("findings", [])]
        return Verification(finished.code == _programs.EXIT_OK and bool(result["equal"]), tuple(findings))

    def show(self, *, height: int = 700, replay_budget_mb: float = 3.0) -> None:
        """Displays the player of this run in the cell of a notebook."""
        _player.display(self._player(replay_budget_mb), height)

    @contextlib.contextmanager
    def _file(self) -> Iterator[Path]:
        """The recording as a file for the program."""
        yield self.path

    def _player(self, replay_budget_mb: float) -> str:
        with tempfile.TemporaryDirectory(prefix="kinetoscope-") as folder, self._file() as path:
            arguments = ["analyze", "--quiet", "--output", folder, "--replay-budget", str(replay_budget_mb)]
            finished = _programs.call([*arguments, os.fspath(path)], self._programs)
            report = Path(folder) / "report.html"
            # A failed check does not concern the player.
            if not report.exists():
                raise finished.error()
            return _player.player(report)
