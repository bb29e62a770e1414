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
# Layout of `metrics.json` that this package reads.
METRICS_SCHEMA = 3
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
# Results that an analysis keeps next to the recordings; the one that is read comes last.
KEPT = (_runs_table.TABLE, "metrics.csv", METRICS)
# What the program keeps of each recording next to its results, so that a later analysis reads none again.
CACHE = ".analysis-cache"


class NoResultsError(KinetoscopeError):
    """There are no results of these recordings."""


def read(
    folder: Path, run_keys: Mapping[str, str], programs: Optional[_programs.PathLike]
) -> Dict[str, Any]:
    """The contents of `metrics.json`, whose runs must be those given by file and run key."""
    analysis, found = _parsed(folder / METRICS)
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


def read_of_some(folder: Path, run_keys: Mapping[str, str]) -> Dict[str, Any]:
    """The part of `metrics.json` on some of its runs; answers and means of more runs are left out."""
    analysis, found = _parsed(folder / METRICS)
    for file, run_key in run_keys.items():
        if found.get(file) != run_key:
            raise NoResultsError(f"{folder / METRICS} does not have the run of {file}")
    if set(found) == set(run_keys):
        return analysis
    metrics = [metric for metric in analysis["metrics"] if metric.get("run", {}).get("file") in run_keys]
    return {**analysis, "metrics": metrics, "answer": None}


def _parsed(path: Path) -> Tuple[Dict[str, Any], Dict[str, str]]:
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
    if written != METRICS_SCHEMA:
        raise NoResultsError(f"{path} has schema version {written}; this package reads version {METRICS_SCHEMA}")
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


def check_schema(analysis: Mapping[str, Any]) -> None:
    """Rejects the results of a program of another version."""
    schema = analysis["schema"]
    if schema != METRICS_SCHEMA:
        raise KinetoscopeError(
            f"the program writes metrics of schema version {schema}; this package reads version {METRICS_SCHEMA}",
            "install the same version of both: `pip install --upgrade kinetoscope`",
        )


def row_of(metric: Mapping[str, Any], definition: Mapping[str, Any]) -> Dict[str, Any]:
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
    row["replicate"], row["replicates"], row["along"] = place.get("replicate"), place.get("replicates"), place.get("along")
    row["file"] = place.get("file")
    return row


def value_of(row: Mapping[str, Any]) -> float:
    """The value of a metric, which may be missing for a reason."""
    if row["value"] is None:
        raise KinetoscopeError(f"`{row['metric']}` has no value: {row['reason']}")
    return float(row["value"])
