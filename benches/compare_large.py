"""Prints how long `compare` takes to find the first difference of two recordings of 1 GB, which is near their end.

Usage: python3 benches/compare_large.py PATH_OF_KINETOSCOPE

Two runs of the gas differ in a temperature that is set at 95 % of the duration. The time is the least of three, with the files in the
system's cache. Aim: 5 s.
"""

import subprocess
import sys
import tempfile
import time
from pathlib import Path

FRAMES = 31000
AIM_S = 5.0


def manifest(temperature_k):
    return (
        "name = 'm'\nseed = 1\n[model.gas]\nparticles = 1000\nduration_s = 0.2\n"
        f"temperature_schedule = [[0.19, {temperature_k}]]\n[record]\nframes = {FRAMES}\n"
    )


def main():
    program = sys.argv[1]
    with tempfile.TemporaryDirectory() as folder:
        folder, recordings = Path(folder), []
        for kind, temperature_k in (("one", 400.0), ("other", 401.0)):
            path = folder / f"{kind}.toml"
            path.write_text(manifest(temperature_k))
            subprocess.run([program, "run", "-q", "--output", folder / kind, path], check=True)
            recordings.append(next((folder / kind / "m").glob("*.mcap")))
        sizes = [path.stat().st_size / 1e9 for path in recordings]
        times = []
        for _ in range(3):
            started = time.perf_counter()
            compared = subprocess.run([program, "compare", *recordings], capture_output=True, text=True)
            times.append(time.perf_counter() - started)
            if compared.returncode != 4:
                sys.exit(f"compare ended with {compared.returncode}: {compared.stderr}")
    found = " ".join(compared.stderr.split())
    print(f"{sizes[0]:.2f} and {sizes[1]:.2f} GB: {min(times):.1f} s (aim {AIM_S:.0f} s)\n{found}\n{compared.stdout}")


main()
