"""Prints the sizes of recordings with all frames and with keyframes, and the times of `fill` and `zoom` relative to the run.

Usage: python3 benches/keyframes.py PATH_OF_KINETOSCOPE [DISTANCE]
"""

import math
import subprocess
import sys
import tempfile
import time
from pathlib import Path

GM_SUN = 2.9591220828559093e-4


def test_particles(number):
    """Returns the Sun and test particles on circles of 1 to 2 au."""
    radii = [1.0 + index / number for index in range(number)]
    rows = [(GM_SUN, 0.0, 0.0)] + [(0.0, radius, math.sqrt(GM_SUN / radius)) for radius in radii]
    text = "{{ gm_au3_per_day2 = {!r}, position_au = [{!r}, 0.0, 0.0], velocity_au_per_day = [0.0, {!r}, 0.0] }}"
    return ", ".join(text.format(*row) for row in rows)


MODELS = {
    "dem, 1000 discs with friction": (
        "[model.dem]\ndiscs = 1000\nfriction = 0.5\nwidth_m = 0.05\nheight_m = 0.06\nduration_s = 0.2\n",
        ["0.1174", "0.1174", "1e-4"],
    ),
    "gas, 1000 particles": (
        "[model.gas]\nparticles = 1000\nduration_s = 0.2\n",
        ["0.1174", "0.1174", "1e-4"],
    ),
    "packing, 1000 discs": (
        "[model.packing]\ndiscs = 1000\nwidth = 100.0\nheight = 100.0\nevents_per_disc = 400\n",
        ["158800", "158800", "200"],
    ),
    "orbit, 300 test particles": (
        f"[model.orbit]\nduration_days = 3650.0\ntime_step_days = 0.5\nbodies = [{test_particles(300)}]\n",
        ["1766", "1766", "1"],
    ),
}


def timed(*command):
    """Runs a command and returns its time in seconds."""
    started = time.perf_counter()
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    return time.perf_counter() - started


def measure(program, folder, model, distance, interval):
    """Returns the sizes of both recordings, and the times of run, fill and zoom: the least of three."""
    def record(kind, keep):
        manifest = folder / "m.toml"
        manifest.write_text(f"name = 'm'\nseed = 1\n{model}[record]\nframes = 2000\n{keep}")
        took = timed(program, "run", "-q", "--force", "--output", str(folder / kind), str(manifest))
        return took, next((folder / kind / "m").glob("*.mcap"))

    times = {"run": [], "fill": [], "zoom": []}
    for _ in range(3):
        took, full = record("full", "")
        times["run"].append(took)
        _, keys = record("keys", f"keep = 'keyframes'\nkeyframe_distance = {distance}\n")
        filled = folder / "filled.mcap"
        filled.unlink(missing_ok=True)
        times["fill"].append(timed(program, "fill", "-q", str(keys), "-o", str(filled)))
        assert filled.read_bytes() == full.read_bytes(), "the filled recording has other bytes"
        zoomed = folder / "zoomed.mcap"
        zoomed.unlink(missing_ok=True)
        start, end, every = interval
        arguments = ["--from", start, "--to", end, "--every", every, "-o", str(zoomed)]
        times["zoom"].append(timed(program, "zoom", "-q", str(keys), *arguments))
    return full.stat().st_size, keys.stat().st_size, {name: min(took) for name, took in times.items()}


def main():
    """Prints the table."""
    program = str(Path(sys.argv[1]).resolve())
    distance = int(sys.argv[2]) if len(sys.argv) > 2 else 200
    print("| run, 2001 frames | k | all frames, kB | keyframes, kB | ratio | fill / run | one frame, s |")
    print("|---|---|---|---|---|---|---|")
    for name, (model, interval) in MODELS.items():
        with tempfile.TemporaryDirectory() as folder:
            full, keys, times = measure(program, Path(folder), model, distance, interval)
        print(
            f"| {name} | {distance} | {full / 1e3:.0f} | {keys / 1e3:.0f} | {full / keys:.1f} "
            f"| {times['fill'] / times['run']:.2f} | {times['zoom']:.2f} |",
            flush=True,
        )


if __name__ == "__main__":
    main()
