"""Speed of the engine of report pages over the program on one thread: the first run of five experiments, in turn, as a table.

Usage: python3 benches/browser_speed.py PROGRAMS MODULE.wasm [--rounds N]    (program: node; PROGRAMS is the folder of run-experiment)

Each round measures every experiment once natively (the best of three processes) and once in Node, whose engine is that of Chromium (the best of three runs, as
tests/architectures/engine.mjs times them): processor time of the user, so that other load of the machine counts little. The program also compresses and writes the
recording; the engine also hashes each message. Prints medians and the range of the ratios of the rounds; exit code 1 if a median is below its bar.
"""

import argparse
import os
import re
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

REPOSITORY = Path(__file__).resolve().parents[1]
# The experiments, and the speed over the program that their engine must have.
BARS = {"first_run": 0.45, "gas_300_kelvin": 0.45, "packing_fifty_discs": 0.45, "orbit_exercise": 0.45, "dem_thousand_discs": 0.35}


def native(program, manifest):
    """The user's processor time of one run on one thread, s."""
    with tempfile.TemporaryDirectory() as folder:
        process = subprocess.Popen([program, "--quiet", "--jobs", "1", "--threads", "1", "--output", folder, manifest])
        _, status, usage = os.wait4(process.pid, 0)
    if status:
        sys.exit(f"{program} {manifest}: status {status}")
    return usage.ru_utime


def in_page(module, manifest):
    words = ["node", REPOSITORY / "tests/architectures/engine.mjs", "--time", module, manifest]
    return float(re.search(r": ([\d.]+) s", subprocess.run(words, check=True, capture_output=True, text=True).stdout)[1])


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("programs", type=Path)
    parser.add_argument("module", type=Path)
    parser.add_argument("--rounds", type=int, default=5)
    options = parser.parse_args()
    times = {name: [] for name in BARS}
    for _ in range(options.rounds):
        for name, found in times.items():
            manifest = REPOSITORY / f"experiments/{name}.toml"
            found.append((min(native(options.programs / "run-experiment", manifest) for _ in range(3)), in_page(options.module, manifest)))
    slow = 0
    print("| experiment | program, s | engine, s | speed over the program | range | bar |\n|---|---|---|---|---|---|")
    for name, found in times.items():
        ratios = [program / engine for program, engine in found]
        ratio = statistics.median(ratios)
        slow += ratio < BARS[name]
        program, engine = (statistics.median(column) for column in zip(*found))
        print(f"| `{name}` | {program:.3f} | {engine:.3f} | {ratio:.2f} | {min(ratios):.2f} to {max(ratios):.2f} | {BARS[name]} |")
    return int(slow > 0)


if __name__ == "__main__":
    sys.exit(main())
