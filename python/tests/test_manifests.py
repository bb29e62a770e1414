"""Guarantee: `run` takes a path, TOML or a dict, sweeps are set from Python, and calls in a loop or in threads keep their recordings."""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, Dict, Optional

import numpy as np
import pytest

import kinetoscope as k
from kinetoscope import _toml

GAS: Dict[str, Any] = {
    "name": "small",
    "model": {"gas": {"particles": 50, "duration_s": 0.02}},
    "record": {"frames": 5},
    "checks": [{"metric": "pressure.measured", "minimum": 0.0}, {"metric": "pressure.measured", "maximum": 1.0}],
}
TEXT = 'name = "small"\n[model.gas]\nparticles = 50\nduration_s = 0.02\n[record]\nframes = 5\n'


def test_a_dict_a_text_and_a_file_give_the_same_recording(tmp_path: Path, programs: Optional[str]) -> None:
    (tmp_path / "small.toml").write_text(TEXT)
    manifests: list[Any] = [GAS, TEXT, tmp_path / "small.toml", os.fspath(tmp_path / "small.toml")]
    runs = [
        k.run(manifest, output=tmp_path / str(number), programs=programs).runs[0]
        for number, manifest in enumerate(manifests)
    ]
    assert len({run.path.read_bytes() for run in runs}) == len({run.path.name for run in runs}) == 1
    assert runs[0].path.name.startswith("small__")


def test_a_document_is_its_table() -> None:
    table = {
        "a": 1,
        "quoted \" key": "x\ny",
        "sweep": {"model.gas.temperature_k": np.array([1.5, 2.0]).tolist()},
        "model": {"dem": {"walls": [{"from": [0, 1]}, {"from": [1, 2], "inner": {"b": True}}], "discs": 5}},
        "empty": {},
        "record": {"channels": {"exclude": []}},
        "checks": [{"metric": "m", "where": {"variant": "x y", "n": 1}}, {"metric": "n"}],
    }
    text, places = _toml.document(table)
    assert _toml.parsed(text) == table
    line = text.splitlines().index("b = true") + 1
    assert places[line] == 'manifest["model"]["dem"]["walls"][1]["inner"]["b"]'


def test_errors_of_a_dict_have_their_place_in_it(tmp_path: Path, programs: Optional[str]) -> None:
    wrong: Dict[str, Any] = {"model": {"gas": {"particles": -4, "temprature_k": 3, "radius_m": "wide"}}, "shade": 1}
    with pytest.raises(k.RunFailedError) as caught:
        k.run(wrong, output=tmp_path, programs=programs)
    for text in (
        '`model.gas.particles` is -4; must be a whole number from 1',
        '--> manifest["model"]["gas"]["particles"]',
        "did you mean `temperature_k`?",
        '--> manifest["model"]["gas"]["temprature_k"]',
        '--> manifest["model"]["gas"]["radius_m"]',
        '--> manifest["shade"]',
    ):
        assert text in str(caught.value)
    assert "kinetoscope-" not in str(caught.value)
    with pytest.raises(k.RunFailedError, match='--> manifest\\["checks"\\]\\[1\\]\\["metric"\\]'):
        k.run({**GAS, "checks": [GAS["checks"][0], {"metric": "presure", "minimum": 0}]}, output=tmp_path, programs=programs)
    with pytest.raises(k.KinetoscopeError, match='`manifest\\["model"\\]\\["gas"\\]\\["particles"\\]`: None is not a value'):
        k.run({"model": {"gas": {"particles": None}}}, output=tmp_path, programs=programs)
    with pytest.raises(k.KinetoscopeError, match="the key 1 in `manifest` is not a text"):
        k.run({1: 2}, output=tmp_path, programs=programs)  # type: ignore[dict-item]
    assert not list(tmp_path.iterdir())


