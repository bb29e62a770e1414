"""TOML: parsing, and values of overrides."""

from __future__ import annotations

import re
import sys
from typing import Any, Dict, List, Mapping, Sequence, Tuple, Union

from ._errors import KinetoscopeError

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib


# A value of a manifest; Python's readers of TOML know dates as well, which no manifest has.
Value = Union[str, int, float, bool, List["Value"], Dict[str, "Value"]]


def parsed(text: str) -> Dict[str, Any]:
    """The table of a document."""
    return tomllib.loads(text)


def literal(value: object) -> str:
    r"""A value as TOML.

    >>> literal(1e-05), literal(True), literal("a\"b"), literal([1, 2.5]), literal({"x": 1})
    ('1e-05', 'true', '"a\\"b"', '[1, 2.5]', '{"x" = 1}')
    """
    # NumPy's scalars and arrays have `tolist`, which returns Python's.
    tolist = getattr(value, "tolist", None)
    if tolist is not None:
        value = tolist()
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (int, float)):
        return repr(value)
    if isinstance(value, str):
        return _quoted(value)
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(literal(entry) for entry in value) + "]"
    if isinstance(value, Mapping):
        entries = (f"{_quoted(str(key))} = {literal(entry)}" for key, entry in value.items())
        return "{" + ", ".join(entries) + "}"
    raise KinetoscopeError(
        f"{value!r} is not a value of a manifest", "expected a number, a text, a truth value, a list or a table"
    )


def document(table: Mapping[str, object]) -> Tuple[str, Dict[int, str]]:
    r"""A table as a document, and for each line the value's place in the table.

    >>> text, places = document({"name": "a", "model": {"gas": {"particles": 5}}})
    >>> text, places[3]
    ('name = "a"\n[model.gas]\nparticles = 5\n', 'manifest["model"]["gas"]["particles"]')
    """
    lines: List[str] = []
    places: Dict[int, str] = {}
    _add_table(table, (), lines, places)
    return "\n".join(lines) + "\n", places


def _add_table(
    table: Mapping[str, object], path: Tuple[Union[str, int], ...], lines: List[str], places: Dict[int, str]
) -> None:
    """Adds the values of a table, then its tables, each under a header of its own."""
    inner = {}
    for key, value in table.items():
        if not isinstance(key, str):
            raise KinetoscopeError(f"the key {key!r} in `{_place(path)}` is not a text", "write it in quotes")
        if isinstance(value, Mapping) or _is_list_of_tables(value):
            inner[key] = value
            continue
        try:
            lines.append(f"{_key(key)} = {literal(value)}")
        except KinetoscopeError as error:
            raise KinetoscopeError(f"`{_place((*path, key))}`: {error.message}", error.help) from error
        places[len(lines)] = _place((*path, key))
    for key, value in inner.items():
        own = (*path, key)
        header = ".".join(_key(part) for part in own if isinstance(part, str))
        if isinstance(value, Mapping):
            # A header of its own only where there are values or nothing else.
            if not value or not all(isinstance(entry, Mapping) and entry for entry in value.values()):
                lines.append(f"[{header}]")
                places[len(lines)] = _place(own)
            _add_table(value, own, lines, places)
            continue
        assert isinstance(value, (list, tuple))
        for number, entry in enumerate(value):
            lines.append(f"[[{header}]]")
            places[len(lines)] = _place((*own, number))
            _add_table(entry, (*own, number), lines, places)


def _is_list_of_tables(value: object) -> bool:
    return isinstance(value, (list, tuple)) and bool(value) and all(isinstance(entry, Mapping) for entry in value)


def _place(path: Sequence[Union[str, int]]) -> str:
    return "manifest" + "".join(f'["{part}"]' if isinstance(part, str) else f"[{part}]" for part in path)


def _key(text: str) -> str:
    return text if re.fullmatch("[A-Za-z0-9_-]+", text) else _quoted(text)


def _quoted(text: str) -> str:
    escapes = {'"': '\\"', "\\": "\\\\"}
    letters = (
        escapes.get(letter) or (f"\\u{ord(letter):04x}" if ord(letter) < 0x20 or ord(letter) == 0x7F else letter)
        for letter in text
    )
    return '"' + "".join(letters) + '"'
