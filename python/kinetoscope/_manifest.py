"""What `run` accepts as a manifest: a path, TOML as text, or a dict; and sweeps that are set from Python."""

from __future__ import annotations

import contextlib
import os
import re
import tempfile
from pathlib import Path
from typing import Dict, Iterable, Iterator, List, Mapping, NamedTuple, Optional, Sequence, Union

from . import _programs, _toml
from ._errors import KinetoscopeError

Manifest = Union[_programs.PathLike, Mapping[str, object]]
Sweep = Mapping[str, Union[Sequence[object], Mapping[str, object]]]
# Name of an experiment without one, which a file would name.
DEFAULT_NAME = "experiment"
# The key that names a recording, or the manifest of one, by a path relative to the manifest.
START = "start_from"


class Source(NamedTuple):
    """A manifest as a file: the name of its experiment, and where its lines are from, unless it is the user's file."""

    path: Path
    name: str
    is_file: bool
    # The lines of a manifest that is written from a dict, with the path in the dict.
    places: Optional[Dict[int, str]]

    def located(self, messages: str) -> str:
        """The messages of the program with the places in the dict or the text instead of those in a temporary file."""
        if self.is_file:
            return messages
        pattern = re.compile(re.escape(os.fspath(self.path)) + r"(?::(\d+)(?::\d+)?)?")
        return pattern.sub(lambda match: self._place(int(match[1] or 0)), messages)

    def _place(self, line: int) -> str:
        if self.places is None:
            return f"the manifest, line {line}" if line else "the manifest"
        return self.places.get(line, "manifest")


@contextlib.contextmanager
def source(manifest: Manifest, sweep: Optional[Sweep]) -> Iterator[Source]:
    """A manifest as a file, which is temporary unless it is the user's own."""
    if isinstance(manifest, Mapping):
        table, folder, stem = dict(manifest), Path.cwd(), DEFAULT_NAME
    elif _is_text(manifest):
        text = os.fspath(manifest)
        if not sweep and START not in text:
            with _written(text, None, DEFAULT_NAME) as written:
                yield written
            return
        table, folder, stem = _table(text), Path.cwd(), DEFAULT_NAME
    else:
        path = _programs.absolute(manifest)
        if path.is_dir():
            raise KinetoscopeError(f"{path} is a folder", 'name one manifest, such as `kinetoscope.run("exp.toml")`')
        table = _readable(path) or {}
        # The program reports what is wrong with a file that cannot be read.
        if not sweep or not table:
            yield Source(path, str(table.get("name") or path.stem), True, None)
            return
        folder, stem = path.parent, path.stem
    if sweep:
        table["sweep"] = {**_sweep_of(table), **{key: _axis(key, values) for key, values in sweep.items()}}
    text, places = _toml.document(_absolute(table, folder))
    with _written(text, places, stem) as written:
        yield written


@contextlib.contextmanager
def _written(text: str, places: Optional[Dict[int, str]], stem: str) -> Iterator[Source]:
    with tempfile.TemporaryDirectory(prefix="kinetoscope-") as scratch:
        path = Path(scratch) / f"{stem}.toml"
        path.write_text(text, encoding="utf-8")
        name = str((_readable(path) or {}).get("name") or stem)
        yield Source(path, name, False, places)


def _absolute(table: Mapping[str, object], folder: Path) -> Dict[str, object]:
    """The table with absolute paths of recordings and manifests to start from, which may be swept."""
    return {key: _absolute_value(key, value, folder) for key, value in table.items()}


def _absolute_value(key: str, value: object, folder: Path) -> object:
    if isinstance(value, Mapping):
        return _absolute(value, folder)
    if isinstance(value, (list, tuple)):
        return [_absolute_value(key, entry, folder) for entry in value]
    is_path = isinstance(value, str) and str(key).rpartition(".")[2] == START
    return os.path.join(folder, str(value)) if is_path else value


def _is_text(manifest: _programs.PathLike) -> bool:
    """Whether a string is TOML rather than the path of a file: it has several lines, or assigns a value and names no file."""
    if not isinstance(manifest, str):
        return False
    return "\n" in manifest or ("=" in manifest and not os.path.exists(manifest) and not manifest.endswith(".toml"))


def _readable(path: Path) -> Optional[Dict[str, object]]:
    try:
        return _toml.parsed(path.read_text(encoding="utf-8-sig"))
    except (OSError, ValueError, RecursionError):
        return None


def _table(text: str) -> Dict[str, object]:
    try:
        return _toml.parsed(text)
    except (ValueError, RecursionError) as error:
        raise KinetoscopeError(f"the manifest is not TOML: {error}", "correct this line") from error


def _axis(key: str, values: object) -> object:
    """A range as it is, and other values as a list."""
    if isinstance(values, Mapping):
        return values
    if isinstance(values, (str, bytes)) or not isinstance(values, Iterable):
        raise KinetoscopeError(
            f'`sweep["{key}"]` is {values!r}; expected a list of values or a range',
            'give a list such as [1, 2], or a range such as {"from": 1, "to": 2, "count": 5}',
        )
    return list(values)


def _sweep_of(table: Mapping[str, object]) -> Dict[str, object]:
    sweep = table.get("sweep", {})
    if not isinstance(sweep, Mapping):
        raise KinetoscopeError(
            f'`manifest["sweep"]` is {sweep!r}; expected a table of keys with their values',
            'such as {"model.gas.temperature_k": [200, 300]}',
        )
    return dict(sweep)


def overrides(values: Mapping[str, object]) -> List[str]:
    """The options for overridden keys."""
    options: List[str] = []
    for key, value in values.items():
        options += ["--set", f"{key}={_toml.literal(value)}"]
    return options

