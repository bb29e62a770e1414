"""Guarantee: each check of a manifest is a test, which passes and fails as the analysis does."""

from __future__ import annotations

from pathlib import Path
from typing import List, Optional

import pytest

import kinetoscope as k

MANIFEST = """
name = "bounds"
[model.dem]
discs = 5
duration_s = 0.02
[record]
frames = 5
[[checks]]
metric = "energy.residual_relative"
minimum = -0.01
maximum = 0.01
[[checks]]
metric = "energy.kinetic"
maximum = -1.0
[[checks]]
metric = "energy.kinetic"
minimum = 0.0
"""


def options(programs: Optional[str]) -> List[str]:
    return [f"--kinetoscope-programs={Path(programs).resolve()}"] if programs else []


def test_run_checks_yields_one_test_per_check(pytester: pytest.Pytester, programs: Optional[str]) -> None:
    pytester.path.joinpath("bounds.toml").write_text(MANIFEST)
    pytester.makepyfile("import kinetoscope\ntest_bounds = kinetoscope.run_checks('bounds.toml')")
    result = pytester.runpytest_subprocess("-v", *options(programs))
    result.assert_outcomes(passed=2, failed=1)
    result.stdout.fnmatch_lines(
        [
            "*test_bounds?energy.residual_relative? PASSED*",
            "*test_bounds?energy.kinetic-1? FAILED*",
            "*test_bounds?energy.kinetic-2? PASSED*",
            "energy.kinetic: measured *, expected at most -1",
            "the recordings are in /*/bounds",
        ]
    )


def test_the_fixture_runs_an_experiment_once(pytester: pytest.Pytester, programs: Optional[str]) -> None:
    pytester.path.joinpath("bounds.toml").write_text(MANIFEST)
    pytester.makepyfile(
        """
        paths = []

        def test_first(kinetoscope_run):
            paths.append(kinetoscope_run("bounds.toml").path)
            assert kinetoscope_run("bounds.toml", seed=5).runs[0].seed == 5

        def test_second(kinetoscope_run):
            assert kinetoscope_run("bounds.toml").path == paths[0]
            assert kinetoscope_run("bounds.toml").metric("energy.kinetic") > 0
        """
    )
    pytester.runpytest_subprocess(*options(programs)).assert_outcomes(passed=2)


def test_a_manifest_without_checks_is_an_error(tmp_path: Path) -> None:
    manifest = tmp_path / "none.toml"
    manifest.write_text('name = "none"')
    with pytest.raises(k.KinetoscopeError, match="has no `\\[\\[checks\\]\\]`"):
        k.run_checks(manifest)
    with pytest.raises(k.KinetoscopeError, match="cannot read the manifest"):
        k.run_checks(tmp_path / "missing.toml")


def test_a_wrong_metric_is_one_message_without_tracebacks(pytester: pytest.Pytester, programs: Optional[str]) -> None:
    pytester.path.joinpath("bounds.toml").write_text(MANIFEST.replace("energy.residual_relative", "energy.residul_relative"))
    pytester.makepyfile("import kinetoscope\ntest_bounds = kinetoscope.run_checks('bounds.toml')")
    result = pytester.runpytest_subprocess(*options(programs))
    result.assert_outcomes(failed=3)
    result.stdout.fnmatch_lines(["`energy.residul_relative` is not a metric", "*did you mean `energy.residual_relative`?*"])
    result.stdout.no_fnmatch_line("*_programs.py*")
