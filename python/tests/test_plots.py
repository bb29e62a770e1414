"""Guarantee: a plot in Python is the picture of `kinetoscope plot`, and its curves are those of the metrics and channels."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Optional

import numpy as np
import pytest

import kinetoscope as k
from kinetoscope import _programs

SWEEP = 'name = "warm"\nreplicates = 2\n[model.gas]\nparticles = 50\nduration_s = 0.02\n[record]\nframes = 5\n'


@pytest.fixture(scope="module")
def warm(tmp_path_factory: pytest.TempPathFactory, programs: Optional[str]) -> k.Experiment:
    sweep = {"model.gas.temperature_k": [200, 250, 300]}
    return k.run(SWEEP, sweep=sweep, output=tmp_path_factory.mktemp("plots"), programs=programs)


def test_a_plot_is_that_of_the_command(warm: k.Experiment, tmp_path: Path) -> None:
    plot = warm.plot("pressure.measured", title="Pressure")
    plot.save(tmp_path / "python.svg")
    command = [_programs.find(warm._programs), "plot", "--quiet", "--y", "pressure.measured", "--title", "Pressure"]
    subprocess.run([*command, "--output", str(tmp_path / "command.svg"), str(warm.path)], check=True)
    assert (tmp_path / "python.svg").read_bytes() == (tmp_path / "command.svg").read_bytes()
    assert plot._repr_svg_() == plot.svg and plot.title == "Pressure"
    with pytest.raises(k.KinetoscopeError, match="python.png is not a .svg\nhelp: `plot.figure"):
        plot.save(tmp_path / "python.png")


def test_curves_are_the_metrics(warm: k.Experiment) -> None:
    points = warm.table("pandas", wide=True, by="point")
    plot = warm.plot("pressure.measured", "temperature_k")
    measured = plot.curves[0]
    np.testing.assert_array_equal(measured.x, [200, 250, 300])
    np.testing.assert_allclose(measured.y, points["pressure.measured"], rtol=1e-12)
    np.testing.assert_allclose(measured.standard_error, points["pressure.measured.standard_error"], rtol=1e-12)
    assert (plot.x_label, plot.y_label) == ("temperature (K)", "pressure.measured (N/m)")


def test_a_figure_has_the_curves(warm: k.Experiment, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("matplotlib")
    plot = warm.plot("pressure.measured")
    (axes,) = plot.figure().axes
    assert axes.get_title() == plot.title and axes.get_ylabel() == plot.y_label
    lines = [line.get_xydata() for line in axes.get_lines()]
    for curve in plot.curves:
        assert any(np.array_equal(line, np.column_stack([curve.x, curve.y])) for line in lines)
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    with pytest.raises(k.KinetoscopeError, match="`matplotlib` is not installed\nhelp: `pip install"):
        plot.figure()


def test_wrong_plots_are_errors_with_the_remedy(warm: k.Experiment) -> None:
    with pytest.raises(k.KinetoscopeError, match="is not a metric of these recordings\n.*\nhelp: "):
        warm.plot("presure")
    with pytest.raises(k.KinetoscopeError, match="a plot needs `y` or `figure`"):
        warm.plot()
    with pytest.raises(k.KinetoscopeError, match='`log` is .z.\nhelp: expected "x"'):
        warm.plot("pressure.measured", log="z")
    assert warm.plot("/pressure.measured_n_per_m", where={"temperature_k": 300}, log="y").curves
