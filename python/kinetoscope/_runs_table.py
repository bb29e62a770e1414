"""The table `runs.parquet` of an experiment: one row per run, of which the columns are read that are needed."""

from __future__ import annotations

import csv
import importlib.util
import os
from pathlib import Path
from typing import Any, Dict, List, Optional, Sequence

from . import _folder, _programs
from ._errors import KinetoscopeError, ProgramNotFoundError

TABLE = "runs.parquet"
# Columns that are no metrics; the coordinates precede them.
FIRST = "replicate"
OTHERS = (
    "seed",
    "outcome",
    "outcome_detail",
    "frames",
    "end_time",
    "messages",
    "file",
    "run_key",
    "program_version",
    "physics_version",
    "details",
    "manifest",
)
ERROR = ".standard_error"
# Columns of texts.
TEXTS = ("outcome", "outcome_detail", "messages", "file", "run_key", _folder.VARIANT)

Columns = Dict[str, List[Any]]


def metric_names(columns: Sequence[str]) -> List[str]:
    """The columns that are metrics."""
    names = columns[columns.index(FIRST) + 1 :] if FIRST in columns else columns
    return [name for name in names if name not in OTHERS and not name.endswith(ERROR)]


def read(folder: Path, names: Optional[Sequence[str]], programs: Optional[_programs.PathLike]) -> Columns:
    """The columns with these names, or those of the coordinates, replicates, files and metrics; a missing value is `None`.

    Polars reads them from the file; without it, the program prints them.
    """
    path = folder / TABLE
    if not path.is_file():
        raise KinetoscopeError(f"{path} does not exist", f"`kinetoscope analyze {folder}` writes it")
    if importlib.util.find_spec("polars") is None:
        return _printed(path, names, programs)
    import polars

    try:
        table = polars.scan_parquet(path)
        known = table.collect_schema().names()
        frame = table.select([name for name in _wanted(known, names) if name in known]).collect()
    except (OSError, polars.exceptions.PolarsError) as error:
        raise KinetoscopeError(f"{path} cannot be read: {error}", f"`kinetoscope analyze {folder}` writes it again") from error
    return {column.name: column.to_list() for column in frame}


def _wanted(known: Sequence[str], names: Optional[Sequence[str]]) -> Sequence[str]:
    if names is not None:
        return names
    coordinates = known[: known.index(FIRST)] if FIRST in known else []
    return [*coordinates, FIRST, "file", *metric_names(known)]


def _printed(path: Path, names: Optional[Sequence[str]], programs: Optional[_programs.PathLike]) -> Columns:
    options = [] if names is None else ["--columns", ",".join(names)]
    try:
        finished = _programs.call(["table", "--format", "csv", *options, os.fspath(path)], programs)
    except ProgramNotFoundError as error:
        raise ProgramNotFoundError(
            f"the package `polars`, which reads {path}, is not installed, and {error.message}",
            f"`pip install 'kinetoscope[polars]'`; {error.help}",
        ) from error
    if finished.code != _programs.EXIT_OK:
        raise finished.error()
    lines = csv.reader(finished.output.splitlines())
    header = next(lines)
    wanted = _wanted(header, names)
    columns: Columns = {name: [] for name in wanted}
    places = [(columns[name].append, header.index(name), name in TEXTS) for name in wanted]
    for line in lines:
        for append, place, is_text in places:
            append((line[place] or None) if is_text else _folder.value_of(line[place]))
    return columns
