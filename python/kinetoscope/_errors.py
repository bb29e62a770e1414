"""The errors of this package: each names the cause and the next step."""

from __future__ import annotations

import difflib
from pathlib import Path
from typing import Iterable, Optional


class KinetoscopeError(Exception):
    """An error with its cause and, on a line that starts with ``help:``, the next step.

    >>> print(KinetoscopeError("no recording", "run the experiment first"))
    no recording
    help: run the experiment first
    """

    def __init__(self, message: str, help: Optional[str] = None) -> None:
        super().__init__(message)
        self.message = message
        self.help = help

    def __str__(self) -> str:
        return self.message if self.help is None else f"{self.message}\nhelp: {self.help}"


class ProgramNotFoundError(KinetoscopeError, FileNotFoundError):
    """The program ``kinetoscope`` is neither installed with this package nor on the PATH."""

    __str__ = KinetoscopeError.__str__


class RunFailedError(KinetoscopeError):
    """A manifest is wrong, or a run failed; the message is that of the program."""


class RecordingError(KinetoscopeError):
    """A recording is torn, damaged, of another schema version, or not a recording."""


class UnknownNameError(KinetoscopeError, KeyError):
    """A topic, metric, coordinate or column that does not exist; the message lists the nearest names."""

    __str__ = KinetoscopeError.__str__

    @classmethod
    def of(cls, kind: str, name: str, known: Iterable[str]) -> "UnknownNameError":
        """The error for a name, with the nearest known names.

        >>> UnknownNameError.of("topic", "/stat", ["/state", "/energy"]).help
        'did you mean `/state`?'
        >>> UnknownNameError.of("topic", "x", ["/state", "/energy"]).help
        'expected one of `/energy`, `/state`'
        """
        names = sorted(set(known))
        near = difflib.get_close_matches(name, names, n=3, cutoff=0.7)
        if near:
            help = f"did you mean {' or '.join(f'`{other}`' for other in near)}?"
        elif names:
            help = f"expected one of {', '.join(f'`{other}`' for other in names)}"
        else:
            help = f"there is no {kind}"
        return cls(f"unknown {kind} `{name}`", help)


def damaged(path: Path, what: str) -> RecordingError:
    """The error for bytes that differ from the recorded ones."""
    return RecordingError(
        f"{path} is damaged: {what}",
        "`kinetoscope verify FILE` reports what is intact; `kinetoscope run --force` records it again",
    )
