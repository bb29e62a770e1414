"""Guarantee: experiments run from Python as from the command line, and every failure names the next step."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Optional

import pytest

import kinetoscope as k
from kinetoscope import _player


def test_public_names_are_at_most_thirteen() -> None:
    assert len(k.__all__) <= 13
    public = {name for name in vars(k) if not name.startswith(("_", "@"))} | {"__version__"}
    assert public == set(k.__all__)


def test_every_public_name_has_documentation_with_an_example() -> None:
    for name in ("Experiment", "Frames", "Run", "run", "simulate", "open", "run_checks", "KinetoscopeError"):
        assert ">>> " in (getattr(k, name).__doc__ or ""), name


def test_metrics_are_those_of_the_own_recordings_after_another_run_in_the_folder(
    experiments: Path, tmp_path: Path, programs: Optional[str]
) -> None:
    manifest = tmp_path / "first_run.toml"
    runs = []
    for seed in (1, 2, 3):
        # As on the command line, an edited file describes the same folder.
        manifest.write_text((experiments / manifest.name).read_text().replace("seed = 1", f"seed = {seed}"))
        runs.append(k.run(manifest, output=tmp_path, programs=programs))
    alone = [
        k.run(manifest, seed=seed, output=tmp_path / str(seed), programs=programs).metric("energy.residual")
        for seed in (1, 2, 3)
    ]
    assert len(set(alone)) == 3
    assert [run.metric("energy.residual") for run in runs] == alone
    assert all(len(run.checks) == 3 for run in runs)
    # What the folder describes now is that of the last run, and nothing is left of the others' analyses.
    assert k.open(runs[0].path, programs=programs).metric("energy.residual") == alone[2]
    assert not list(tmp_path.glob(".*"))


def test_a_folder_is_no_manifest(experiments: Path, tmp_path: Path, programs: Optional[str]) -> None:
    with pytest.raises(k.KinetoscopeError, match="is a folder"):
        k.run(experiments, output=tmp_path, programs=programs)


def test_seed_and_overrides_are_those_of_the_recording(
    experiments: Path, tmp_path: Path, programs: Optional[str]
) -> None:
    change = {"model.dem.discs": 5, "model.dem.restitution": 0.25, "model.dem.periodic": "x"}
    run = k.run(experiments / "first_run.toml", seed=9, set=change, output=tmp_path, programs=programs).runs[0]
    model = run.manifest["model"]
    assert isinstance(model, dict) and isinstance(model["dem"], dict)
    dem = model["dem"]
    assert (run.seed, dem["discs"], dem["restitution"], dem["periodic"]) == (9, 5, 0.25, "x")


def test_a_sweep_has_metrics_by_coordinates(experiments: Path, tmp_path: Path, programs: Optional[str]) -> None:
    change = {"replicates": 2, "model.gas.particles": 200}
    gas = k.run(experiments / "gas_pressure_vs_temperature.toml", set=change, output=tmp_path, programs=programs)
    assert len(gas.runs) == 8
    mean = gas.metric("pressure.measured", temperature_k=300)
    each = [gas.metric("pressure.second_half_over_first", temperature_k=300, replicate=n) for n in (0, 1)]
    assert mean > 0 and each[0] != each[1]
    table = gas.metrics
    assert list(table.columns)[:4] == ["temperature_k", "replicate", "metric", "value"]
    assert mean in list(table["value"])
    assert list(gas.table("pandas").columns) == list(table.columns)
    with pytest.raises(k.KinetoscopeError, match="has 4 values.*\nhelp: the first is at temperature_k = 200"):
        gas.metric("pressure.measured")
    for where, help in (
        ({"temperature_k": 310}, "the values of `temperature_k`, nearest first: 300, 250, 373.15, 200$"),
        ({"temperature_k": 300, "replicate": 7}, "the values of `replicate`, nearest first: 1, 0"),
        ({"temperature_k": "warm", "replicate": 7}, "the values of `temperature_k`, nearest first: .*200"),
    ):
        with pytest.raises(k.KinetoscopeError, match=f"has no value at temperature_k = .*\nhelp: {help}"):
            gas.metric("pressure.second_half_over_first", **where)


def test_a_coordinate_may_be_a_position(tmp_path: Path, programs: Optional[str]) -> None:
    manifest = tmp_path / "centers.toml"
    manifest.write_text(
        "[model.gas]\nparticles = 50\nduration_s = 0.02\n"
        "[sweep]\n\"model.gas.center_m\" = [[0.0, 0.0], [0.5, 0.25]]\n"
    )
    gas = k.run(manifest, output=tmp_path, programs=programs)
    name = "pressure.second_half_over_first"
    assert gas.metric(name, center_m="0.5_0.25") > 0
    # Positions are written as in the names of files.
    with pytest.raises(k.KinetoscopeError, match="help: the values of `center_m`, nearest first: '0.5_0.25', '0_0'"):
        gas.metric(name, center_m=[0.5, 0.25])


def test_errors_of_a_manifest_are_those_of_the_program(tmp_path: Path, programs: Optional[str]) -> None:
    bad = tmp_path / "bad.toml"
    bad.write_text('name = "bad"\n[model.gas]\nparticles = -4\n')
    with pytest.raises(k.RunFailedError, match="`model.gas.particles` is -4"):
        k.run(bad, output=tmp_path, programs=programs)
    with pytest.raises(k.RunFailedError, match="cannot read the manifest"):
        k.run(tmp_path / "none.toml", output=tmp_path, programs=programs)
    with pytest.raises(k.KinetoscopeError, match="is not a value of a manifest"):
        k.run(bad, set={"seed": object()}, output=tmp_path, programs=programs)


def test_a_missing_program_is_an_error_with_the_remedy(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, experiments: Path
) -> None:
    with pytest.raises(k.ProgramNotFoundError, match="there is no program `kinetoscope` in"):
        k.run(experiments / "first_run.toml", output=tmp_path, programs=tmp_path)
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setattr(sys, "executable", str(tmp_path / "python"))
    monkeypatch.setattr("kinetoscope._programs._SCRIPT_FOLDERS", [str(tmp_path)])
    with pytest.raises(k.ProgramNotFoundError, match="nor on the PATH\nhelp: `pip install --force-reinstall kinetoscope`"):
        k.run(experiments / "first_run.toml", output=tmp_path)
    # Control: a program on the PATH is found, and one of another system is an error with its own remedy.
    foreign = tmp_path / "kinetoscope"
    foreign.write_bytes(b"\x7fELF of another processor")
    foreign.chmod(0o755)
    with pytest.raises(k.ProgramNotFoundError, match="cannot be executed: Exec format error\nhelp: install a wheel"):
        k.run(experiments / "first_run.toml", output=tmp_path)


def test_verification_finds_a_difference(recording: k.Run, tmp_path: Path) -> None:
    result = recording.verify()
    assert result and "equal in every byte" in str(result)
    torn = tmp_path / recording.path.name
    torn.write_bytes(recording.path.read_bytes()[:-4000])
    with pytest.raises(k.KinetoscopeError, match="exit code 5"):
        k.Run(torn, allow_torn=True, programs=recording._programs).verify()


def test_read_only_package_and_folder_without_home(
    experiment: k.Experiment, programs: Optional[str], tmp_path: Path
) -> None:
    """Neither the package nor the recordings can be written, and there is neither HOME nor any other usual variable."""
    script = (
        "import os, sys, kinetoscope as k; e = k.open(sys.argv[1], programs=sys.argv[2] or None); "
        "assert k.__file__.startswith(sys.argv[3]) and not os.access(sys.argv[1], os.W_OK) "
        "and not os.access(sys.argv[3], os.W_OK); "
        "print(e.metric('energy.total_change_relative'), len(list(e.runs[0]['/state'])))"
    )
    shutil.copytree(Path(k.__file__).parent, tmp_path / "kinetoscope", ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copytree(experiment.path, tmp_path / "recordings")
    # Root may write anywhere; without its capabilities, it is the owner of these folders only.
    command = ["setpriv", "--bounding-set=-all"] if os.geteuid() == 0 else []
    folders = [os.fspath(tmp_path / "recordings"), os.path.abspath(programs) if programs else "", os.fspath(tmp_path)]
    command += [sys.executable, "-c", script, *folders]
    before = sorted(tmp_path.rglob("*"))
    for folder in [tmp_path / "recordings", tmp_path / "kinetoscope", tmp_path]:
        folder.chmod(0o555)
    try:
        result = subprocess.run(
            command, env={"PYTHONPATH": os.fspath(tmp_path)}, cwd="/", capture_output=True, text=True
        )
    finally:
        tmp_path.chmod(0o755)
    assert result.returncode == 0, result.stderr
    assert result.stdout.endswith(" 251\n") and sorted(tmp_path.rglob("*")) == before


def test_the_player_shows_the_run_and_nothing_else(recording: k.Run) -> None:
    page = recording._player(3.0)
    assert _player.PLAYER_ONLY in page and 'class="film"' in page
    cell = _player.Page(page, 640)._repr_html_()
    assert cell.startswith('<iframe sandbox="allow-scripts"') and "<script" not in cell
    with pytest.raises(k.KinetoscopeError, match="only be shown in a notebook\nhelp: elsewhere"):
        recording.show()
