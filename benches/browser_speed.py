"""Speed of the engine of report pages over the program on one thread: five shipped experiments, in turn, as a table.

Usage: python3 benches/browser_speed.py PROGRAMS MODULE.wasm [--rounds N]    (program: node; PROGRAMS is the folder of run-experiment)

Each round measures every experiment once natively (the best of three processes) and once in Node, whose engine is that of Chromium (the best of three runs, as
tests/architectures/engine.mjs times them): processor time of the user, so that other load of the machine counts little. Each experiment is measured as it is
shipped, where the start of the program and the compiler of the browser count for runs of a few milliseconds, and with a longer duration but as many frames. The program
also compresses and writes the recording; the engine also hashes each message. Prints medians and the range of the ratios of the rounds; exit code 1 if the median of a long run is below its bar.
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
# The experiments: what makes them longer, and the speed over the program that the engine must have.
CASES = {
    "first_run": ("duration_s = 0.4", "duration_s = 4.0", 0.45),
    "gas_300_kelvin": ("duration_s = 0.02", "duration_s = 0.2", 0.45),
    "packing_fifty_discs": ("events_per_disc = 100", "events_per_disc = 5000", 0.45),
    "orbit_exercise": ("duration_days = 365.25", "duration_days = 730500.0", 0.45),
    "dem_thousand_discs": ("duration_s = 0.5", "duration_s = 1.0", 0.35),
}


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
    slow = 0
    with tempfile.TemporaryDirectory() as folder:
        times = {}
        for name, (old, new, bar) in CASES.items():
            shipped = REPOSITORY / f"experiments/{name}.toml"
            longer = Path(folder) / shipped.name
            longer.write_text(shipped.read_text().replace(old, new))
            times[name, "as shipped", None] = (shipped, [])
            times[name, f"`{new}`", bar] = (longer, [])
        for _ in range(options.rounds):
            for manifest, found in times.values():
                found.append((min(native(options.programs / "run-experiment", manifest) for _ in range(3)), in_page(options.module, manifest)))
    print("| experiment | duration | program, s | engine, s | speed over the program | range | bar |\n|---|---|---|---|---|---|---|")
    for (name, duration, bar), (_, found) in times.items():
        ratios = [program / engine for program, engine in found]
        ratio = statistics.median(ratios)
        slow += bar is not None and ratio < bar
        program, engine = (statistics.median(column) for column in zip(*found))
        print(f"| `{name}` | {duration} | {program:.3f} | {engine:.3f} | {ratio:.2f} | {min(ratios):.2f} to {max(ratios):.2f} | {bar or ''} |")
    return int(slow > 0)


if __name__ == "__main__":
    sys.exit(main())
