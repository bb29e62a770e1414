"""Guarantee: results are read from disk if they belong to the recordings; otherwise the analysis writes no report."""

from __future__ import annotations

import json
import os
import shutil
from pathlib import Path
from typing import Any, Callable, Dict, List, Optional

import pytest

import kinetoscope as k
from kinetoscope import _programs

SWEEP = """
name = "sweep"
replicates = 2
[model.gas]
particles = 50
duration_s = 0.02
[record]
frames = 5
[sweep]
"model.gas.temperature_k" = [200, 373.15]
[[checks]]
metric = "pressure.measured"
minimum = 0.0
"""


@pytest.fixture
def calls(monkeypatch: pytest.MonkeyPatch) -> List[str]:
    """The subcommands that are called from now on."""
    called: List[str] = []
    call = _programs.call

    def counted(arguments: Any, *others: Any, **named: Any) -> _programs.Finished:
        called.append(arguments[0])
        return call(arguments, *others, **named)

    monkeypatch.setattr(_programs, "call", counted)
    return called


@pytest.fixture
def sweep(tmp_path: Path, programs: Optional[str]) -> k.Experiment:
    (tmp_path / "sweep.toml").write_text(SWEEP)
    return k.run(tmp_path / "sweep.toml", output=tmp_path, programs=programs)


def without_program(experiment: k.Experiment, tmp_path: Path) -> k.Experiment:
    (tmp_path / "empty").mkdir(exist_ok=True)
    return k.open(experiment.path, programs=tmp_path / "empty")


def test_results_on_disk_need_no_program(sweep: k.Experiment, tmp_path: Path, calls: List[str]) -> None:
    value = sweep.metric("pressure.measured", temperature_k=200)
    assert calls == ["analyze"]
    again = without_program(sweep, tmp_path)
    assert again.metric("pressure.measured", temperature_k=200) == value
    assert again.table("pandas").equals(sweep.table("pandas"))
    assert (again.question, again.answer) == (sweep.question, sweep.answer)
    name = "pressure.second_half_over_first"
    assert [run.metric(name) for run in again.runs] == [run.metric(name) for run in sweep.runs]
    run = again.runs[3]
    alone = k.open(run.path, programs=tmp_path / "empty")
    assert alone.metric(name) == run.metric(name) == k.Run(run.path, programs=tmp_path / "empty").metric(name)
    assert calls == ["analyze"]


def test_one_metric_of_a_fresh_folder_writes_no_report(sweep: k.Experiment) -> None:
    before = {path.name for path in sweep.path.iterdir()}
    sweep.metric("pressure.measured", temperature_k=200)
    assert {path.name for path in sweep.path.iterdir()} - before == {
        "metrics.json",
        "metrics.csv",
        "runs.parquet",
        ".analysis-cache",
    }


def test_without_program_the_missing_file_is_named(sweep: k.Experiment, tmp_path: Path) -> None:
    fresh = without_program(sweep, tmp_path)
    with pytest.raises(k.ProgramNotFoundError, match="sweep/metrics.json does not exist, and there is no program.*\nhelp: "):
        fresh.metrics
    with pytest.raises(k.ProgramNotFoundError, match="metrics.json does not exist"):
        fresh.runs[0].metric("pressure.measured")


def test_checks_are_read_from_results_that_have_them(sweep: k.Experiment, tmp_path: Path) -> None:
    assert [check["passed"] for check in sweep.checks] == [True] * 6
    with pytest.raises(k.ProgramNotFoundError, match="metrics.json has no results of checks, and there is no program"):
        without_program(sweep, tmp_path).checks
    path = sweep.path / "metrics.json"
    path.write_text(json.dumps({**json.loads(path.read_text()), "checks": sweep.checks}))
    assert without_program(sweep, tmp_path).checks == sweep.checks


def changed_key(document: Dict[str, Any]) -> None:
    document["runs"][1]["run_key"] = "0" * 64


def missing_run(document: Dict[str, Any]) -> None:
    del document["runs"][0]


def newer_schema(document: Dict[str, Any]) -> None:
    document["schema"] = 99


