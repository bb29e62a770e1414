"""Experiments: their runs and metrics."""

from __future__ import annotations

import contextlib
import difflib
import os
import tempfile
import warnings
from pathlib import Path
from typing import Any, Dict, Iterator, List, Mapping, Optional, Tuple

from . import _player, _programs, _tables, _toml
from ._errors import KinetoscopeError, RecordingError, UnknownNameError, damaged
from ._run import Run

# Layout of `metrics.json` that this package reads.
METRICS_SCHEMA = 3
# Values of a coordinate that an error lists.
SHOWN_VALUES = 8
# Columns of the table of metrics after the coordinates.
COLUMNS = (
    "replicate",
    "metric",
    "value",
    "unit",
    "standard_error",
    "theory",
    "deviation_sigma",
    "scope",
    "applicable",
    "reason",
    "file",
    "source",
)


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
        self._description = _description(path)
        self._runs: Optional[Tuple[Run, ...]] = None
        self._analysis: Optional[Dict[str, Any]] = None

    def __repr__(self) -> str:
        runs = "1 run" if len(self._files) == 1 else f"{len(self._files)} runs"
        return f"<experiment {self.name}: {runs} in {self.path}>"

    @property
    def name(self) -> str:
        """The name, which is also that of the folder."""
        return self.path.name if self.path.is_dir() else self.path.parent.name

    @property
    def runs(self) -> Tuple[Run, ...]:
        """The finished runs, in the order of the sweep."""
        if self._runs is None:
            self._runs = tuple(Run(path, programs=self._programs) for path in self._files)
        return self._runs

    @property
    def metrics(self) -> Any:
        """All metrics as a Polars data frame, or as pandas if only that is installed.

        One row per metric and run, and one per mean over replicates or fit over a sweep; the first columns are the
        coordinates of the sweep. Recordings that have not changed since the last analysis are not read again.
        """
        return self.metric_table()

    def metric_table(self, library: Optional[_tables.TableLibrary] = None) -> Any:
        """The same table by the library of choice, ``"polars"`` or ``"pandas"``."""
        _tables.library_module(library)
        rows = self._rows()
        coordinates = dict.fromkeys(key for row in rows for key in row["coordinates"])
        flat = [{**row, **row["coordinates"]} for row in rows]
        return _tables.frame_of_rows(flat, [*coordinates, *COLUMNS], library)

    def metric(self, name: str, **where: object) -> float:
        """The value of one metric at the given coordinates, such as ``temperature_k=300``.

        For replicates, this is the mean. ``replicate=2`` selects one of them.
        """
        rows = self._rows()
        named = [row for row in rows if row["metric"] == name]
        if not named:
            raise UnknownNameError.of("metric", name, (row["metric"] for row in rows))
        known = {"replicate"}.union(*(row["coordinates"] for row in rows))
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
        if chosen[0]["value"] is None:
            raise KinetoscopeError(f"`{name}` has no value: {chosen[0]['reason']}")
        return float(chosen[0]["value"])

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
    def checks(self) -> List[Dict[str, Any]]:
        """The results of the outcome of each run and of the manifest's checks: ``subject``, ``passed``, ``finding``."""
        checks: List[Dict[str, Any]] = self._analyzed()["checks"]
        return checks

    def show(self, *, height: int = 900) -> None:
        """Displays the whole report in the cell of a notebook."""
        with tempfile.TemporaryDirectory(prefix="kinetoscope-") as folder, self._input() as path:
            finished = _programs.call(["analyze", "--quiet", "--output", folder, os.fspath(path)], self._programs)
            report = Path(folder) / "report.html"
            if not report.exists():
                raise finished.error()
            _player.display(report.read_text(encoding="utf-8"), height)

    @contextlib.contextmanager
    def _input(self) -> Iterator[Path]:
        """The folder or file to analyze: if the folder describes other recordings by now, one that has only those of this experiment."""
        if _description(self.path) == self._description:
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

    def _rows(self) -> List[Dict[str, Any]]:
        analysis = self._analyzed()["analysis"]
        return [_row(metric, analysis["definitions"][metric["name"]]) for metric in analysis["metrics"]]

    def _analyzed(self) -> Dict[str, Any]:
        if self._analysis is None:
            self._analysis = self._analyze([])
        return self._analysis

    def _analyze(self, options: List[str]) -> Dict[str, Any]:
        """Analyzes the recordings. The results are written next to them if that is possible and they are all of the folder's."""
        with tempfile.TemporaryDirectory(prefix="kinetoscope-") as scratch, self._input() as path:
            if options or path != self.path or not (path.is_dir() and os.access(path, os.W_OK)):
                options = [*options, "--no-replay", "--output", scratch]
            finished = _programs.call(["analyze", "--json", "--quiet", *options, os.fspath(path)], self._programs)
        if not finished.output.strip():
            raise finished.error()
        result = finished.json()
        experiments = result.get("experiments") or []
        if len(experiments) != 1:
            raise finished.error()
        analysis: Dict[str, Any] = experiments[0]
        for what in analysis.get("unreadable", []):
            warnings.warn(f"not analyzed: {what}", stacklevel=4)
        schema = analysis["analysis"]["schema"]
        if schema != METRICS_SCHEMA:
            raise KinetoscopeError(
                f"the program writes metrics of schema version {schema}; this package reads version {METRICS_SCHEMA}",
                "install the same version of both: `pip install --upgrade kinetoscope`",
            )
        return analysis


