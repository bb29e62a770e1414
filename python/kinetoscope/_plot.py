"""Plots of an experiment: the picture that the program draws, with its curves as arrays."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any, List, Mapping, NamedTuple, Optional, Sequence, Tuple

import numpy as np
import numpy.typing as npt

from . import _programs, _toml
from ._errors import KinetoscopeError

if TYPE_CHECKING:
    import matplotlib.axes
    import matplotlib.figure

# Points up to this number are marked, as points with errors are.
MOST_MARKED = 60
THEORY = "theory"


class Curve(NamedTuple):
    """One curve of a plot; the name of a single one is empty, and errors that are not known are NaN."""

    name: str
    style: str
    x: npt.NDArray[np.float64]
    y: npt.NDArray[np.float64]
    standard_error: npt.NDArray[np.float64]


class Plot:
    """A plot: its picture as SVG, which cells of a notebook display, and its curves.

    >>> plot = experiment.plot("/energy.kinetic_j")
    >>> plot.title, plot.x_label, plot.y_label
    ('Kinetic energy against time', 'time (s)', '/energy.kinetic_j (J)')
    >>> len(plot.curves), len(plot.curves[0].x)
    (1, 251)
    """

    def __init__(self, svg: str, result: Mapping[str, Any]) -> None:
        self.svg: str = svg
        self.title: str = str(result["title"])
        self.x_label: str = _label(result["x"])
        self.y_label: str = _label(result["y"])
        self.remark: str = str(result.get("remark") or "")
        self.curves: Tuple[Curve, ...] = tuple(map(_curve, result["curves"]))

    def __repr__(self) -> str:
        return f"<plot {self.title}: {len(self.curves)} curves>"

    def _repr_svg_(self) -> str:
        return self.svg

    def save(self, path: _programs.PathLike) -> None:
        """Writes the picture to a file; for other formats than SVG, save the figure."""
        if Path(path).suffix != ".svg":
            raise KinetoscopeError(
                f"{os.fspath(path)} is not a .svg", "`plot.figure().savefig(…)` writes other formats, or `kinetoscope plot`"
            )
        Path(path).write_text(self.svg, encoding="utf-8")

    def figure(self) -> "matplotlib.figure.Figure":
        """The curves as a figure of Matplotlib, with linear axes."""
        try:
            from matplotlib.figure import Figure
        except ImportError as error:
            raise KinetoscopeError(
                "the package `matplotlib` is not installed", "`pip install 'kinetoscope[matplotlib]'`"
            ) from error
        figure = Figure(layout="constrained")
        axes = figure.add_subplot()
        for curve in self.curves:
            _draw(axes, curve)
        axes.set_title(self.title)
        axes.set_xlabel(self.x_label)
        axes.set_ylabel(self.y_label)
        if len(self.curves) > 1:
            axes.legend()
        return figure


def _draw(axes: "matplotlib.axes.Axes", curve: Curve) -> None:
    if curve.style == THEORY:
        axes.plot(curve.x, curve.y, "--", label=curve.name)
    elif np.isfinite(curve.standard_error).any():
        axes.errorbar(curve.x, curve.y, curve.standard_error, fmt="o", capsize=3, label=curve.name)
    else:
        axes.plot(curve.x, curve.y, "o-" if len(curve.x) <= MOST_MARKED else "-", markersize=4, label=curve.name)


def _label(axis: Mapping[str, Any]) -> str:
    unit = axis.get("unit")
    return f"{axis['name']} ({unit})" if unit else str(axis["name"])


def _curve(curve: Mapping[str, Any]) -> Curve:
    def column(name: str) -> npt.NDArray[np.float64]:
        values = (point[name] for point in curve["points"])
        return np.array([np.nan if value is None else value for value in values], np.float64)

    return Curve(str(curve["name"]), str(curve["style"]), column("x"), column("y"), column("standard_error"))


def options(
    y: Sequence[str], x: str, where: Mapping[str, object], figure: str, title: str, log: Sequence[str]
) -> List[str]:
    """The options of `kinetoscope plot`."""
    chosen: List[str] = []
    for name in y:
        chosen += ["--y", name]
    for option, text in (("--x", x), ("--figure", figure), ("--title", title)):
        if text:
            chosen += [option, text]
    for key, value in where.items():
        chosen += ["--where", f"{key}={value if isinstance(value, str) else _toml.literal(value)}"]
    for axis in log:
        if axis not in ("x", "y"):
            raise KinetoscopeError(f"`log` is {axis!r}", 'expected "x", "y" or "xy"')
        chosen.append(f"--log-{axis}")
    return chosen


def draw(chosen: Sequence[str], path: Path, programs: Optional[_programs.PathLike]) -> Plot:
    """Draws a plot of the recordings in a folder."""
    with tempfile.TemporaryDirectory(prefix="kinetoscope-") as folder:
        picture = Path(folder) / "plot.svg"
        arguments = ["plot", "--json", "--quiet", "--output", os.fspath(picture), *chosen, os.fspath(path)]
        finished = _programs.call(arguments, programs)
        if finished.code != _programs.EXIT_OK:
            raise finished.error()
        return Plot(picture.read_text(encoding="utf-8"), finished.json()["plot"])
