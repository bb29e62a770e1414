#!/usr/bin/env python3
"""Does `kinetoscope check --locked` find a flipped sign, and name step, particle and field?

The script compiles a copy of the sources with one flipped sign in each of three models, and checks the quick tier of
kinetoscope.lock with it. Experiments that use the changed line must differ, with the place of the first difference; all
others must be equal.

    tests/interop/flipped_signs.py
"""

import json
import pathlib
import shutil
import subprocess
import sys

SOURCES = pathlib.Path(__file__).resolve().parents[2]
COPY = SOURCES / "target/flipped"

# File, text, what it becomes, and an experiment that uses it.
FLIPPED = [
    ("src/physics/dem/motion.rs", "let trial = dashpot - spring.stiffness * stretched;",
     "let trial = dashpot + spring.stiffness * stretched;", "experiments/dem_incline.toml"),
    ("src/physics/gas/motion.rs", "velocity[1] - twice * position[1]", "velocity[1] + twice * position[1]",
     "experiments/gas_300_kelvin.toml"),
    ("src/physics/orbit/integrators.rs", "stages: [row([]), row([0.5]),", "stages: [row([]), row([-0.5]),",
     "experiments/orbit_integrators.toml"),
]


def main():
    shutil.rmtree(COPY, ignore_errors=True)
    files = subprocess.run(["git", "ls-files", "-z"], cwd=SOURCES, check=True, capture_output=True, text=True).stdout
    for name in filter(None, files.split("\0")):
        (COPY / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(SOURCES / name, COPY / name)
    for name, old, new, _ in FLIPPED:
        text = (COPY / name).read_text()
        if text.count(old) != 1:
            sys.exit(f"{name} does not contain {old!r} once")
        (COPY / name).write_text(text.replace(old, new))
    build = ["cargo", "build", "--quiet", "--locked", "--release", "--package", "kinetoscope-program"]
    subprocess.run([*build, "--target-dir", SOURCES / "target/flipped-build"], cwd=COPY, check=True)
    program = SOURCES / "target/flipped-build/release/kinetoscope"
    checked = subprocess.run([program, "check", "--locked", "--json"], cwd=COPY, capture_output=True, text=True)
    report = {entry["manifest"]: entry for entry in json.loads(checked.stdout)["experiments"]}
    failed = checked.returncode != 4
    for *_, manifest in FLIPPED:
        findings = report[manifest]["findings"]
        place = findings[0] if findings else "equal"
        named = all(part in place for part in ("first difference in frame", "/state", "columns", "particle"))
        failed |= not named
        print(f"{manifest}: {place}")
    # Control: no changed line acts on hard discs.
    equal = [name for name in report if "/packing" in name and report[name]["equal"]]
    failed |= len(equal) != len([name for name in report if "/packing" in name])
    print(f"{sum(not entry['equal'] for entry in report.values())} of {len(report)} manifests differ; packing: {len(equal)} equal")
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
