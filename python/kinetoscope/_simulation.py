"""Runs in memory, without files: a program that is kept executes one manifest after the other."""

from __future__ import annotations

import atexit
import contextlib
import json
import os
import subprocess
import tempfile
import weakref
from pathlib import Path
from typing import TYPE_CHECKING, Any, Dict, Iterator, List, Literal, Mapping, Optional, Sequence, Tuple, overload

from . import _folder, _manifest, _programs, _results, _tables
from ._container import load
from ._errors import KinetoscopeError, ProgramNotFoundError, UnknownNameError
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
        answer, content = _answer(words, programs)
        if "error" in answer:
            error = source.located(str(answer["error"]))
            raise _programs.Finished(["simulate"], int(answer["exit_code"]), "", error).error()
    _results.check_schema(answer["metrics"])
    return Simulation(content, answer["metrics"], programs)


class _Helper:
    """A program that waits for requests. It ends with its input, so also if this process is killed."""

    def __init__(self, program: str) -> None:
        self._messages = tempfile.TemporaryFile()
        try:
            # Ctrl-C in a terminal is for Python, which ends the program.
            self._process = subprocess.Popen(
                [program, "simulate"],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=self._messages,
                start_new_session=True,
            )
        except OSError as error:
            raise ProgramNotFoundError(
                f"{program} cannot be executed: {error.strerror}",
                "install a wheel or build the program for this operating system and processor",
            ) from error
        _helpers.add(self)

    def ask(self, words: Sequence[str]) -> Optional[Tuple[Dict[str, Any], bytes]]:
        """The answer to a request, and the recording; none if the program has ended."""
        assert self._process.stdin is not None and self._process.stdout is not None
        try:
            self._process.stdin.write(json.dumps(words).encode() + b"\n")
            self._process.stdin.flush()
            line = self._process.stdout.readline()
        except BrokenPipeError:
            return None
        if not line.endswith(b"\n"):
            return None
        answer: Dict[str, Any] = json.loads(line)
        size = int(answer.get("recording_bytes", 0))
        content = self._process.stdout.read(size)
        return (answer, content) if len(content) == size else None

    def error(self) -> KinetoscopeError:
        """Why the program has ended."""
        self._process.kill()
        self._process.wait()
        self._messages.seek(0)
        text = self._messages.read().decode("utf-8", "replace")
        self.close()
        return _programs.Finished(["simulate"], self._process.returncode, "", text).error()

    def end(self) -> None:
        """Ends the program, which has nothing to save."""
        self._process.kill()
        self._process.wait()
        self.close()

    def close(self) -> None:
        """Closes the pipes and the file of messages."""
        for pipe in (self._process.stdin, self._process.stdout, self._messages):
            if pipe is not None:
                with contextlib.suppress(OSError):
                    pipe.close()

    def forget(self) -> None:
        """Leaves the program to the process that this one was forked from."""
        self.close()
        self._process.returncode = 0


_helpers: "weakref.WeakSet[_Helper]" = weakref.WeakSet()
# Programs that wait, by their file and its time of change.
_idle: Dict[Tuple[str, int], List[_Helper]] = {}


def _answer(words: Sequence[str], programs: Optional[_programs.PathLike]) -> Tuple[Dict[str, Any], bytes]:
    """The answer of a program that waits, or of a new one. Each thread has its own."""
    program = _programs.find(programs)
    idle = _idle.setdefault((program, os.stat(program).st_mtime_ns), [])
    while True:
        try:
            helper, is_new = idle.pop(), False
        except IndexError:
            helper, is_new = _Helper(program), True
        try:
            answer = helper.ask(words)
        except BaseException:
            helper.end()
            raise
        if answer is not None:
            idle.append(helper)
            return answer
        error = helper.error()
        # One that waited may have been killed meanwhile.
        if is_new:
            raise error


def _forget_all() -> None:
    for helper in list(_helpers):
        helper.forget()
    _helpers.clear()
    _idle.clear()


@atexit.register
def _end_all() -> None:
    for helper in list(_helpers):
        helper.end()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forget_all)
