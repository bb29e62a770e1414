"""Programs that are kept: `kinetoscope simulate` executes one manifest after the other."""

from __future__ import annotations

import atexit
import contextlib
import json
import os
import subprocess
import tempfile
import weakref
from typing import Any, Dict, List, Optional, Sequence, Tuple

from . import _programs
from ._errors import KinetoscopeError, ProgramNotFoundError


class _Simulator:
    """A program that waits for requests. It ends with its input, so also if this process is killed."""

    def __init__(self, program: str) -> None:
        self._messages = tempfile.TemporaryFile()
        try:
            # Ctrl-C in a terminal is for Python, which ends the program.
            self._process = subprocess.Popen(
                [program, "simulate"],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=self._messages,
                start_new_session=True,
            )
        except OSError as error:
            raise ProgramNotFoundError(
                f"{program} cannot be executed: {error.strerror}",
                "install a wheel or build the program for this operating system and processor",
            ) from error
        _all.add(self)

    def ask(self, words: Sequence[str]) -> Optional[Tuple[Dict[str, Any], bytes]]:
        """The answer to a request, and the recording; none if the program has ended."""
        assert self._process.stdin is not None and self._process.stdout is not None
        try:
            self._process.stdin.write(json.dumps(words).encode() + b"\n")
            self._process.stdin.flush()
            line = self._process.stdout.readline()
        except BrokenPipeError:
            return None
        if not line.endswith(b"\n"):
            return None
        answer: Dict[str, Any] = json.loads(line)
        size = int(answer.get("recording_bytes", 0))
        content = self._process.stdout.read(size)
        return (answer, content) if len(content) == size else None

    def error(self) -> KinetoscopeError:
        """Why the program has ended."""
        self._process.kill()
        self._process.wait()
        self._messages.seek(0)
        text = self._messages.read().decode("utf-8", "replace")
        self.close()
        return _programs.Finished(["simulate"], self._process.returncode, "", text).error()

    def end(self) -> None:
        """Ends the program, which has nothing to save."""
        self._process.kill()
        self._process.wait()
        self.close()

    def close(self) -> None:
        """Closes the pipes and the file of messages."""
        for pipe in (self._process.stdin, self._process.stdout, self._messages):
            if pipe is not None:
                with contextlib.suppress(OSError):
                    pipe.close()

    def forget(self) -> None:
        """Leaves the program to the process that this one was forked from."""
        self.close()
        self._process.returncode = 0


_all: "weakref.WeakSet[_Simulator]" = weakref.WeakSet()
# Programs that wait, by their file and its time of change.
_idle: Dict[Tuple[str, int], List[_Simulator]] = {}


def answer(words: Sequence[str], programs: Optional[_programs.PathLike]) -> Tuple[Dict[str, Any], bytes]:
    """The answer of a program that waits, or of a new one. Each thread has its own."""
    program = _programs.find(programs)
    idle = _idle.setdefault((program, os.stat(program).st_mtime_ns), [])
    while True:
        try:
            simulator, is_new = idle.pop(), False
        except IndexError:
            simulator, is_new = _Simulator(program), True
        try:
            found = simulator.ask(words)
        except BaseException:
            simulator.end()
            raise
        if found is not None:
            idle.append(simulator)
            return found
        error = simulator.error()
        # One that waited may have been killed meanwhile.
        if is_new:
            raise error


def forget_all() -> None:
    """Leaves the programs to the process that this one was forked from."""
    for simulator in list(_all):
        simulator.forget()
    _all.clear()
    _idle.clear()


@atexit.register
def end_all() -> None:
    """Ends the programs."""
    for simulator in list(_all):
        simulator.end()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=forget_all)
