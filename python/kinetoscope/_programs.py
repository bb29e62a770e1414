"""Finds the program ``kinetoscope`` and runs it."""

from __future__ import annotations

import contextlib
import json
import os
import queue
import shutil
import signal
import subprocess
import sys
import sysconfig
import threading
from pathlib import Path
from typing import Any, Callable, Dict, Iterator, List, Optional, Sequence, Tuple, Union

from ._errors import KinetoscopeError, ProgramNotFoundError, RunFailedError

PathLike = Union[str, "os.PathLike[str]"]

PROGRAM = "kinetoscope"
# Looked up once: `sysconfig` initializes itself at its first use, which is not safe with several threads.
_USER_SCHEME = f"{os.name}_user"
_SCRIPT_FOLDERS = [os.path.dirname(sys.executable), sysconfig.get_path("scripts")]
if _USER_SCHEME in sysconfig.get_scheme_names():
    _SCRIPT_FOLDERS.append(sysconfig.get_path("scripts", _USER_SCHEME))
# Time for a run to write its checkpoint after an interrupt, s.
SECONDS_TO_STOP = 30.0
# Time after which a line of progress is renewed, s.
SECONDS_BETWEEN_STATES = 1.0

EXIT_OK = 0
EXIT_FAILED = 1
EXIT_USAGE = 2
EXIT_DIFFERENCE = 4
EXIT_UNREADABLE = 5


def find(programs: Optional[PathLike] = None) -> str:
    """Path of the program: in the folder ``programs``, else next to Python, in its folders of scripts, or on the PATH."""
    if programs is not None:
        found = shutil.which(PROGRAM, path=os.fspath(programs))
        if found is None:
            raise ProgramNotFoundError(
                f"there is no program `{PROGRAM}` in {os.fspath(programs)}",
                "pass the folder that contains it, such as `target/release` of a clone",
            )
        return os.path.abspath(found)
    for path in [*_SCRIPT_FOLDERS, None]:
        found = shutil.which(PROGRAM, path=path)
        if found is not None:
            return os.path.abspath(found)
    searched = ", ".join(dict.fromkeys(_SCRIPT_FOLDERS))
    raise ProgramNotFoundError(
        f"the program `{PROGRAM}` is neither in {searched} nor on the PATH",
        "`pip install --force-reinstall kinetoscope`, or a wheel that `release/build.sh` made, installs it; in a clone, run "
        "`cargo build --release` and pass `programs=\"target/release\"`",
    )


def is_installed(programs: Optional[PathLike] = None) -> bool:
    """Whether the program is found."""
    try:
        find(programs)
    except ProgramNotFoundError:
        return False
    return True


class Finished:
    """Exit code and output of the program."""

    def __init__(self, arguments: Sequence[str], code: int, output: str, messages: str) -> None:
        self.arguments = arguments
        self.code = code
        self.output = output
        self.messages = messages

    def json(self) -> Dict[str, Any]:
        """The output of ``--json``."""
        try:
            value = json.loads(self.output)
        except ValueError as error:
            raise self.error() from error
        if not isinstance(value, dict):
            raise self.error()
        return value

    def error(self) -> KinetoscopeError:
        """The error that the program reported, with its exit code."""
        text = self.messages.strip() or self.output.strip() or "no message"
        help = None
        # The program's last line of help is that of this error.
        lines = text.split("\n")
        if lines[-1].startswith("help: "):
            help, text = lines[-1][len("help: ") :], "\n".join(lines[:-1])
        if text.startswith("error: "):
            text = text[len("error: ") :]
        kind = RunFailedError if self.code in (EXIT_FAILED, EXIT_USAGE) else KinetoscopeError
        return kind(f"{text}\n(`{PROGRAM} {self.arguments[0]}` ended with exit code {self.code})", help)


def call(
    arguments: Sequence[str], programs: Optional[PathLike] = None, watch: Optional[Callable[[Optional[str]], None]] = None
) -> Finished:
    """Runs the program to its end. An interrupt of Python ends it in order, so that a later call resumes the run.

    `watch` gets each line of its messages, and none after a second without one.
    """
    command: List[str] = [find(programs), *arguments]
    try:
        child = subprocess.Popen(
            command,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            encoding="utf-8",
            errors="replace",
        )
    except OSError as error:
        raise ProgramNotFoundError(
            f"{command[0]} cannot be executed: {error.strerror}",
            "install a wheel or build the program for this operating system and processor",
        ) from error
    with child, _ended_with_parent(child):
        try:
            output, messages = child.communicate() if watch is None else _watched(child, watch)
        except BaseException:
            # Unread output would stop the program.
            _stop(child, child.communicate if watch is None else child.wait)
            raise
    return Finished(arguments, child.returncode, output, messages)


def _watched(child: "subprocess.Popen[str]", watch: Callable[[Optional[str]], None]) -> Tuple[str, str]:
    """Output and errors of a program, whose lines of messages are watched."""
    lines: "queue.Queue[Optional[str]]" = queue.Queue()
    output: List[str] = []

    def read_messages() -> None:
        assert child.stderr is not None
        for line in child.stderr:
            lines.put(line.rstrip("\n"))
        lines.put(None)

    def read_output() -> None:
        assert child.stdout is not None
        output.append(child.stdout.read())

    readers = [threading.Thread(target=read, daemon=True) for read in (read_messages, read_output)]
    for reader in readers:
        reader.start()
    messages: List[str] = []
    while True:
        try:
            line = lines.get(timeout=SECONDS_BETWEEN_STATES)
        except queue.Empty:
            watch(None)
            continue
        if line is None:
            break
        watch(line)
        # Without `--quiet`, errors come after the lines on the runs.
        if messages or line.startswith("error: "):
            messages.append(line)
    for reader in readers:
        reader.join()
    child.wait()
    return "".join(output), "\n".join(messages)


@contextlib.contextmanager
def _ended_with_parent(child: "subprocess.Popen[str]") -> Iterator[None]:
    """Ends the program in order if this process is killed meanwhile, as when a kernel is closed.

    A shell waits for a line on a pipe whose other end only this process has, and signals the program if the pipe is closed without
    one. It has a session of its own, so that Ctrl-C does not end it.
    """
    try:
        guard = subprocess.Popen(
            ["/bin/sh", "-c", 'read -r line || kill -TERM "$1"', "sh", str(child.pid)],
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
        )
    except OSError:
        # Systems without this shell.
        yield
        return
    try:
        yield
    finally:
        with contextlib.suppress(OSError):
            guard.communicate(b"\n")


def _stop(child: "subprocess.Popen[str]", wait: Callable[..., object]) -> None:
    interrupt = signal.SIGINT if os.name == "posix" else signal.SIGTERM
    child.send_signal(interrupt)
    try:
        wait(timeout=SECONDS_TO_STOP)
    except subprocess.TimeoutExpired:
        child.kill()


def absolute(path: PathLike) -> Path:
    """An absolute path, so that a name that starts with ``-`` is not read as an option."""
    return Path(os.path.abspath(os.fspath(path)))
