"""Guarantee: a run shows its progress where it can, and its program ends with Python, so that the run can be resumed."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any, Dict, List, Optional

import pytest

import kinetoscope as k
from kinetoscope import _player, _progress

TEXT = 'name = "small"\nreplicates = 3\n[model.gas]\nparticles = 50\nduration_s = 0.02\n[record]\nframes = 5\n'
# Some minutes, with checkpoints from the first second on.
LONG = 'name = "long"\n[model.dem]\ndiscs = 2000\nduration_s = 20.0\nwidth_m = 0.2\nheight_m = 0.2\n[record]\nframes = 1000\n'
SCRIPT = "import sys, kinetoscope as k; k.run(sys.argv[1], output=sys.argv[2], programs=sys.argv[3] or None)"


def test_a_line_is_replaced_in_terminals_and_removed_at_the_end(
    tmp_path: Path, programs: Optional[str], capsys: pytest.CaptureFixture[str]
) -> None:
    run = k.run(TEXT, output=tmp_path, progress=True, programs=programs)
    shown = capsys.readouterr().err
    assert "\r\x1b[2Ksmall: 3 runs finished, 0 s" in shown.replace(", 1 s", ", 0 s") and shown.endswith("\r\x1b[2K")
    assert "\n" not in shown and len(run.runs) == 3
    # Control: nothing is shown if the messages go to a file.
    k.run(TEXT, output=tmp_path / "other", programs=programs)
    assert capsys.readouterr().err == ""


def test_verbose_prints_a_line_per_run(
    tmp_path: Path, programs: Optional[str], capsys: pytest.CaptureFixture[str]
) -> None:
    k.run(TEXT, output=tmp_path, verbose=True, programs=programs)
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 3 and all(": done, 6 frames, " in line for line in lines)


def test_a_cell_has_one_line_that_is_updated(
    tmp_path: Path, programs: Optional[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    display = pytest.importorskip("IPython.display")
    shown: List[Dict[str, str]] = []

    class Handle:
        def update(self, content: Dict[str, str], raw: bool) -> None:
            shown.append(content)

    def first(content: Dict[str, str], raw: bool, display_id: bool) -> Handle:
        assert not shown
        shown.append(content)
        return Handle()

    monkeypatch.setattr(display, "display", first)
    monkeypatch.setattr(_player, "is_notebook", lambda: True)
    k.run(TEXT, output=tmp_path, programs=programs)
    assert shown[-1]["text/plain"].startswith("small: 3 runs finished") and len(shown) >= 3


def test_states_of_long_runs_are_shown() -> None:
    line = _progress.Progress("long", False, False)
    line.add("1 of 7 runs finished, b at frame 3 of 40")
    assert line._state == "1 of 7 runs finished, b at frame 3 of 40"
    line.add("warning: something else")
    assert line._state.startswith("1 of 7")


def test_errors_are_the_same_with_progress(tmp_path: Path, programs: Optional[str]) -> None:
    wrong = TEXT.replace("50", "-50")
    texts = []
    for progress in (False, True):
        with pytest.raises(k.RunFailedError) as caught:
            k.run(wrong, output=tmp_path, progress=progress, programs=programs)
        texts.append(str(caught.value))
    assert texts[0] == texts[1]


def children(pid: int) -> List[int]:
    """Processes of the program that were started by a process."""
    found = []
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            text = stat.read_text()
        except OSError:
            continue
        name, rest = text[text.index("(") + 1 : text.rindex(")")], text[text.rindex(")") + 2 :].split()
        if name == "kinetoscope" and int(rest[1]) == pid:
            found.append(int(stat.parent.name))
    return found


def is_running(pid: int) -> bool:
    try:
        text = Path(f"/proc/{pid}/stat").read_text()
    except OSError:
        return False
    return text[text.rindex(")") + 2] != "Z"


@pytest.mark.skipif(not os.path.isdir("/proc/self"), reason="needs /proc")
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT, signal.SIGKILL])
def test_the_program_ends_with_python(number: signal.Signals, tmp_path: Path, programs: Optional[str]) -> None:
    (tmp_path / "long.toml").write_text(LONG)
    folders: List[Any] = [tmp_path / "long.toml", tmp_path / "out", os.path.abspath(programs) if programs else ""]
    environment = {**os.environ, "PYTHONPATH": os.fspath(Path(k.__file__).parent.parent)}
    python = subprocess.Popen([sys.executable, "-c", SCRIPT, *folders], env=environment, stderr=subprocess.DEVNULL)
    try:
        deadline = time.monotonic() + 60
        while not list((tmp_path / "out").glob("long/*.partial.mcap")):
            assert time.monotonic() < deadline and python.poll() is None
            time.sleep(0.05)
        (program,) = children(python.pid)
        python.send_signal(number)
        python.wait(60)
        deadline = time.monotonic() + 60
        while is_running(program):
            assert time.monotonic() < deadline, "the program goes on without Python"
            time.sleep(0.05)
    finally:
        python.kill()
        python.wait()
    # It wrote its checkpoint, so that the same call resumes the run.
    assert list((tmp_path / "out").glob("long/*.checkpoint"))
