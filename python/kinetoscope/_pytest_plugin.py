"""The plugin of pytest: the fixture `kinetoscope_run`, which runs an experiment once per session."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any, Callable, Dict, Mapping, Optional, Union

import pytest

from ._errors import KinetoscopeError
from ._experiment import Experiment
from ._launch import run
from ._programs import PathLike


def pytest_addoption(parser: pytest.Parser) -> None:
    """Adds the option that names the folder of the programs."""
    parser.getgroup("kinetoscope").addoption(
        "--kinetoscope-programs",
        metavar="FOLDER",
        help="folder of the program kinetoscope [default: that of Python's scripts, then the PATH]",
    )


@pytest.fixture(scope="session")
def _kinetoscope_experiments() -> Dict[str, Union[Experiment, KinetoscopeError]]:
    return {}


@pytest.fixture
def kinetoscope_run(
    request: pytest.FixtureRequest,
    tmp_path_factory: pytest.TempPathFactory,
    _kinetoscope_experiments: Dict[str, Union[Experiment, KinetoscopeError]],
) -> Callable[..., Experiment]:
    """Runs the experiment of a manifest, whose path is relative to the module of tests, in a temporary folder.

    `kinetoscope_run("gas.toml", seed=1, set={...})` returns a `kinetoscope.Experiment`. The same call in another test of
    the session does not run it again.
    """

    def run_once(
        manifest: PathLike, *, seed: Optional[int] = None, set: Optional[Mapping[str, object]] = None
    ) -> Experiment:
        path = Path(request.path).parent / os.fspath(manifest)
        key = repr((os.fspath(path), seed, sorted((set or {}).items(), key=lambda item: item[0])))
        if key not in _kinetoscope_experiments:
            programs: Any = request.config.getoption("--kinetoscope-programs")
            output = tmp_path_factory.mktemp("kinetoscope")
            try:
                _kinetoscope_experiments[key] = run(path, seed=seed, set=set, output=output, programs=programs)
            except KinetoscopeError as error:
                _kinetoscope_experiments[key] = error
        result = _kinetoscope_experiments[key]
        if isinstance(result, KinetoscopeError):
            raise result
        return result

    return run_once
