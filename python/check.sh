#!/usr/bin/env bash
# Checks the Python package with the programs of a release build: types, doctests, tests, notebooks, the benchmarks in short, and the pure wheel.
# With DAMAGE=full, the tests read every damaged summary and 5,000 changed recordings instead of a sample.
# Usage: python/check.sh PROGRAMS [VENV]     (the folder of the program kinetoscope; the folder of a new environment)
set -euo pipefail
programs=$(realpath "$1")
environment=$(realpath --canonicalize-missing "${2:-"$(dirname "$0")/../target/python"}")
cd "$(dirname "$0")"

python3 -m venv "$environment"
"$environment/bin/pip" install --quiet --disable-pip-version-check --editable '.[test]'
"$environment/bin/mypy" --cache-dir "$environment/mypy" kinetoscope tests benchmarks notebooks conftest.py pure_wheel.py
"$environment/bin/pytest" --quiet -o cache_dir="$environment/pytest" --kinetoscope-programs="$programs"
"$environment/bin/python" notebooks/execute.py "$programs"
"$environment/bin/python" benchmarks/iteration.py "$programs" 0.02
"$environment/bin/python" benchmarks/simulation.py "$programs" 20
"$environment/bin/python" pure_wheel.py "$programs"
