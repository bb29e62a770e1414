"""Guarantee: the metrics of many runs, and of runs without recordings, are read from `runs.parquet` and are those of the analysis."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from typing import Any, Dict, Optional

import numpy as np
import pytest

import kinetoscope as k
from kinetoscope import _folder, _programs, _results

GAS: Dict[str, Any] = {"name": "many", "model": {"gas": {"particles": 10, "duration_s": 0.002}}, "record": {"frames": 2}}
RATIO = "pressure.second_half_over_first"


def gas(keep: str) -> Dict[str, Any]:
    return {**GAS, "record": {"frames": 2, "keep": keep}}


@pytest.fixture(scope="module")
def many(tmp_path_factory: pytest.TempPathFactory, programs: Optional[str]) -> k.Experiment:
    """1,002 runs: two more than those of which `metrics.json` has the metrics of each."""
    sweep = {"model.gas.temperature_k": [200, 250, 300]}
    output = tmp_path_factory.mktemp("many")
    return k.run(gas("metrics"), sweep=sweep, replicates=334, output=output, programs=programs)


def test_runs_without_recordings_have_metrics(tmp_path: Path, programs: Optional[str]) -> None:
    sweep = {"model.gas.temperature_k": [200, 300]}
    kept, recorded = (
        k.run(gas(keep), sweep=sweep, replicates=2, output=tmp_path / keep, programs=programs) for keep in ("metrics", "all")
    )
    assert kept.runs == () and "metrics of its runs in" in repr(kept) and len(recorded.runs) == 4
    opened = k.open(kept.path, programs=programs)
    for where in ({"temperature_k": 200, "replicate": 0}, {"temperature_k": 300, "replicate": 1}):
        assert kept.metric(RATIO, **where) == opened.metric(RATIO, **where) == recorded.metric(RATIO, **where)
    assert kept.metric("pressure.measured", temperature_k=300) == recorded.metric("pressure.measured", temperature_k=300)
    assert len(kept.table("pandas")) == len(recorded.table("pandas"))
    assert list(kept.table("pandas", wide=True)[RATIO]) == list(recorded.table("pandas", wide=True)[RATIO])


def test_metrics_of_many_runs_are_read_from_their_table(many: k.Experiment, programs: Optional[str]) -> None:
    wide = many.table("pandas", wide=True)
    assert list(wide.columns)[:3] == ["temperature_k", "replicate", "file"] and len(wide) == 1002
    row = wide[(wide["temperature_k"] == 250) & (wide["replicate"] == 77)]
    assert many.metric(RATIO, temperature_k=250, replicate=77) == row[RATIO].item()
    points = many.table("pandas", wide=True, by="point")
    assert list(points["temperature_k"]) == [200, 250, 300] and list(points["replicates"]) == [334] * 3
    means = wide.groupby("temperature_k")["pressure.measured"].mean()
    np.testing.assert_allclose(points["pressure.measured"], means, rtol=1e-12)
    assert many.metric("pressure.measured", temperature_k=250) == points["pressure.measured"][1]
    with pytest.raises(k.KinetoscopeError, match="nearest first: 250, 300, 200"):
        many.metric(RATIO, temperature_k=260, replicate=77)
    # The long table has means and fits only.
    assert len(many.metrics) < 1002


def test_points_of_many_runs_without_replicates_are_the_runs(tmp_path: Path, programs: Optional[str]) -> None:
    sweep = {"model.gas.temperature_k": {"from": 200.0, "to": 300.0, "count": 1002}}
    single = k.run(gas("metrics"), sweep=sweep, output=tmp_path, programs=programs)
    points, runs = single.table("pandas", wide=True, by="point"), single.table("pandas", wide=True)
    assert list(points.columns)[:2] == ["temperature_k", "replicates"] and set(points["replicates"]) == {1}
    assert list(points[RATIO]) == list(runs[RATIO]) and len(points) == 1002


def test_results_of_many_runs_need_no_program(many: k.Experiment, tmp_path: Path) -> None:
    value = many.metric("pressure.measured", temperature_k=250)
    pytest.importorskip("polars")
    again = k.open(many.path, programs=tmp_path)
    assert again.metric("pressure.measured", temperature_k=250) == value
    assert again.metric(RATIO, temperature_k=250, replicate=3) == many.metric(RATIO, temperature_k=250, replicate=3)
    # Control: results of other runs are not read.
    keys = dict(again._run_keys())
    keys[next(iter(keys))] = "0" * 64
    with pytest.raises(_results.NoResultsError, match="other recordings: 1 differ"):
        _results.read(many.path, keys, None)


def test_runs_of_a_description_are_those_of_its_toml(many: k.Experiment) -> None:
    text = (many.path / "experiment.toml").read_text(encoding="utf-8")
    entries = _folder.entries(many.path, text)
    # Control: a run that the program does not write so is read as TOML.
    other = _folder.entries(many.path, text.replace("replicate = 0", "replicate = +0", 1))
    assert entries == other and len(entries) == 1002 and entries[0].coordinates == (("model.gas.temperature_k", "200"),)


def test_the_program_prints_the_table_if_polars_is_missing(many: k.Experiment, monkeypatch: pytest.MonkeyPatch) -> None:
    expected = many.table("pandas", wide=True)
    found = importlib.util.find_spec
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None if name == "polars" else found(name))
    printed = many.table("pandas", wide=True)
    assert list(printed.columns) == list(expected.columns) and len(printed) == 1002
    for name in expected.columns:
        assert list(printed[name].dropna()) == list(expected[name].dropna()), name
    monkeypatch.setattr(_programs, "find", _missing)
    with pytest.raises(k.ProgramNotFoundError, match="`polars`, which reads .*runs.parquet, is not installed"):
        many.table("pandas", wide=True)


def _missing(programs: object = None) -> str:
    raise k.ProgramNotFoundError("there is no program", "install it")
