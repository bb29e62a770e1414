"""Units of the fields of messages, which end their names: `kinetic_j` is in J."""

from __future__ import annotations

from typing import Dict, Mapping, Sequence

# Ends of names, the longest first, with their units as the columns of `/state` have them. `s` and `d` are the units of time.
SUFFIXES: Mapping[str, str] = {
    "au2_per_day2": "AU^2/d^2",
    "au2_per_day": "AU^2/d",
    "au_per_day": "AU/d",
    "m2_per_s2": "m^2/s^2",
    "m_per_s": "m/s",
    "n_per_m": "N/m",
    "j_s": "J*s",
    "n_s": "N*s",
    "percent": "%",
    "days": "d",
    "ppm": "ppm",
    "rad": "rad",
    "au": "AU",
    "uj": "uJ",
    "d": "d",
    "j": "J",
    "k": "K",
    "m": "m",
    "n": "N",
    "s": "s",
}
# Fields of the gas model whose names do not end with their units: densities of the speed.
DENSITIES = ("density", "initial_distribution", "maxwell")
# The model in units of its own.
DIMENSIONLESS_MODEL = "packing"


def of_fields(model: str, names: Sequence[str], time_unit: str) -> Dict[str, str]:
    """The units: `1` for numbers and ratios, empty for the own unit of a dimensionless model."""
    return {name: _of_field(model, name, time_unit) for name in names}


def of_separation(names: Sequence[str], length_unit: str) -> Dict[str, str]:
    """The units of distances between particles, which are those of the positions."""
    return {name: length_unit if name.endswith("_distance") and "log10" not in name else "1" for name in names}


def _of_field(model: str, name: str, time_unit: str) -> str:
    if name == "time":
        return time_unit
    if name in DENSITIES and model == "gas":
        return "s/m"
    if model == DIMENSIONLESS_MODEL:
        return ""
    return next((unit for suffix, unit in SUFFIXES.items() if name.endswith(f"_{suffix}")), "1")
