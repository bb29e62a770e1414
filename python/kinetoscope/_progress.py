"""What a run shows while it works: one line that is replaced, or all lines of the program."""

from __future__ import annotations

import re
import sys
import time
from typing import Any, Optional

from . import _player

# Lines of `kinetoscope run`: its state every ten seconds, and one line per finished run.
STATE = re.compile(r"\d+ of \d+ runs? finished")
FINISHED = re.compile(r".+: [a-z ]+, \d+ frames?, ")
WIDTH = 100


class Progress:
    """A line with the state of the runs, in a terminal or a cell; with `verbose`, the lines of the program."""

    def __init__(self, name: str, shows_line: bool, verbose: bool) -> None:
        self._name = name
        self._shows_line = shows_line
        self._verbose = verbose
        self._state = "starting"
        self._finished = 0
        self._start = time.monotonic()
        self._cell: Any = None
        self._is_open = False

    def add(self, line: Optional[str]) -> None:
        """A line of the program, or none after a second without one."""
        if line is not None:
            if self._verbose:
                self._erase()
                print(line, file=sys.stderr, flush=True)
            if STATE.match(line):
                self._state = line
            elif FINISHED.match(line):
                self._finished += 1
                self._state = f"{self._finished} {'run' if self._finished == 1 else 'runs'} finished"
        if self._shows_line:
            self._show(f"{self._name}: {self._state}, {time.monotonic() - self._start:.0f} s"[:WIDTH])

    def end(self) -> None:
        """Removes the line from a terminal; a cell keeps the last one."""
        self._erase()

    def _show(self, text: str) -> None:
        if not _player.is_notebook():
            print(f"\r\x1b[2K{text}", end="", file=sys.stderr, flush=True)
            self._is_open = True
            return
        from IPython.display import display

        content = {"text/plain": text}
        if self._cell is None:
            self._cell = display(content, raw=True, display_id=True)  # type: ignore[no-untyped-call]
        else:
            self._cell.update(content, raw=True)

    def _erase(self) -> None:
        if self._is_open:
            print("\r\x1b[2K", end="", file=sys.stderr, flush=True)
            self._is_open = False


def of(name: str, progress: Optional[bool], verbose: bool) -> Optional[Progress]:
    """What is shown: the line by default in terminals and notebooks; none if nothing is."""
    shows_line = progress
    if shows_line is None:
        shows_line = not verbose and (_player.is_notebook() or bool(sys.stderr and sys.stderr.isatty()))
    return Progress(name, shows_line, verbose) if shows_line or verbose else None
