"""Kinetoscope from Python: run experiments, read their recordings, test their metrics.

>>> import kinetoscope as k
>>> experiment = k.run(experiments / "first_run.toml", output=folder, programs=programs)
>>> run = experiment.runs[0]
>>> fastest = max(float(frame["vy"].max()) for frame in run["/state"])
>>> bool(run.series("/energy")["kinetic_j"].max() > 0)
True
>>> bool(run.verify())
True
"""

from ._checks import run_checks
from ._errors import (
    KinetoscopeError,
    ProgramNotFoundError,
    RecordingError,
    RunFailedError,
    UnknownNameError,
)
from ._experiment import Experiment, open
from ._frames import Frames
from ._launch import run
from ._run import Run
from ._simulation import simulate

__version__ = "0.1.0"

__all__ = [
    "Experiment",
    "Frames",
    "KinetoscopeError",
    "ProgramNotFoundError",
    "RecordingError",
    "Run",
    "RunFailedError",
    "UnknownNameError",
    "__version__",
    "open",
    "run",
    "run_checks",
    "simulate",
]
