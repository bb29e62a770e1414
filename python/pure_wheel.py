"""Builds the reader as a pure wheel and reads recordings with it on a Python without the program.

Usage: python pure_wheel.py PROGRAMS     (the folder of the program kinetoscope, which makes the recordings)
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
import time
import venv
from pathlib import Path

HERE = Path(__file__).resolve().parent
SWEEP = 'name = "sweep"\nreplicates = 2\n[model.gas]\nparticles = 50\nduration_s = 0.02\n[record]\nframes = 5\n' + (
    '[sweep]\n"model.gas.temperature_k" = [200, 300]\n'
)
READ = """
import sys, kinetoscope as k
experiment = k.open(sys.argv[1])
run = experiment.runs[0]
assert len(experiment.runs) == 4 and run["/state"].array().shape == (6, 50)
assert len(run.series("/pressure", "pandas")) == 6 and run.coordinates == {"temperature_k": 200} and run.log
points = experiment.table("pandas", wide=True, by="point")
assert list(points["temperature_k"]) == [200, 300] and list(points["replicates"]) == [2, 2]
assert experiment.metric("pressure.measured", temperature_k=300) == points["pressure.measured"][1]
assert run.metric("pressure.second_half_over_first") > 0
for action in (lambda: k.run("sweep.toml"), lambda: experiment.plot("pressure.measured"), run.verify):
    try:
        action()
    except k.ProgramNotFoundError as error:
        assert "nor on the PATH" in str(error) and error.help
    else:
        raise AssertionError("there is a program")
(experiment.path / "metrics.json").unlink()
try:
    k.open(sys.argv[1]).metrics
except k.ProgramNotFoundError as error:
    assert str(error).startswith(str(experiment.path / "metrics.json") + " does not exist"), error
"""


def main() -> None:
    """Builds, installs and reads."""
    program = os.path.join(os.path.abspath(sys.argv[1]), "kinetoscope")
    start = time.monotonic()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "sweep.toml").write_text(SWEEP, encoding="utf-8")
        subprocess.run([program, "run", "--quiet", "--output", folder, folder / "sweep.toml"], check=True)
        subprocess.run([program, "analyze", "--quiet", folder / "sweep"], check=True)
        # A copy, because a build writes into its folder.
        shutil.copytree(HERE, folder / "source", ignore=shutil.ignore_patterns("*.egg-info", "__pycache__", "build"))
        pip = ["-m", "pip", "--quiet", "--disable-pip-version-check"]
        wheels = folder / "wheels"
        subprocess.run([sys.executable, *pip, "wheel", "--no-deps", "--wheel-dir", wheels, folder / "source"], check=True)
        (wheel,) = wheels.iterdir()
        if not wheel.name.endswith("-py3-none-any.whl"):
            sys.exit(f"{wheel.name} is not a wheel for all systems")
        venv.create(folder / "fresh", with_pip=True)
        python = folder / "fresh" / "bin" / "python"
        subprocess.run([python, *pip, "install", f"{wheel}[pandas]"], check=True)
        subprocess.run([python, "-c", READ, folder / "sweep"], check=True, env={"PATH": ""}, cwd=folder)
        size = wheel.stat().st_size
    print(f"{wheel.name}: {size} bytes; frames, tables and results read without the program, {time.monotonic() - start:.1f} s")


if __name__ == "__main__":
    main()
