"""Experiments: their runs and metrics."""

from __future__ import annotations

import contextlib
import difflib
import functools
import os
import tempfile
import warnings
from pathlib import Path
from typing import (
    TYPE_CHECKING,
    Any,
    Dict,
    Iterator,
    List,
    Literal,
    Mapping,
    Optional,
    Sequence,
    Tuple,
    TypedDict,
    Union,
    overload,
)

from . import _folder, _player, _plot, _programs, _results, _runs_table, _tables, _wide
from ._errors import KinetoscopeError, ProgramNotFoundError, RecordingError, UnknownNameError
from ._plot import Plot
from ._run import Run

if TYPE_CHECKING:
    import pandas
    import polars

# Values of a coordinate that an error lists.
SHOWN_VALUES = 8


class CheckResult(TypedDict):
    """The result of a check, or of the outcome that the manifest expects of a run."""

    subject: str
    passed: bool
    finding: str


class Experiment:
    """The recordings of an experiment, with metrics and checks.

    >>> experiment.name, len(experiment.runs)
    ('first_run', 1)
    >>> round(experiment.metric("energy.residual_relative"), 6)
    -0.005084
    >>> experiment.metric("energy.kinetik")
    Traceback (most recent call last):
    ...
    kinetoscope._errors.UnknownNameError: unknown metric `energy.kinetik`
    help: did you mean `energy.kinetic` or `energy.elastic`?
    """

    def __init__(
        self, path: Path, files: List[Path], *, programs: Optional[_programs.PathLike] = None
    ) -> None:
        self.path = path
        self._files = files
        self._programs = programs
        # A later run of another seed or with other values describes its own recordings in the same folder.
        self._description = _folder.description(path)
        self._runs: Optional[Tuple[Run, ...]] = None
        # The results, and the run keys that they are of.
        self._analysis: Optional[Dict[str, Any]] = None
        self._analyzed_keys: Dict[str, str] = {}

    def __repr__(self) -> str:
        if self._keeps_metrics_only():
            return f"<experiment {self.name}: metrics of its runs in {self.path / _runs_table.TABLE}>"
        runs = "1 run" if len(self._files) == 1 else f"{len(self._files)} runs"
        return f"<experiment {self.name}: {runs} in {self.path}>"

    def _keeps_metrics_only(self) -> bool:
        """Whether the runs have no recordings, as with `keep = "metrics"`."""
        return not self._files

    @property
    def name(self) -> str:
        """The name, which is also that of the folder."""
        return self.path.name if self.path.is_dir() else self.path.parent.name

    @property
    def runs(self) -> Tuple[Run, ...]:
        """The finished runs, in the order of the sweep; none if only the metrics of the runs were kept.

        A recording of keyframes is replaced by that of all frames once `kinetoscope fill` has restored it.
        """
        if self._runs is None:
            self._runs = tuple(Run(path, programs=self._programs, experiment=self) for path in self._files)
        self._runs = tuple(run._with_all_frames() for run in self._runs)
        return self._runs

    @property
    def metrics(self) -> _tables.Table:
        """All metrics as a Polars data frame, or as pandas if only that is installed: `table()`."""
        return self.table()

    @overload
    def table(self, library: Literal["polars"], *, wide: bool = ..., by: _wide.By = ...) -> "polars.DataFrame": ...

    @overload
    def table(self, library: Literal["pandas"], *, wide: bool = ..., by: _wide.By = ...) -> "pandas.DataFrame": ...

    @overload
    def table(self, library: None = ..., *, wide: bool = ..., by: _wide.By = ...) -> _tables.Table: ...

    def table(
        self, library: Optional[_tables.TableLibrary] = None, *, wide: bool = False, by: _wide.By = "run"
    ) -> _tables.Table:
        """All metrics as a table of the library of choice, ``"polars"`` or ``"pandas"``.

        One row per metric and run, and one per mean over replicates or fit over a sweep; the first columns are the
        coordinates of the sweep. With ``wide=True``, each metric is a column, and there is one row per run, or, with
        ``by="point"``, one per point of the sweep with the means over its replicates and their standard errors.

        Of more than 1,000 runs, only the wide table has a row per run: it is read from ``runs.parquet``.

        >>> experiment.table("polars", wide=True).columns[:3]
        ['replicate', 'file', 'energy.kinetic']
        """
        _tables.library_module(library)
        if wide and (self._keeps_metrics_only() or _results.has_means_only(self._analyzed()["analysis"])):
            columns = _runs_table.read(self.path, None, self._programs)
            if by == "run":
                return _tables.frame_of_columns(columns, library)
            if len(set(columns[_runs_table.FIRST])) == 1:
                return _tables.frame_of_columns(_wide.points_of_single_runs(columns), library)
        rows = self._rows()
        names = list(dict.fromkeys(key for row in rows for key in row["coordinates"]))
        if wide:
            flat = _wide.rows(rows, names, by)
            return _tables.frame_of_rows(flat, list(dict.fromkeys(key for row in flat for key in row)), library)
        flat = [{**row, **row["coordinates"]} for row in rows]
        return _tables.frame_of_rows(flat, [*names, *_results.COLUMNS], library)

    def metric(self, name: str, **where: object) -> float:
        """The value of one metric at the given coordinates, such as ``temperature_k=300``.

        For replicates, this is the mean. ``replicate=2`` selects one of them.
        """
        named = self._rows_of(name)
        known = {"replicate"}.union(*(row["coordinates"] for row in named))
        for key in where:
            if key not in known:
                raise UnknownNameError.of("coordinate", key, known)
        matching = _matching(named, where)
        if not matching:
            raise _no_value(name, named, where)
        means = [row for row in matching if row["scope"] == "sweep"]
        chosen = means or matching
        if len(chosen) != 1:
            places = ", ".join(f"{key} = {value}" for key, value in chosen[0]["coordinates"].items())
            raise KinetoscopeError(
                f"`{name}` has {len(chosen)} values at the given coordinates",
                f"the first is at {places}: give these, or use `experiment.metrics`"
                if places
                else "`experiment.metrics` lists all values",
            )
        return _results.value_of(chosen[0])

    @property
    def question(self) -> str:
        """The question that the experiment asks; empty if its manifest states none."""
        return str(self._analyzed()["analysis"].get("question") or "")

    @property
    def answer(self) -> str:
        """The answer in one or two sentences, as the report shows it; empty without one.

        >>> print(experiment.answer)
        Into the dashpots of their contacts: they lose 97.3 % of it. The energy balance closes to 0.508 %.
        """
        answer = self._analyzed()["analysis"].get("answer")
        return str(answer["text"]) if answer else ""

    @property
    def checks(self) -> List[CheckResult]:
        """The results of the outcome of each run and of the manifest's checks: ``subject``, ``passed``, ``finding``."""
        if "checks" not in self._analyzed():
            # `metrics.json` of small experiments has none.
            self._analysis = self._analyze_for(f"{self.path / _results.METRICS} has no results of checks")
        checks: List[CheckResult] = self._analyzed()["checks"]
        return checks

    def show(self, *, height: int = 900) -> None:
        """Displays the whole report in the cell of a notebook."""
        with tempfile.TemporaryDirectory(prefix="kinetoscope-") as folder, self._input() as path:
            finished = _programs.call(["analyze", "--quiet", "--output", folder, os.fspath(path)], self._programs)
            report = Path(folder) / "report.html"
            if not report.exists():
                raise finished.error()
            _player.display(report.read_text(encoding="utf-8"), height)

    def plot(
        self,
        y: Union[str, Sequence[str]] = (),
        x: str = "",
        *,
        figure: str = "",
        where: Optional[Mapping[str, object]] = None,
        title: str = "",
        log: str = "",
    ) -> Plot:
        """The plot that `kinetoscope plot` draws: metrics over a swept key, or fields of channels over time.

        ``y`` is a metric such as ``pressure.measured`` or a field such as ``/energy.kinetic_j``, or several; ``x`` is a
        swept key, another metric, or ``time``. ``figure`` is a chart of the model in place of ``y``, such as
        ``energy_balance``. ``where`` selects points of the sweep, and ``log="xy"`` draws logarithmic axes.
        """
        names = [y] if isinstance(y, str) else list(y)
        if not names and not figure:
            raise KinetoscopeError("a plot needs `y` or `figure`", "name a metric, or a field such as `/energy.kinetic_j`")
        with self._input() as path:
            return _plot.draw(_plot.options(names, x, where or {}, figure, title, log), path, self._programs)

    @contextlib.contextmanager
    def _input(self) -> Iterator[Path]:
        """The folder or file to analyze: if the folder describes other recordings by now, one that has only those of this experiment."""
        if _folder.description(self.path) == self._description:
            yield self.path
            return
        with tempfile.TemporaryDirectory(prefix=".kinetoscope-", dir=self.path.parent) as scratch:
            folder = Path(scratch) / self.name
            folder.mkdir()
            (folder / "experiment.toml").write_text(self._description or "", encoding="utf-8")
            for file in self._files:
                try:
                    os.link(file, folder / file.name)
                except OSError as error:
                    raise KinetoscopeError(
                        f"{self.path} describes other recordings by now, and {file} cannot be linked: {error.strerror}",
                        "run the experiment again, with another `output` for each seed or set of values",
                    ) from error
            yield folder

    def _coordinates_of(self, run: Run) -> Dict[str, _folder.Coordinate]:
        return _folder.coordinates_of(run.path.name, self.path, self._description)

    def _metric_of(self, run: Run, name: str) -> float:
        place = _folder.place(run.path.name)
        named = [row for row in self._rows_of(name) if row["scope"] == "run"]
        row = next((row for row in named if _folder.place(row["file"]) == place), None)
        if row is None:
            raise UnknownNameError.of("metric", name, (row["metric"] for row in self._rows() if row["scope"] == "run"))
        return _results.value_of(row)

    def _rows_of(self, name: str) -> List[Dict[str, Any]]:
        """The values of a metric: means and fits, and those of all runs."""
        rows = self._rows()
        named = [row for row in rows if row["metric"] == name]
        analysis = self._analyzed()["analysis"]
        if _results.has_means_only(analysis) and name in analysis["definitions"]:
            keys = list(dict.fromkeys(key for row in named for key in row["coordinates"]))
            columns = _runs_table.read(self.path, [*keys, "replicate", "file", name], self._programs)
            if name in columns:
                named += _rows_of_runs(name, keys, columns)
        if not named:
            raise UnknownNameError.of("metric", name, (row["metric"] for row in rows))
        return named

    def _rows(self) -> List[Dict[str, Any]]:
        analysis = self._analyzed()["analysis"]
        return [_results.row_of(metric, analysis["definitions"][metric["name"]]) for metric in analysis["metrics"]]

    def _analyzed(self) -> Dict[str, Any]:
        """The results: those next to the recordings if they belong to them, else those of an analysis."""
        if self._analysis is None or self._has_restored():
            try:
                self._analysis = self._stored()
            except _results.NoResultsError as missing:
                self._analysis = self._analyze_for(missing.message)
            self._analyzed_keys = self._run_keys()
        return self._analysis

    def _has_restored(self) -> bool:
        """Whether all frames of a recording of keyframes were restored since the analysis."""
        return self._has_keyframes and self._run_keys() != self._analyzed_keys

    def _stored(self) -> Dict[str, Any]:
        if not self.path.is_dir():
            keys = {run.path.name: run.run_key for run in self.runs}
            return {"analysis": _results.read_of_some(self.path.parent, keys)}
        if _folder.description(self.path) != self._description:
            raise _results.NoResultsError(f"{self.path} describes other recordings by now")
        stored = _results.read(self.path, self._run_keys(), self._programs)
        if _results.is_older(self.path, self.path / _folder.DESCRIPTION) and _programs.is_installed(self._programs):
            raise _results.NoResultsError(f"{self.path / _results.METRICS} is older than the description of its folder")
        result = {"analysis": stored}
        if "checks" in stored:
            result["checks"] = stored["checks"]
        return result

    def _run_keys(self) -> Dict[str, str]:
        """The files of the runs with their run keys."""
        if self._description is None or self._has_keyframes:
            return {run.path.name: run.run_key for run in self.runs}
        entries = _folder.entries(self.path, self._description)
        names = {file.name for file in self._files}
        return {entry.file: entry.run_key for entry in entries if entry.file in names or self._keeps_metrics_only()}

    @functools.cached_property
    def _has_keyframes(self) -> bool:
        """Whether the recordings have a part of the states, which is the same for all of an experiment."""
        return bool(self._files) and Run(self._files[0])._has_keyframes()

    def _analyze_for(self, reason: str) -> Dict[str, Any]:
        """Analyzes the recordings because of a missing file, which is named if there is no program."""
        try:
            return self._analyze([])
        except ProgramNotFoundError as error:
            raise ProgramNotFoundError(
                f"{reason}, and {error.message}", f"`kinetoscope analyze {self.path}` writes this file; {error.help}"
            ) from error

    def _analyze(self, options: List[str]) -> Dict[str, Any]:
        """Analyzes the recordings without a report. The metrics are kept next to them if they are all of the folder's."""
        with tempfile.TemporaryDirectory(prefix="kinetoscope-") as scratch, self._input() as path:
            _results.lend_cache(self.path, Path(scratch))
            arguments = ["analyze", "--json", "--quiet", "--no-replay", "--no-engine", "--output", scratch, *options]
            finished = _programs.call([*arguments, os.fspath(path)], self._programs)
            if not options and path == self.path and path.is_dir() and finished.output.strip():
                _results.keep(Path(scratch), path)
        if not finished.output.strip():
            raise finished.error()
        result = finished.json()
        experiments = result.get("experiments") or []
        if len(experiments) != 1:
            raise finished.error()
        analysis: Dict[str, Any] = experiments[0]
        for what in analysis.get("unreadable", []):
            warnings.warn(f"not analyzed: {what}", stacklevel=4)
        _results.check_schema(analysis["analysis"])
        return analysis