def _row(metric: Mapping[str, Any], definition: Mapping[str, Any]) -> Dict[str, Any]:
    """A metric as a row, with the values of its coordinates and the texts of its definition."""
    place = metric.get("run") or metric.get("sweep") or {}
    theory = metric.get("theory")
    row = dict(metric, metric=metric["name"], theory=theory["value"] if theory else None)
    row["source"] = definition["source"]
    if theory and theory["law"] is not None:
        row["source"] += f"; theory: {definition['laws'][theory['law']]['source']}"
    row["coordinates"] = {
        key: entry["value"] if isinstance(entry, dict) else entry
        for key, entry in place.get("coordinates", {}).items()
    }
    row["scope"] = "run" if "run" in metric else "sweep"
    row["replicate"] = place.get("replicate")
    row["file"] = place.get("file")
    return row


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


def run(
    manifest: _programs.PathLike,
    *,
    seed: Optional[int] = None,
    set: Optional[Mapping[str, object]] = None,
    output: _programs.PathLike = "recordings",
    jobs: Optional[int] = None,
    force: bool = False,
    programs: Optional[_programs.PathLike] = None,
) -> Experiment:
    """Runs the experiment of a manifest and returns its recordings.

    Finished runs are not rerun unless a value, the seed or the physics has changed, or with ``force``. ``set`` overrides
    keys of the manifest; ``output`` is the folder of all experiments, ``jobs`` the number of runs to execute in
    parallel, and ``programs`` the folder of the program ``kinetoscope`` if it is not installed with this package.

    >>> short = kinetoscope.run(
    ...     experiments / "first_run.toml", seed=7, set={"model.dem.discs": 5}, output=folder, programs=programs
    ... )
    >>> short.runs[0].seed, len(short.runs[0]["/state"][0])
    (7, 5)
    """
    overrides = dict(set or {})
    if seed is not None:
        overrides["seed"] = seed
    arguments = ["run", "--json", "--quiet", "--output", os.fspath(_programs.absolute(output))]
    for key, value in overrides.items():
        arguments += ["--set", f"{key}={_toml.literal(value)}"]
    if jobs is not None:
        arguments += ["--jobs", str(jobs)]
    if force:
        arguments.append("--force")
    path = os.fspath(_programs.absolute(manifest))
    if os.path.isdir(path):
        raise KinetoscopeError(f"{path} is a folder", "name one manifest, such as `kinetoscope.run(\"exp.toml\")`")
    finished = _programs.call([*arguments, path], programs)
    if finished.code != _programs.EXIT_OK:
        raise finished.error()
    experiments = finished.json()["experiments"]
    # Manifests that `start_from` names are run first.
    result = next((entry for entry in experiments if entry.get("manifest") == path), experiments[-1])
    files = [Path(entry["recording"]) for entry in result["runs"] if entry.get("recording")]
    experiment = Experiment(Path(result["destination"]), files, programs=programs)
    listed = {path.name for path in _listed(experiment.path)}
    if not listed.issuperset(file.name for file in files):
        raise KinetoscopeError(
            f"another run of {experiment.name} has described its own recordings in {experiment.path} meanwhile",
            "give each of several simultaneous runs an `output` of its own",
        )
    return experiment


def open(path: _programs.PathLike, *, programs: Optional[_programs.PathLike] = None) -> Experiment:
    """Opens the recordings in a folder such as ``recordings/first_run``, or one recording.

    >>> kinetoscope.open(experiment.path).runs[0].outcome
    'complete'
    """
    place = _programs.absolute(path)
    if not place.is_dir():
        # Reports a file that is missing or is not a recording.
        Run(place)
        return Experiment(place, [place], programs=programs)
    files = list(_listed(place))
    if files:
        return Experiment(place, files, programs=programs)
    inner = sorted(entry.parent for entry in place.glob("*/experiment.toml"))
    if inner:
        raise RecordingError(
            f"{place} contains {len(inner)} experiments", f"open one of them, such as `{inner[0]}`"
        )
    raise RecordingError(f"{place} contains no finished recording", "run the experiment first: `kinetoscope.run(…)`")


def _description(path: Path) -> Optional[str]:
    """The text of the folder's `experiment.toml`, which lists its recordings; none for a file, or without it."""
    try:
        return (path / "experiment.toml").read_text(encoding="utf-8")
    except (OSError, ValueError):
        return None


def _listed(folder: Path) -> Iterator[Path]:
    """The finished recordings of a folder: those that its `experiment.toml` lists, else all."""
    description = folder / "experiment.toml"
    if not description.is_file():
        yield from sorted(path for path in folder.glob("*.mcap") if not path.name.endswith(".partial.mcap"))
        return
    try:
        entries = _toml.parsed(description.read_text(encoding="utf-8")).get("runs", [])
        names = [str(entry["file"]) for entry in entries]
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise damaged(description, str(error)) from error
    for name in names:
        # Only files of this folder.
        path = folder / os.path.basename(name)
        if path.is_file():
            yield path
