"""Measures the iteration over `/state` of a recording of 1 GB against the bare mcap reader, and its peak memory.

Usage: python iteration.py PROGRAMS [GIGABYTES]     (the folder of the program kinetoscope)

Each reader reads the same file in a process of its own, alternately; the file is in the page cache. `bare` iterates over the
messages with `mcap.reader` and neither checks nor decodes them; `bare with checksums` checks them. Kinetoscope checks all
checksums, decodes, and returns arrays that may be kept. The recording is made in a temporary folder and removed.

Two cores that other work shared (load 7), Python 3.11, mcap 1.6, 0.99 GB (2026-11): 287 MB/s of states with a peak of 59 MB, 1.00 of
the speed of `bare` and 1.17 of that of `bare with checksums` (medians of 7 rounds).
"""

from __future__ import annotations

import resource
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Dict, List, Tuple

from mcap.reader import make_reader

import kinetoscope

ROUNDS = 7
READERS = ("kinetoscope", "bare", "bare with checksums")
# A gas of 10,000 particles: 320 kB per frame in memory and 221 kB in the file.
MANIFEST = """
name = "gigabyte"
[model.gas]
particles = 10000
duration_s = 0.02
[record]
frames = {frames}
channels = ["state"]
"""
FRAMES_PER_GIGABYTE = 4530


def read(reader: str, path: str) -> int:
    """Reads all states, and returns their bytes."""
    if reader == "kinetoscope":
        return sum(frame.nbytes for frame in kinetoscope.Run(path)["/state"])
    with open(path, "rb") as stream:
        messages = make_reader(stream, validate_crcs=reader != "bare").iter_messages(topics=["/state"])
        return sum(len(message.data) for _, _, message in messages)


def measure(reader: str, path: Path) -> Tuple[float, float, int]:
    """Seconds, peak memory in MB, and bytes, of a process of its own."""
    command = [sys.executable, __file__, "--read", reader, str(path)]
    output = subprocess.run(command, check=True, capture_output=True, text=True).stdout.split()
    return float(output[0]), float(output[1]), int(output[2])


def main() -> None:
    """Records, measures and prints."""
    frames = round(FRAMES_PER_GIGABYTE * float(sys.argv[2] if len(sys.argv) > 2 else 1))
    with tempfile.TemporaryDirectory() as folder:
        manifest = Path(folder) / "gigabyte.toml"
        manifest.write_text(MANIFEST.format(frames=frames), encoding="utf-8")
        path = kinetoscope.run(manifest, output=folder, programs=sys.argv[1]).runs[0].path
        print(f"{path.stat().st_size / 1e9:.2f} GB, {frames + 1} frames")
        seconds: Dict[str, List[float]] = {reader: [] for reader in READERS}
        peaks: Dict[str, float] = dict.fromkeys(READERS, 0.0)
        size = 0
        for _ in range(ROUNDS):
            for reader in READERS:
                time_s, peak, size = measure(reader, path)
                seconds[reader].append(time_s)
                peaks[reader] = max(peaks[reader], peak)
    for reader in READERS:
        best, middle = min(seconds[reader]), statistics.median(seconds[reader])
        print(f"{reader}: median {size / middle / 1e6:.0f}, best {size / best / 1e6:.0f} MB/s, peak {peaks[reader]:.0f} MB")
    for reader in READERS[1:]:
        ratios = [bare / ours for bare, ours in zip(seconds[reader], seconds["kinetoscope"])]
        best = min(seconds[reader]) / min(seconds["kinetoscope"])
        print(f"speed over {reader}: median {statistics.median(ratios):.2f}, best over best {best:.2f}")
    if peaks["kinetoscope"] > 200:
        sys.exit("the peak memory exceeds 200 MB")


if __name__ == "__main__":
    if sys.argv[1] == "--read":
        start = time.perf_counter()
        count = read(sys.argv[2], sys.argv[3])
        elapsed = time.perf_counter() - start
        # Linux counts in KiB.
        print(elapsed, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 / 1e6, count)
    else:
        main()
