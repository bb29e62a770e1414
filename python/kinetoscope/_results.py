"""The results of an analysis next to the recordings: `metrics.json`, read if it belongs to them."""

from __future__ import annotations

import contextlib
import json
import os
import shutil
import tempfile
from pathlib import Path
from typing import Any, Dict, Mapping, Optional, Tuple

from . import _programs, _runs_table
from ._errors import KinetoscopeError

METRICS = "metrics.json"
# Results that an analysis keeps next to the recordings; the one that is read comes last.
KEPT = (_runs_table.TABLE, "metrics.csv", METRICS)
# What the program keeps of each recording next to its results, so that a later analysis reads none again.
CACHE = ".analysis-cache"


class NoResultsError(KinetoscopeError):
    """There are no results of these recordings."""


def read(
    folder: Path, run_keys: Mapping[str, str], schema: int, programs: Optional[_programs.PathLike]
) -> Dict[str, Any]:
    """The contents of `metrics.json`, whose runs must be those given by file and run key."""
    analysis, found = _parsed(folder / METRICS, schema)
    if has_means_only(analysis):
        found = _keys_of_table(folder, programs)
    if found != dict(run_keys):
        differing = sum(run_keys.get(file) != found.get(file) for file in {**run_keys, **found})
        raise NoResultsError(f"{folder / METRICS} belongs to other recordings: {differing} differ")
    return analysis


def has_means_only(analysis: Mapping[str, Any]) -> bool:
    """Whether there are so many runs that only `runs.parquet` has the metrics of each."""
    return bool(analysis.get("run_count") and not analysis["runs"])


def _keys_of_table(folder: Path, programs: Optional[_programs.PathLike]) -> Dict[str, str]:
    try:
        keys = _runs_table.read(folder, ["file", "run_key"], programs)
    except KinetoscopeError as error:
        raise NoResultsError(error.message) from error
    return dict(zip(keys["file"], keys["run_key"]))


def read_of_some(folder: Path, run_keys: Mapping[str, str], schema: int) -> Dict[str, Any]:
    """The part of `metrics.json` on some of its runs; answers and means of more runs are left out."""
    analysis, found = _parsed(folder / METRICS, schema)
    for file, run_key in run_keys.items():
        if found.get(file) != run_key:
            raise NoResultsError(f"{folder / METRICS} does not have the run of {file}")
    if set(found) == set(run_keys):
        return analysis
    metrics = [metric for metric in analysis["metrics"] if metric.get("run", {}).get("file") in run_keys]
    return {**analysis, "metrics": metrics, "answer": None}


def _parsed(path: Path, schema: int) -> Tuple[Dict[str, Any], Dict[str, str]]:
    """The contents, and the run keys by file."""
    try:
        analysis: Dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
        found = {str(run["file"]): str(run["run_key"]) for run in analysis["runs"]}
        written = analysis["schema"]
    except FileNotFoundError:
        raise NoResultsError(f"{path} does not exist") from None
    except OSError as error:
        raise NoResultsError(f"{path} cannot be read: {error.strerror}") from error
    except (ValueError, KeyError, TypeError, RecursionError) as error:
        raise NoResultsError(f"{path} is not the result of an analysis") from error
    if written != schema:
        raise NoResultsError(f"{path} has schema version {written}; this package reads version {schema}")
    return analysis, found


def is_older(folder: Path, description: Path) -> bool:
    """Whether the results are older than the description of the folder, whose question, checks or fits may have changed since."""
    try:
        return (folder / METRICS).stat().st_mtime_ns < description.stat().st_mtime_ns
    except OSError:
        return False


def lend_cache(folder: Path, scratch: Path) -> None:
    """Copies the cache of earlier analyses to the folder of a new one, which then reads changed recordings only."""
    with contextlib.suppress(OSError, shutil.Error):
        shutil.copytree(folder / CACHE, scratch / CACHE)


def keep(scratch: Path, folder: Path) -> None:
    """Copies the results of an analysis, and its cache if there is none, next to the recordings, if the disk admits them."""
    with contextlib.suppress(OSError, shutil.Error), tempfile.TemporaryDirectory(prefix=".kinetoscope-", dir=folder) as inner:
        if (scratch / CACHE).is_dir() and not (folder / CACHE).exists():
            shutil.copytree(scratch / CACHE, Path(inner) / CACHE)
            os.rename(Path(inner) / CACHE, folder / CACHE)
        for name in KEPT:
            if name == _runs_table.TABLE and not (scratch / name).exists():
                continue
            shutil.copyfile(scratch / name, Path(inner) / name)
            os.replace(Path(inner) / name, folder / name)
