"""The checks of a manifest as tests of pytest."""

from __future__ import annotations

import os
import sys
import tempfile
from pathlib import Path
from typing import Any, Callable, Dict, List, Mapping, Optional

from . import _toml
from ._errors import KinetoscopeError
from ._experiment import CheckResult, Experiment
from ._programs import PathLike


def run_checks(
    manifest: PathLike, *, seed: Optional[int] = None, set: Optional[Mapping[str, object]] = None
) -> Callable[..., None]:
    """A test function with one case per ``[[checks]]`` entry of a manifest, for a module of tests.

    The path is relative to the module. The experiment is run once, when the first case runs::

        test_gas = kinetoscope.run_checks("gas.toml")

    >>> test = kinetoscope.run_checks(experiments / "first_run.toml")
    >>> [case.id for case in test.pytestmark[0].args[1]]
    ['energy.residual_relative', 'energy.total_change_relative']
    """
    try:
        import pytest
    except ImportError as error:
        raise KinetoscopeError("pytest is not installed", "`pip install 'kinetoscope[pytest]'`") from error
    module = sys._getframe(1).f_globals.get("__file__")
    path = Path(os.path.dirname(os.path.abspath(module)) if module else os.getcwd()) / os.fspath(manifest)
    checks = checks_of(path)
    cases = [pytest.param(check, id=name) for check, name in zip(checks, _names(checks))]

    @pytest.mark.parametrize("kinetoscope_check", cases)
    def test(kinetoscope_run: Callable[..., Experiment], kinetoscope_check: Dict[str, Any]) -> None:
        try:
            experiment = kinetoscope_run(path, seed=seed, set=set)
            results = evaluate(experiment, kinetoscope_check)
        except KinetoscopeError as error:
            pytest.fail(str(error), pytrace=False)
        failures = [result for result in results if not result["passed"]]
        if failures:
            lines = [f"{result['subject']}: {result['finding']}" for result in failures]
            pytest.fail("\n".join([*lines, f"the recordings are in {experiment.path}"]), pytrace=False)

    return test  # type: ignore[no-any-return]


def checks_of(manifest: Path) -> List[Dict[str, Any]]:
    """The checks of a manifest."""
    try:
        table = _toml.parsed(manifest.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise KinetoscopeError(f"cannot read the manifest {manifest}: {error}", "check the path") from error
    checks: List[Dict[str, Any]] = table.get("checks", [])
    if not checks:
        raise KinetoscopeError(f"{manifest} has no `[[checks]]`", "add one, or use the fixture `kinetoscope_run`")
    return checks


def evaluate(experiment: Experiment, check: Mapping[str, Any]) -> List[CheckResult]:
    """The results of one check: one per run, mean or fit that it selects."""
    with tempfile.TemporaryDirectory(prefix="kinetoscope-") as folder:
        file = Path(folder) / "checks.toml"
        lines = "".join(f"{key} = {_toml.literal(value)}\n" for key, value in check.items())
        file.write_text(f"[[checks]]\n{lines}", encoding="utf-8")
        results: List[CheckResult] = experiment._analyze(["--checks", os.fspath(file)])["checks"]
    # Those of the file come after all others.
    return results[len(experiment.checks) :]


def _names(checks: List[Dict[str, Any]]) -> List[str]:
    """The metrics, with a number where a metric has several checks."""
    metrics = [str(check.get("metric")) for check in checks]
    names = []
    for number, metric in enumerate(metrics):
        earlier = metrics[:number].count(metric)
        names.append(f"{metric}-{earlier + 1}" if metrics.count(metric) > 1 else metric)
    return names
