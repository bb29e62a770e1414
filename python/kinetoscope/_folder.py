"""The folder of an experiment: its `experiment.toml`, and the recordings that this lists."""

from __future__ import annotations

import hashlib
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


def entries(path: Path, text: str) -> List[RunEntry]:
    """The runs of a description, in the order of the sweep."""
    try:
        return [
            RunEntry(
                # Only files of this folder.
                os.path.basename(str(entry["file"])),
                str(entry["run_key"]),
                tuple((str(key), str(value)) for key, value in entry["coordinates"]),
                int(entry["replicate"]),
            )
            for entry in _toml.parsed(text).get("runs", [])
        ]
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise damaged(path / DESCRIPTION, str(error)) from error


def listed(folder: Path) -> List[Path]:
    """The finished recordings of a folder: those that its `experiment.toml` lists, else all."""
    text = description(folder)
    if text is None:
        return sorted(path for path in folder.glob("*.mcap") if not path.name.endswith(".partial.mcap"))
    return [folder / entry.file for entry in entries(folder, text) if (folder / entry.file).is_file()]


def restored(path: Path, manifest: str, provenance: Mapping[str, str]) -> Optional[Path]:
    """The file in which `kinetoscope fill` restores a recording of keyframes: its run key is that of the manifest without them."""
    whole = re.sub(r"(?m)^(keep|keyframe_distance) = .*\n?", "", manifest)
    versions = struct.pack("<II", int(provenance["physics_version"]), int(provenance["schema_version"]))
    key = hashlib.sha256(versions + whole.encode()).hexdigest()
    name, separator, _ = path.stem.rpartition("__")
    return path.with_name(f"{name}__{key[:8]}.mcap") if separator else None


def _place(file: str) -> str:
    """A file's name without its run key, which differs between a recording of keyframes and the restored one."""
    return file.rpartition("__")[0] or file


def coordinates_of(file: str, entries: Sequence[RunEntry]) -> Dict[str, Coordinate]:
    """The coordinates of a run by the names that metrics use: the last part of a key where that is unique."""
    keys = dict.fromkeys(key for entry in entries for key, _ in entry.coordinates)
    last_parts = [_last_part(key) for key in keys]
    return {
        _last_part(key) if last_parts.count(_last_part(key)) == 1 else key: _value(key, text)
        for entry in entries
        if _place(entry.file) == _place(file)
        for key, text in entry.coordinates
    }


def _last_part(key: str) -> str:
    return key.rpartition(".")[2]


def _value(key: str, text: str) -> Coordinate:
    """A value as a number if it is written as one."""
    if key != VARIANT and text[:1] in "-0123456789":
        for kind in (int, float):
            try:
                number = kind(text)
            except ValueError:
                continue
            if math.isfinite(number) and "_" not in text:
                return number
    return text
