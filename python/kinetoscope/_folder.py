"""The folder of an experiment: its `experiment.toml`, and the recordings that this lists."""

from __future__ import annotations

import functools
import hashlib
import json
import math
import os
import re
import struct
from pathlib import Path
from typing import Dict, List, Mapping, NamedTuple, Optional, Sequence, Tuple, Union

from . import _toml
from ._errors import damaged

DESCRIPTION = "experiment.toml"
# The key of a sweep's named variants, whose values are texts.
VARIANT = "variant"
# A run as the program writes it, if no text needs an escape.
_WRITTEN_RUN = re.compile(
    r'^\[\[runs\]\]\nfile = "([^"\\\n]*)"\nrun_key = "([0-9a-f]{64})"\n'
    r'coordinates = (\[(?:\["[^"\\\n]*", "[^"\\\n]*"\](?:, )?)*\])\nreplicate = (\d+)$',
    re.MULTILINE,
)
# A value of a swept key.
Coordinate = Union[int, float, str]


class RunEntry(NamedTuple):
    """A run that the folder describes: its file, its run key, its keys of the sweep with their values, and its replicate."""

    file: str
    run_key: str
    coordinates: Tuple[Tuple[str, str], ...]
    replicate: int


def description(path: Path) -> Optional[str]:
    """The text of the folder's `experiment.toml`, which lists its recordings; none for a file, or without it."""
    try:
        return (path / DESCRIPTION).read_text(encoding="utf-8")
    except (OSError, ValueError):
        return None


@functools.lru_cache(maxsize=4)
def entries(path: Path, text: str) -> Tuple[RunEntry, ...]:
    """The runs of a description, in the order of the sweep."""
    found = _WRITTEN_RUN.findall(text)
    # The parser of TOML takes a second for some thousand runs.
    if found and len(found) == text.count("[[runs]]"):
        return tuple(
            RunEntry(os.path.basename(file), key, tuple((one, value) for one, value in json.loads(places)), int(replicate))
            for file, key, places, replicate in found
        )
    try:
        return tuple(
            RunEntry(
                # Only files of this folder.
                os.path.basename(str(entry["file"])),
                str(entry["run_key"]),
                tuple((str(key), str(value)) for key, value in entry["coordinates"]),
                int(entry["replicate"]),
            )
            for entry in _toml.parsed(text).get("runs", [])
        )
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise damaged(path / DESCRIPTION, str(error)) from error


def listed(folder: Path) -> List[Path]:
    """The finished recordings of a folder: those that its `experiment.toml` lists, else all."""
    text = description(folder)
    if text is None:
        return sorted(path for path in folder.glob("*.mcap") if not path.name.endswith(".partial.mcap"))
    present = set(os.listdir(folder))
    return [folder / entry.file for entry in entries(folder, text) if entry.file in present]


def restored(path: Path, manifest: str, provenance: Mapping[str, str]) -> Optional[Path]:
    """The file in which `kinetoscope fill` restores a recording of keyframes: its run key is that of the manifest without them."""
    whole = re.sub(r"(?m)^(keep|keyframe_distance) = .*\n?", "", manifest)
    versions = struct.pack("<II", int(provenance["physics_version"]), int(provenance["schema_version"]))
    key = hashlib.sha256(versions + whole.encode()).hexdigest()
    name, separator, _ = path.stem.rpartition("__")
    return path.with_name(f"{name}__{key[:8]}.mcap") if separator else None


def place(file: str) -> str:
    """A file's name without its run key, which differs between a recording of keyframes and the restored one."""
    return file.rpartition("__")[0] or file


def coordinates_of(file: str, path: Path, text: Optional[str]) -> Dict[str, Coordinate]:
    """The coordinates of a run by the names that metrics use: the last part of a key where that is unique."""
    return dict(_coordinates_by_place(path, text).get(place(file), {})) if text is not None else {}


@functools.lru_cache(maxsize=4)
def _coordinates_by_place(path: Path, text: str) -> Dict[str, Dict[str, Coordinate]]:
    runs = entries(path, text)
    keys = dict.fromkeys(key for entry in runs for key, _ in entry.coordinates)
    last_parts = [_last_part(key) for key in keys]
    names = {key: last if last_parts.count(last) == 1 else key for key, last in zip(keys, last_parts)}
    return {
        place(entry.file): {names[key]: _value(key, text) for key, text in entry.coordinates} for entry in runs
    }


def _last_part(key: str) -> str:
    return key.rpartition(".")[2]


def _value(key: str, text: str) -> Coordinate:
    """A value as a number if it is written as one."""
    value = None if key == VARIANT else value_of(text)
    return text if value is None else value


def value_of(text: str) -> Optional[Coordinate]:
    """A number if a text is written as one, else the text; none if it is empty."""
    if text[:1] in "-0123456789":
        for kind in (int, float):
            try:
                number = kind(text)
            except ValueError:
                continue
            if math.isfinite(number) and "_" not in text:
                return number
    return text or None