def _rows_of_runs(name: str, keys: Sequence[str], columns: _runs_table.Columns) -> List[Dict[str, Any]]:
    """The values of a metric from the table of the runs; one that is missing has no reason there."""
    lines = zip(columns[name], columns["replicate"], columns["file"], *(columns[key] for key in keys))
    reason = "`kinetoscope analyze` of its recording states the reason"
    return [
        {"metric": name, "value": value, "replicate": replicate, "file": file, "scope": "run", "reason": reason}
        | {"coordinates": dict(zip(keys, place))}
        for value, replicate, file, *place in lines
    ]


def _value_at(row: Mapping[str, Any], key: str) -> object:
    return row["replicate"] if key == "replicate" else row["coordinates"].get(key)


def _matching(rows: List[Dict[str, Any]], where: Mapping[str, object]) -> List[Dict[str, Any]]:
    return [row for row in rows if all(_value_at(row, key) == value for key, value in where.items())]


def _no_value(name: str, named: List[Dict[str, Any]], where: Mapping[str, object]) -> KinetoscopeError:
    """The error for coordinates without a value, with the nearest values that one of them may have."""
    wanted = ", ".join(f"{key} = {value!r}" for key, value in where.items())
    message = f"`{name}` has no value at {wanted}"
    for others in (where, {}):
        for key, value in where.items():
            rows = _matching(named, {other: others[other] for other in others if other != key})
            # A list, because the wanted value need not be hashable.
            known = list({_value_at(row, key) for row in rows} - {None})
            if known and value not in known:
                nearest = sorted(known, key=lambda entry: _distance(entry, value))
                more = f", and {len(nearest) - SHOWN_VALUES} more" if len(nearest) > SHOWN_VALUES else ""
                values = ", ".join(repr(entry) for entry in nearest[:SHOWN_VALUES])
                return KinetoscopeError(message, f"the values of `{key}`, nearest first: {values}{more}")
    return KinetoscopeError(message, "`experiment.metrics` lists all values")


