"""Guarantee: the Python code in the README and in the book runs as written."""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import Any, Callable, Dict, List, Optional

import pytest

import kinetoscope as k
from kinetoscope import _player

ROOT = Path(__file__).resolve().parent.parent.parent
BLOCK = re.compile(r"^```python\n(.*?)^```$", re.MULTILINE | re.DOTALL)


@pytest.mark.parametrize("document", ["README.md", "book/src/use/python.md"])
def test_code_of_the_documents_runs(
    document: str, experiments: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, programs: Optional[str]
) -> None:
    shown: List[str] = []
    monkeypatch.setattr(_player, "display", lambda page, height: shown.append(page))
    if programs:
        monkeypatch.setenv("PATH", os.path.abspath(programs), prepend=os.pathsep)
    (tmp_path / "experiments").symlink_to(experiments)
    monkeypatch.chdir(tmp_path)
    blocks = BLOCK.findall((ROOT / document).read_text(encoding="utf-8"))
    assert blocks, "the document has no Python code"
    names: Dict[str, Any] = {"k": k}
    for block in blocks:
        exec(compile(block, document, "exec"), names)
    tests: Dict[str, Callable[..., None]] = {
        name: value for name, value in names.items() if name.startswith("test_") and not hasattr(value, "pytestmark")
    }
    for test in tests.values():
        test(k.run)
    assert all('class="film"' in page for page in shown)


def test_code_of_the_format_joins_states_and_particles(
    recording: k.Run, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (block,) = BLOCK.findall((ROOT / "recordings/README.md").read_text(encoding="utf-8"))
    monkeypatch.setattr("sys.argv", ["", str(recording.path)])
    exec(compile(block, "recordings/README.md", "exec"), {})
    printed = [line.split() for line in capsys.readouterr().out.splitlines()]
    states = recording["/state"]
    expected = [float((0.5 * state["mass"] * (state["vx"] ** 2 + state["vy"] ** 2)).mean()) for state in states]
    assert [float(line[2]) for line in printed] == expected and len(set(expected)) > 100
    assert [float(line[0]) for line in printed] == list(states.times)