@pytest.mark.parametrize(
    "change, reason",
    [(changed_key, "other recordings: 1 differ"), (missing_run, "1 differ"), (newer_schema, "has schema version 99")],
)
def test_results_of_other_recordings_are_not_read(
    change: Callable[[Dict[str, Any]], None], reason: str, sweep: k.Experiment, tmp_path: Path, calls: List[str]
) -> None:
    value = sweep.metric("pressure.measured", temperature_k=200)
    path = sweep.path / "metrics.json"
    document = json.loads(path.read_text())
    for metric in document["metrics"]:
        metric["value"] = 1e9
    path.write_text(json.dumps(document))
    # Control: the key decides, so that changed values of the same recordings are read.
    assert without_program(sweep, tmp_path).metric("pressure.measured", temperature_k=200) == 1e9
    change(document)
    path.write_text(json.dumps(document))
    with pytest.raises(k.ProgramNotFoundError, match=reason):
        without_program(sweep, tmp_path).metric("pressure.measured", temperature_k=200)
    again = k.open(sweep.path, programs=sweep._programs)
    assert again.metric("pressure.measured", temperature_k=200) == value
    assert without_program(sweep, tmp_path).metric("pressure.measured", temperature_k=200) == value


def test_results_older_than_the_description_are_renewed(
    sweep: k.Experiment, tmp_path: Path, programs: Optional[str], calls: List[str]
) -> None:
    assert sweep.question == ""
    manifest = tmp_path / "sweep.toml"
    manifest.write_text(manifest.read_text().replace('name = "sweep"', 'name = "sweep"\nquestion = "How warm is it?"'))
    assert k.run(manifest, output=tmp_path, programs=programs).question == "How warm is it?"
    assert calls == ["analyze", "run", "analyze"]


def test_torn_and_foreign_results_are_named(sweep: k.Experiment, tmp_path: Path) -> None:
    for text in ("{", "[]", '{"schema": 2}', "[" * 100_000):
        (sweep.path / "metrics.json").write_text(text)
        with pytest.raises(k.ProgramNotFoundError, match="metrics.json is not the result of an analysis"):
            without_program(sweep, tmp_path).metrics


def test_a_run_knows_its_place(sweep: k.Experiment, tmp_path: Path) -> None:
    places = [(run.coordinates, run.replicate) for run in sweep.runs]
    assert places == [({"temperature_k": value}, replicate) for value in (200, 373.15) for replicate in (0, 1)]
    assert k.Run(sweep.runs[2].path).coordinates == {"temperature_k": 373.15}
    name = "pressure.second_half_over_first"
    for run in sweep.runs:
        assert run.metric(name) == sweep.metric(name, replicate=run.replicate, **run.coordinates)
    with pytest.raises(k.UnknownNameError, match="did you mean `pressure.measured"):
        sweep.runs[0].metric("pressure.measure")
    # A copy of the recording alone has no place.
    shutil.copy(sweep.runs[2].path, tmp_path / "alone.mcap")
    assert k.Run(tmp_path / "alone.mcap").coordinates == {}


@pytest.mark.parametrize("library", ["polars", "pandas"])
def test_wide_tables_have_one_row_per_run_or_point(library: Any, sweep: k.Experiment) -> None:
    name = "pressure.measured"
    runs, points = sweep.table(library, wide=True), sweep.table(library, wide=True, by="point")
    assert list(runs.columns)[:3] == ["temperature_k", "replicate", "file"] and len(runs) == 4
    other = "pressure.second_half_over_first"
    assert list(runs[other]) == [run.metric(other) for run in sweep.runs]
    assert list(points.columns)[:2] == ["temperature_k", "replicates"] and list(points["replicates"]) == [2, 2]
    assert list(points[name]) == [sweep.metric(name, temperature_k=value) for value in (200, 373.15)]
    rows = sweep.table("pandas").query(f"metric == '{name}' and scope == 'sweep'")
    assert list(points[f"{name}.standard_error"]) == list(rows["standard_error"])


def test_results_are_read_without_writing(sweep: k.Experiment, tmp_path: Path) -> None:
    sweep.metrics
    before = {path: path.stat().st_mtime_ns for path in sweep.path.iterdir()}
    k.open(sweep.path, programs=sweep._programs).metric("pressure.measured", temperature_k=200)
    assert {path: path.stat().st_mtime_ns for path in sweep.path.iterdir()} == before
    assert not [name for name in os.listdir(sweep.path) if name.startswith(".kinetoscope-")]