def test_errors_of_a_text_have_its_line(tmp_path: Path, programs: Optional[str]) -> None:
    with pytest.raises(k.RunFailedError, match="`model.gas.particles` is -50; (.|\n)*--> the manifest, line 3"):
        k.run(TEXT.replace("50", "-50"), output=tmp_path, programs=programs)
    with pytest.raises(k.RunFailedError, match="--> the manifest, line 2"):
        k.run("name = \n[model.gas", output=tmp_path, programs=programs)
    with pytest.raises(k.KinetoscopeError, match="the manifest is not TOML: .*line 2"):
        k.run("[model.gas]\nparticles\nduration_s = 1", sweep={"model.gas.particles": [1]}, output=tmp_path, programs=programs)


@pytest.mark.parametrize("kind", ["dict", "text", "file"])
def test_a_sweep_is_set_from_python(kind: str, tmp_path: Path, programs: Optional[str]) -> None:
    (tmp_path / "small.toml").write_text(TEXT)
    manifest: Any = {"dict": GAS, "text": TEXT, "file": tmp_path / "small.toml"}[kind]
    sweep = {"model.gas.temperature_k": np.linspace(200, 300, 3), "model.gas.mass_kg": [1e-26]}
    experiment = k.run(manifest, sweep=sweep, replicates=2, output=tmp_path, programs=programs)  # type: ignore[arg-type]
    assert experiment.path == tmp_path / "small" and len(experiment.runs) == 6
    assert [run.coordinates["temperature_k"] for run in experiment.runs[::2]] == [200, 250, 300]
    with pytest.raises(k.RunFailedError, match='--> manifest\\["sweep"\\]\\["model.gas.temprature_k"\\]'):
        k.run(manifest, sweep={"model.gas.temprature_k": [1, 2]}, output=tmp_path, programs=programs)


def test_starts_are_relative_to_the_working_directory(
    tmp_path: Path, programs: Optional[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    first = k.run(TEXT, output="out", programs=programs).runs[0]
    start = os.path.relpath(first.path)
    table: Dict[str, Any] = {"name": "next", "model": {"gas": {"start_from": start, "duration_s": 0.02}}, "record": {"frames": 5}}
    text = f'name = "next"\n[model.gas]\nstart_from = "{start}"\nduration_s = 0.02\n[record]\nframes = 5\n'
    for manifest in (table, text):
        following = k.run(manifest, output="out", programs=programs).runs[0]
        assert following["/state"][0].tobytes() == first["/state"][-1].tobytes()


def test_a_loop_over_seeds_gives_an_experiment_per_seed(tmp_path: Path, programs: Optional[str]) -> None:
    experiments = [k.run(TEXT, seed=seed, output=tmp_path, programs=programs) for seed in (1, 2, 3)]
    folders = [experiment.path for experiment in experiments]
    assert folders[0] == tmp_path / "small" and len(set(folders)) == 3
    for experiment in experiments:
        opened = k.open(experiment.path, programs=programs)
        assert [run.path for run in opened.runs] == [run.path for run in experiment.runs]
        assert experiment.path.name == experiment.name in ("small", f"small__{experiment.runs[0].run_key[:8]}")
    # The same loop again finds the same folders, in any order.
    again = [k.run(TEXT, seed=seed, output=tmp_path, programs=programs).path for seed in (3, 1, 2)]
    assert again == [folders[2], folders[0], folders[1]]
    # Control: more values of the same experiment stay in its folder.
    assert k.run(TEXT, replicates=2, seed=1, output=tmp_path, programs=programs).path == folders[0]
    assert len(k.open(folders[0], programs=programs).runs) == 2


def test_threads_share_an_output(tmp_path: Path, programs: Optional[str]) -> None:
    def value(seed: int) -> float:
        return k.run(TEXT, seed=seed, output=tmp_path, programs=programs).metric("pressure.measured")

    with ThreadPoolExecutor(4) as pool:
        values = list(pool.map(value, [1, 2, 3, 4, 1, 2]))
    assert values[4:] == values[:2] and len(set(values)) == 4
    assert len(list(tmp_path.iterdir())) == 4


@pytest.mark.parametrize("values", [5, None, "abc"])
def test_an_axis_that_is_no_list_is_named(values: Any, tmp_path: Path, programs: Optional[str]) -> None:
    with pytest.raises(k.KinetoscopeError, match="temperature_k.*expected a list of values or a range"):
        k.run(GAS, sweep={"model.gas.temperature_k": values}, output=tmp_path, programs=programs)
