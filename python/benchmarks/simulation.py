"""Measures `kinetoscope.simulate` with two bodies: ten years with 251 frames, read as an array, and one metric.

Usage: python simulation.py PROGRAMS [CALLS]     (the folder of the program kinetoscope)

The same through files: `kinetoscope.run` with `force=True`, its frames and its metric.
"""

from __future__ import annotations

import statistics
import sys
import tempfile
import time
from typing import Callable, List

import kinetoscope

MANIFEST = {"name": "orbit", "model": {"orbit": {"duration_days": 3652.5}}, "record": {"frames": 250}}


def in_memory(seed: int) -> float:
    """Energy drift of a simulation, whose frames are read."""
    orbit = kinetoscope.simulate(MANIFEST, seed=seed, programs=sys.argv[1])
    assert orbit["/state"].array().shape[0] == 251
    return orbit.metric("energy.drift_relative")


def with_files(folder: str) -> float:
    """The same through a recording."""
    orbit = kinetoscope.run(MANIFEST, output=folder, force=True, programs=sys.argv[1])
    assert orbit.runs[0]["/state"].array().shape[0] == 251
    return orbit.metric("energy.drift_relative")


def measure(name: str, calls: int, call: Callable[[int], float]) -> float:
    """Prints the times of calls after the first one, and returns the value."""
    value, seconds = call(0), []
    for number in range(1, calls + 1):
        start = time.perf_counter()
        call(number)
        seconds.append(time.perf_counter() - start)
    report(name, seconds)
    return value


def report(name: str, seconds: List[float]) -> None:
    """Prints the best time, the median and the longest time."""
    times = [1e3 * value for value in (min(seconds), statistics.median(seconds), max(seconds))]
    print(f"{name}: best {times[0]:.1f}, median {times[1]:.1f}, longest {times[2]:.1f} ms per call")


def main() -> None:
    """Measures both ways and compares their values."""
    calls = int(sys.argv[2]) if len(sys.argv) > 2 else 100
    value = measure("in memory", calls, in_memory)
    with tempfile.TemporaryDirectory() as folder:
        recorded = measure("with files", max(2, calls // 10), lambda _: with_files(folder))
    if value != recorded:
        sys.exit(f"the metric is {value} in memory and {recorded} from files")


if __name__ == "__main__":
    main()
