"""Runs in memory, without files."""

from __future__ import annotations

import contextlib
import os
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any, Dict, Iterator, Literal, Mapping, Optional, overload

from . import _folder, _simulators, _manifest, _programs, _results, _tables
from ._container import load
from ._errors import UnknownNameError
from ._run import Run

if TYPE_CHECKING:
    import pandas
    import polars

# The name of a recording in memory in errors.
IN_MEMORY = Path("the recording in memory")


class Simulation(Run):
    """A run in memory: its frames as those of a recording, and its metrics as those of its analysis."""

    def __init__(self, content: bytes, analysis: Mapping[str, object], programs: Optional[_programs.PathLike]) -> None:
        self._open(load(IN_MEMORY, False, content), IN_MEMORY, programs)
        self._content = content
        self._analysis: Any = analysis

    def __repr__(self) -> str:
        return f"<simulation: {self.model}, {len(self)} frames, {self.outcome}>"

    @property
    def coordinates(self) -> Dict[str, _folder.Coordinate]:
        """Empty: a simulation is no part of a sweep."""
        return {}

    @property
    def metrics(self) -> _tables.Table:
        """All metrics as a Polars data frame, or as pandas if only that is installed: `table()`."""
        return self.table()

    @overload
    def table(self, library: Literal["polars"]) -> "polars.DataFrame": ...

    @overload
    def table(self, library: Literal["pandas"]) -> "pandas.DataFrame": ...

    @overload
    def table(self, library: None = ...) -> _tables.Table: ...

    def table(self, library: Optional[_tables.TableLibrary] = None) -> _tables.Table:
        """All metrics as a table, one row each, as `Experiment.table` has them."""
        definitions = self._analysis["definitions"]
        rows = [_results.row_of(metric, definitions[metric["name"]]) for metric in self._analysis["metrics"]]
        return _tables.frame_of_rows(rows, _results.COLUMNS, library)

    def metric(self, name: str) -> float:
        """The value of one metric, which is that of `kinetoscope analyze`."""
        metrics = self._analysis["metrics"]
        found = next((metric for metric in metrics if metric["name"] == name), None)
        if found is None:
            raise UnknownNameError.of("metric", name, (metric["name"] for metric in metrics))
        return _results.value_of({**found, "metric": name})

    @contextlib.contextmanager
    def _file(self) -> Iterator[Path]:
        with tempfile.TemporaryDirectory(prefix="kinetoscope-") as scratch:
            path = Path(scratch) / "simulation.mcap"
            path.write_bytes(self._content)
            yield path


def simulate(
    manifest: _manifest.Manifest,
    *,
    seed: Optional[int] = None,
    set: Optional[Mapping[str, object]] = None,
    programs: Optional[_programs.PathLike] = None,
) -> Simulation:
    """Runs one manifest in memory, without files, for interactive use and for loops of an optimization.

    The manifest is the path of a file, TOML as text, or a dict, of one run; ``seed`` and ``set`` override its keys. The
    frames are those of a recording of `kinetoscope.run`, and the metrics those of its analysis. The first call starts a
    program that later ones use again; it ends with Python.

    >>> orbit = kinetoscope.simulate({"model": {"orbit": {"duration_days": 100}}}, programs=programs)
    >>> orbit["/state"].array()["x"].shape[0] == len(orbit)
    True
    >>> orbit.metric("energy.drift_relative") == float(orbit.table("pandas").set_index("metric")["value"]["energy.drift_relative"])
    True
    """
    values = dict(set or {})
    if seed is not None:
        values["seed"] = seed
    with _manifest.source(manifest, None) as source:
        words = [os.fspath(source.path), os.path.abspath("recordings"), *_manifest.overrides(values)[1::2]]
        answer, content = _simulators.answer(words, programs)
        if "error" in answer:
            error = source.located(str(answer["error"]))
            raise _programs.Finished(["simulate"], int(answer["exit_code"]), "", error).error()
    _results.check_schema(answer["metrics"])
    return Simulation(content, answer["metrics"], programs)
