"""Provenance and outcome of a recording, as `src/recording/provenance.rs` defines them."""

from __future__ import annotations

import math
import re
from fractions import Fraction
from pathlib import Path
from typing import Dict, List, Mapping, NamedTuple, Optional

from ._errors import RecordingError, damaged

# Layout of recordings that this package reads; `SCHEMA_VERSION` of the recorder.
SCHEMA_VERSION = 5
PROVENANCE = "kinetoscope"
OUTCOME = "kinetoscope.outcome"
HASHES = "kinetoscope.hashes"
MERGED = "kinetoscope.merged"
OUTCOMES = ("complete", "fault", "interrupted")
MAX_STATE_COLUMNS = 64
MAX_NAME_BYTES = 64

_NUMBER = re.compile(r"\+?[0-9]{1,20}", re.ASCII)
_STORED = re.compile(r"(keyframes|from) (\+?[0-9]{1,20})", re.ASCII)
_COLUMN = re.compile(r"[A-Za-z0-9_]{1,64}", re.ASCII)
_UNIT = re.compile(r"[A-Za-z0-9/^*.-]{0,64}", re.ASCII)


class StoredFrames(NamedTuple):
    """Which frames of a run a recording holds: all from `first` on, or, as keyframes, every `distance`-th and the last one."""

    first: int
    distance: int


def check_schema(path: Path, provenance: Optional[Mapping[str, str]]) -> None:
    """Rejects a recording of another schema version, with both versions."""
    if provenance is None or "schema_version" not in provenance:
        raise damaged(path, "it has no provenance")
    version = provenance["schema_version"]
    if version == str(SCHEMA_VERSION):
        return
    is_newer = bool(_NUMBER.fullmatch(version)) and int(version) > SCHEMA_VERSION
    written_by = provenance.get("program_version", "an unknown version")
    raise RecordingError(
        f"{path} has schema version {version} (written by Kinetoscope {written_by}); "
        f"this package reads version {SCHEMA_VERSION}",
        "upgrade: `pip install --upgrade kinetoscope`" if is_newer else "record it again",
    )


def check_provenance(path: Path, provenance: Mapping[str, str]) -> None:
    """Rejects a provenance that no recording of this schema version has."""
    check_schema(path, provenance)
    for key in ("program_version", "model", "run_key", "time_unit", "playback_fps", "state_columns", "state_units"):
        if key not in provenance:
            raise damaged(path, f"its provenance has no {key}")
    if any(len(provenance[key].encode()) > MAX_NAME_BYTES for key in ("program_version", "model", "run_key")):
        raise damaged(path, f"its provenance has a name of more than {MAX_NAME_BYTES} bytes")
    if not _NUMBER.fullmatch(provenance.get("physics_version", "")):
        raise damaged(path, "its physics version is not a number")
    columns, units = provenance["state_columns"].split(","), provenance["state_units"].split(",")
    if len(columns) != len(units) or len(columns) > MAX_STATE_COLUMNS or len(set(columns)) < len(columns):
        raise damaged(path, f"its state has {len(set(columns))} columns and {len(units)} units")
    if not all(map(_COLUMN.fullmatch, columns)) or not all(map(_UNIT.fullmatch, [*units, provenance["time_unit"]])):
        raise damaged(path, "a column or a unit has other characters than those of recordings")
    playback_rate(path, provenance)
    stored_frames(path, provenance)


def playback_rate(path: Path, provenance: Mapping[str, str]) -> Fraction:
    """Frames per second of playback, exactly."""
    text = provenance["playback_fps"]
    try:
        rate = float(text)
    except ValueError:
        rate = math.nan
    # Python's numbers may contain underscores and spaces.
    if not math.isfinite(rate) or rate <= 0.0 or "_" in text or text != text.strip():
        raise damaged(path, f"playback of {text[:40]!r} frames per second")
    return Fraction(rate)


def stored_frames(path: Path, provenance: Mapping[str, str]) -> StoredFrames:
    """Which frames the file holds."""
    text = provenance.get("stored_frames")
    if text is None:
        return StoredFrames(0, 1)
    match = _STORED.fullmatch(text)
    number = int(match[2]) if match else 0
    if match is None or number >= 2**64 or (match[1] == "keyframes" and number == 0):
        raise damaged(path, "its provenance does not state which frames it has")
    return StoredFrames(0, number) if match[1] == "keyframes" else StoredFrames(number, 1)


def outcome_of(path: Path, entries: Mapping[str, str]) -> str:
    """How the run ended."""
    outcome = entries.get("outcome")
    if outcome not in OUTCOMES or (outcome == "fault" and "outcome_detail" not in entries):
        raise damaged(path, "its outcome is none that a run can have")
    return outcome


def check_hashes(path: Path, entries: Mapping[str, str]) -> None:
    """Rejects hashes of frames that are not hexadecimal."""
    text = entries.get("hashes", "")
    if len(text) % 2 or re.fullmatch("[0-9a-fA-F]*", text) is None:
        raise damaged(path, "a hash is not hexadecimal")


def check_end(path: Path, names: List[str], entries: List[Dict[str, str]]) -> None:
    """Rejects an end, given as metadata records, without an outcome or with several that differ."""
    outcomes = [outcome_of(path, entry) for name, entry in zip(names, entries) if name == OUTCOME]
    if not outcomes or names[-1] != OUTCOME or any(outcome != outcomes[0] for outcome in outcomes):
        raise damaged(path, "it has no outcome, or several")
    for name, entry in zip(names, entries):
        if name == HASHES:
            check_hashes(path, entry)
