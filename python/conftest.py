"""The recording that tests and doctests read: `experiments/first_run.toml`."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Dict, Optional

import pytest

import kinetoscope

EXPERIMENTS = Path(__file__).resolve().parent.parent / "experiments"

pytest_plugins = ["pytester"]


@pytest.fixture(scope="session")
def programs(request: pytest.FixtureRequest) -> Optional[str]:
    """The folder of the programs, if it is given."""
    folder: Optional[str] = request.config.getoption("--kinetoscope-programs")
    return folder


@pytest.fixture(scope="session")
def experiments() -> Path:
    """The shipped experiments."""
    return EXPERIMENTS


@pytest.fixture(scope="session")
def experiment(tmp_path_factory: pytest.TempPathFactory, programs: Optional[str]) -> kinetoscope.Experiment:
    """A copy of `first_run` in a folder whose name contains a space and umlauts."""
    folder = tmp_path_factory.mktemp("Zwölf Boxkämpfer")
    return kinetoscope.run(EXPERIMENTS / "first_run.toml", output=folder, programs=programs)


@pytest.fixture(scope="session")
def recording(experiment: kinetoscope.Experiment) -> kinetoscope.Run:
    """Its run."""
    return experiment.runs[0]


@pytest.fixture(autouse=True)
def _names_of_doctests(request: pytest.FixtureRequest, doctest_namespace: Dict[str, Any]) -> None:
    if not isinstance(request.node, pytest.DoctestItem):
        return
    experiment: kinetoscope.Experiment = request.getfixturevalue("experiment")
    doctest_namespace.update(
        kinetoscope=kinetoscope,
        experiments=EXPERIMENTS,
        experiment=experiment,
        folder=experiment.path.parent,
        programs=request.getfixturevalue("programs"),
        recording=experiment.runs[0],
    )
