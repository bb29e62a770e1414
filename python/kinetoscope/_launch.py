"""Runs experiments, each into a folder of its own."""

from __future__ import annotations

import contextlib
import hashlib
import os
import threading
from pathlib import Path
from typing import Any, Dict, FrozenSet, Iterator, List, Mapping, Optional

from . import _folder, _manifest, _programs, _progress
from ._errors import KinetoscopeError
from ._experiment import Experiment

# Letters of a run key in the name of a folder, as in those of recordings.
KEY_LETTERS = 8


def run(
    manifest: _manifest.Manifest,
    *,
    sweep: Optional[_manifest.Sweep] = None,
    replicates: Optional[int] = None,
    seed: Optional[int] = None,
    set: Optional[Mapping[str, object]] = None,
    output: _programs.PathLike = "recordings",
    jobs: Optional[int] = None,
    force: bool = False,
    progress: Optional[bool] = None,
    verbose: bool = False,
    programs: Optional[_programs.PathLike] = None,
) -> Experiment:
    """Runs the experiment of a manifest and returns its recordings.

    The manifest is the path of a file, TOML as text, or a dict. ``sweep`` has the values of keys,
    as lists or as ranges such as ``{"from": 200, "to": 300, "count": 11}``. All combinations are run; ``replicates`` is the
    number of runs per combination, and ``set`` overrides other keys. Finished runs are not rerun unless a value, the seed
    or the physics has changed, or with ``force``.

    ``output`` is the folder of all experiments. If its folder of this name has other recordings already, as in a loop
    over seeds, the experiment is named with its run key as well. ``jobs`` is the number of runs to execute in parallel,
    and ``programs`` the folder of the program ``kinetoscope`` if it is not installed with this package. A line of
    progress is shown in terminals and notebooks unless ``progress=False``; ``verbose`` prints a line per finished run.

    >>> gas = kinetoscope.run(
    ...     {"name": "warm", "model": {"gas": {"particles": 50, "duration_s": 0.02}}},
    ...     sweep={"model.gas.temperature_k": [200, 300]}, output=folder, programs=programs
    ... )
    >>> [run.coordinates for run in gas.runs]
    [{'temperature_k': 200}, {'temperature_k': 300}]
    """
    values = dict(set or {})
    if seed is not None:
        values["seed"] = seed
    if replicates is not None:
        values["replicates"] = replicates
    folder = _programs.absolute(output)
    with _manifest.source(manifest, sweep) as source:
        planned = ["--output", os.fspath(folder), *_manifest.overrides(values)]
        name = str(values.get("name") or source.name)
        is_varied = bool(values) or not source.is_file
        shown = _progress.of(name, progress, verbose)
        arguments = ["run", "--json", "--quiet"] if shown is None else ["run", "--json", "--verbose"]
        if jobs is not None:
            arguments += ["--jobs", str(jobs)]
        if force:
            arguments.append("--force")
        with _own_name(source, planned, folder / name, is_varied, programs) as options:
            command = [*arguments, *planned, *options, os.fspath(source.path)]
            try:
                finished = _programs.call(command, programs, None if shown is None else shown.add)
            finally:
                if shown is not None:
                    shown.end()
        if finished.code != _programs.EXIT_OK:
            finished.messages = source.located(finished.messages)
            raise finished.error()
        return _finished(finished.json()["experiments"], source, programs)


def _finished(experiments: List[Dict[str, Any]], source: _manifest.Source, programs: Optional[_programs.PathLike]) -> Experiment:
    # Manifests that `start_from` names are run first.
    path = os.fspath(source.path)
    result = next((entry for entry in experiments if entry.get("manifest") == path), experiments[-1])
    files = [Path(entry["recording"]) for entry in result["runs"] if entry.get("recording")]
    experiment = Experiment(Path(result["destination"]), files, programs=programs)
    listed = {path.name for path in _folder.listed(experiment.path)}
    if not listed.issuperset(file.name for file in files):
        raise KinetoscopeError(
            f"another process has described its own recordings in {experiment.path} meanwhile",
            "run all values as one experiment, with `sweep` or `replicates`, or give each process an `output` of its own",
        )
    return experiment


class _Folder:
    """A folder that calls of this process are using."""

    def __init__(self) -> None:
        self.lock = threading.Lock()
        self.users = 0
        self.run_keys: Optional[FrozenSet[str]] = None


_folders: Dict[Path, _Folder] = {}
_folders_lock = threading.Lock()


@contextlib.contextmanager
def _own_name(
    source: _manifest.Source,
    planned: List[str],
    folder: Path,
    is_varied: bool,
    programs: Optional[_programs.PathLike],
) -> Iterator[List[str]]:
    """The options that name the experiment, whose folder is used by one call at a time.

    A file without changed values always describes the folder of its name, as on the command line. Otherwise, recordings
    that are there already stay described.
    """
    options: List[str] = []
    with _folders_lock:
        used = _folders.get(folder)
        if is_varied and (used is not None or (folder / _folder.DESCRIPTION).is_file()):
            keys = _run_keys(source, planned, programs)
            earlier = used.run_keys if used is not None and used.run_keys is not None else _described(folder)
            if keys and earlier - keys:
                own = next(iter(keys)) if len(keys) == 1 else hashlib.sha256("".join(sorted(keys)).encode()).hexdigest()
                folder = folder.with_name(f"{folder.name}__{own[:KEY_LETTERS]}")
                options = _manifest.overrides({"name": folder.name})
        elif is_varied:
            keys = _run_keys(source, planned, programs)
        else:
            keys = frozenset()
        used = _folders.setdefault(folder, _Folder())
        used.users += 1
        used.run_keys = keys or used.run_keys
    try:
        with used.lock:
            yield options
    finally:
        with _folders_lock:
            used.users -= 1
            if not used.users:
                del _folders[folder]


def _run_keys(
    source: _manifest.Source, planned: List[str], programs: Optional[_programs.PathLike]
) -> FrozenSet[str]:
    """The run keys of the planned runs; none if the plan fails, which the run then reports."""
    finished = _programs.call(["why", "--json", *planned, os.fspath(source.path)], programs)
    if finished.code != _programs.EXIT_OK:
        return frozenset()
    return frozenset(str(run["run_key"]) for run in finished.json().get("runs", []))


def _described(folder: Path) -> FrozenSet[str]:
    """The run keys that the folder describes."""
    text = _folder.description(folder)
    return frozenset(entry.run_key for entry in _folder.entries(folder, text)) if text is not None else frozenset()
