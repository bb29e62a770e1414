"""TOML: parsing, and values of overrides."""

from __future__ import annotations

import sys
from typing import Any, Dict, Mapping

from ._errors import KinetoscopeError

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib


def parsed(text: str) -> Dict[str, Any]:
    """The table of a document."""
    return tomllib.loads(text)


def literal(value: object) -> str:
    r"""A value as TOML.

    >>> literal(1e-05), literal(True), literal("a\"b"), literal([1, 2.5]), literal({"x": 1})
    ('1e-05', 'true', '"a\\"b"', '[1, 2.5]', '{"x" = 1}')
    """
    # NumPy's scalars have `item`, which returns Python's.
    item = getattr(value, "item", None)
    if item is not None and not isinstance(value, (str, list, tuple)):
        value = item()
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


def _quoted(text: str) -> str:
    escapes = {'"': '\\"', "\\": "\\\\"}
    letters = (
        escapes.get(letter) or (f"\\u{ord(letter):04x}" if ord(letter) < 0x20 or ord(letter) == 0x7F else letter)
        for letter in text
    )
    return '"' + "".join(letters) + '"'