def _distance(one: object, other: object) -> Tuple[float, str]:
    """Numbers by their difference, texts by their likeness; the text decides between equal ones."""
    if isinstance(one, (int, float)) and isinstance(other, (int, float)):
        return abs(one - other), str(one)
    return 1.0 - difflib.SequenceMatcher(None, str(one), str(other)).ratio(), str(one)


def open(path: _programs.PathLike, *, programs: Optional[_programs.PathLike] = None) -> Experiment:
    """Opens the recordings in a folder such as ``recordings/first_run``, one recording, or several runs in one, which
    ``kinetoscope compare --mcap`` writes.

    >>> kinetoscope.open(experiment.path).runs[0].outcome
    'complete'
    """
    place = _programs.absolute(path)
    if not place.is_dir():
        # Imported here: a merged recording is an experiment.
        from ._merged import open_merged

        merged = open_merged(place, programs)
        if merged is not None:
            return merged
        # Reports a file that is missing or is not a recording.
        Run(place)
        return Experiment(place, [place], programs=programs)
    files = _folder.listed(place)
    if files or (place / _runs_table.TABLE).is_file():
        return Experiment(place, files, programs=programs)
    inner = sorted(entry.parent for entry in place.glob("*/experiment.toml"))
    if inner:
        raise RecordingError(
            f"{place} contains {len(inner)} experiment{'s' * (len(inner) > 1)}", f"open one of them, such as `{inner[0]}`"
        )
    raise RecordingError(f"{place} contains no finished recording", "run the experiment first: `kinetoscope.run(…)`")
