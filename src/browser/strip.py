"""Removes the custom sections of a WebAssembly module: names, and what packages declare for JavaScript that is not used.

Usage: python3 strip.py MODULE
"""

import pathlib
import sys

HEADER = 8
CUSTOM = 0


def number(data, place):
    """An unsigned number in LEB128, and the place after it."""
    value = shift = 0
    while True:
        byte = data[place]
        place += 1
        value |= (byte & 0x7F) << shift
        shift += 7
        if byte < 0x80:
            return value, place


def stripped(data):
    kept, place = data[:HEADER], HEADER
    while place < len(data):
        size, content = number(data, place + 1)
        if data[place] != CUSTOM:
            kept += data[place:content + size]
        place = content + size
    return kept


if __name__ == "__main__":
    module = pathlib.Path(sys.argv[1])
    module.write_bytes(stripped(module.read_bytes()))
