"""Guarantee: a run in memory has the frames and the metrics of a recorded one, leaves no file, and its program ends with Python."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, Dict, List, Optional

import pytest
from test_progress import LONG, children, is_running

import kinetoscope as k
from kinetoscope import _simulators

MODELS: Dict[str, Dict[str, Any]] = {
    "dem": {"discs": 6, "width_m": 0.006, "height_m": 0.006, "duration_s": 0.02},
    "gas": {"particles": 50, "duration_s": 0.02},
    "packing": {"discs": 6, "width": 10.0, "height": 10.0, "events_per_disc": 20},
    "orbit": {"duration_days": 400.0},
}
GAS: Dict[str, Any] = {"model": {"gas": MODELS["gas"]}, "record": {"frames": 5}}


def of_model(model: str) -> Dict[str, Any]:
    return {"name": "small", "model": {model: MODELS[model]}, "record": {"frames": 20}}


@pytest.mark.parametrize("model", MODELS)
def test_a_simulation_has_the_frames_and_metrics_of_a_recording(model: str, tmp_path: Path, programs: Optional[str]) -> None:
    experiment = k.run(of_model(model), seed=3, output=tmp_path, programs=programs)
    recorded, simulation = experiment.runs[0], k.simulate(of_model(model), seed=3, programs=programs)
    assert simulation.run_key == recorded.run_key and simulation.topics == recorded.topics
    for topic in recorded.topics:
        try:
            frames = recorded[topic]
        except k.KinetoscopeError:
            continue
        assert [frame.tobytes() for frame in simulation[topic]] == [frame.tobytes() for frame in frames]
    columns = [name for name in experiment.table("pandas").columns if name not in ("file", "scope")]
    ours, theirs = simulation.table("pandas")[columns], experiment.table("pandas")[columns]
    assert len(ours) > 5 and ours.to_csv() == theirs.to_csv()
    assert [entry.message for entry in simulation.log] == [entry.message for entry in recorded.log]
    # Control: another length.
    key = {"orbit": "duration_days", "packing": "events_per_disc"}.get(model, "duration_s")
    change = {f"model.{model}.{key}": type(MODELS[model][key])(MODELS[model][key] / 2)}
    changed = k.simulate(of_model(model), seed=3, set=change, programs=programs)
    assert changed.table("pandas")[columns].to_csv() != theirs.to_csv()


def test_nothing_is_left(tmp_path: Path, programs: Optional[str], monkeypatch: pytest.MonkeyPatch) -> None:
    programs = programs and os.path.abspath(programs)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(tempfile, "tempdir", os.fspath(tmp_path))
    simulation = k.simulate(GAS, programs=programs)
    assert simulation["/state"].array().shape == (6, 50) and simulation.coordinates == {}
    assert list(tmp_path.iterdir()) == []
    assert simulation.verify() and 'class="film"' in simulation._player(1.0)
    assert list(tmp_path.iterdir()) == []


def test_the_errors_are_those_of_a_run(tmp_path: Path, programs: Optional[str]) -> None:
    wrong = {"model": {"gas": {"particles": -4}}}
    texts = []
    for call in (lambda: k.simulate(wrong, programs=programs), lambda: k.run(wrong, output=tmp_path, programs=programs)):
        with pytest.raises(k.RunFailedError) as caught:
            call()
        texts.append(str(caught.value).partition("\n(`kinetoscope")[0])
    assert texts[0] == texts[1] and '--> manifest["model"]["gas"]["particles"]' in texts[0]
    with pytest.raises(k.RunFailedError, match="has 3 runs\n.*\nhelp: one run is executed in memory"):
        k.simulate({**GAS, "replicates": 3}, programs=programs)
    dem = {"discs": 5, "duration_s": 0.5, "steps_per_wall_contact": 1.5, "on_unstable_time_step": "warn"}
    with pytest.raises(k.RunFailedError, match="failed: Blow-up"):
        k.simulate({"model": {"dem": dem}}, programs=programs)
    with pytest.raises(k.UnknownNameError, match="did you mean `pressure.measured`"):
        k.simulate(GAS, programs=programs).metric("pressure.measure")
    with pytest.raises(k.ProgramNotFoundError):
        k.simulate(GAS, programs=tmp_path)


def test_one_program_answers_all_calls_and_a_lost_one_is_replaced(programs: Optional[str]) -> None:
    def waiting() -> List[int]:
        return [number for number in children(os.getpid()) if is_running(number)]

    first = k.simulate(GAS, programs=programs).metric("pressure.measured")
    before = waiting()
    assert len(before) >= 1
    assert [k.simulate(GAS, programs=programs).metric("pressure.measured") for _ in range(3)] == [first] * 3
    assert waiting() == before
    for number in before:
        os.kill(number, signal.SIGKILL)
    assert k.simulate(GAS, programs=programs).metric("pressure.measured") == first
    with ThreadPoolExecutor(3) as pool:
        values = list(pool.map(lambda seed: k.simulate(GAS, seed=seed, programs=programs).metric("pressure.measured"), range(6)))
    assert len(set(values)) == 6 and len(waiting()) <= 3


def test_a_program_that_is_lost_during_a_call_is_an_error(programs: Optional[str]) -> None:
    k.simulate(GAS, programs=programs)

    def kill() -> None:
        # Each new program as well: a call starts one in the place of the one that waited.
        for _ in range(2):
            time.sleep(0.7)
            for number in children(os.getpid()):
                os.kill(number, signal.SIGKILL)

    killer = threading.Thread(target=kill)
    killer.start()
    with pytest.raises(k.KinetoscopeError, match="ended with exit code -9"):
        k.simulate(LONG, programs=programs)
    killer.join()


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_a_forked_process_has_a_program_of_its_own(programs: Optional[str]) -> None:
    value = k.simulate(GAS, programs=programs).metric("pressure.measured")
    child = os.fork()
    if child == 0:
        code = 1
        try:
            code = int(k.simulate(GAS, programs=programs).metric("pressure.measured") != value)
            _simulators.end_all()
        finally:
            os._exit(code)
    assert os.waitpid(child, 0)[1] == 0
    assert k.simulate(GAS, programs=programs).metric("pressure.measured") == value


SCRIPT = """
import sys, kinetoscope as k
programs = sys.argv[2] or None
k.simulate({"model": {"gas": {"particles": 50, "duration_s": 0.02}}}, programs=programs)
print("ready", flush=True)
k.simulate(sys.argv[1], programs=programs)
"""


@pytest.mark.skipif(not os.path.isdir("/proc/self"), reason="needs /proc")
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT, signal.SIGKILL])
def test_the_program_ends_with_python(number: signal.Signals, tmp_path: Path, programs: Optional[str]) -> None:
    (tmp_path / "long.toml").write_text(LONG)
    folders: List[Any] = [tmp_path / "long.toml", os.path.abspath(programs) if programs else ""]
    environment = {**os.environ, "PYTHONPATH": os.fspath(Path(k.__file__).parent.parent)}
    command = [sys.executable, "-c", SCRIPT, *folders]
    python = subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
    try:
        assert python.stdout is not None and python.stdout.readline() == b"ready\n"
        time.sleep(0.5)
        (program,) = children(python.pid)
        assert is_running(program)
        python.send_signal(number)
        python.wait(60)
        deadline = time.monotonic() + 60
        while is_running(program):
            assert time.monotonic() < deadline, "the program goes on without Python"
            time.sleep(0.05)
    finally:
        python.kill()
        python.communicate()
