"""Where the report draws particles between its frames, against runs that are recorded ten times as densely.

Usage: python tests/pages/paths_are_true.py PROGRAMS RECORDINGS [NAME ...]    (package: websockets; program: chromium)

PROGRAMS: the folder of run-experiment and kinetoscope. RECORDINGS: the folder of the analyzed experiments. For each of them, the first and the last run that its report
plays are recorded again, and their states are exported as tables. Prints the largest distance of a drawn particle from its place in these tables, in percent of the
picture's width: at any instant, and on the parts of its path that are drawn. Exit code 1 if a distance on drawn parts is larger than MOST_PERCENT; for models without
paths, at any instant.
Control: the chords between the frames, in place of the drawn parts, are farther away.
"""

import csv
import json
import math
import re
import subprocess
import sys
import tempfile
from bisect import bisect_right
from pathlib import Path

from chromium import Browser

EXPERIMENTS = Path(__file__).resolve().parents[2] / "experiments"
# Every experiment with paths, and two whose discs touch.
NAMES = sorted(path.stem for path in EXPERIMENTS.glob("orbit_*.toml")) + ["dem_newtons_cradle", "dem_incline"]
DENSER = 10
MOST_PERCENT = 0.5

# The frames of a run, and which parts of the paths of its first particles are drawn.
FRAMES = """(async () => {
  await replay.ready;
  await replay.second?.ready;
  await replay.select(%d);
  // The recorded positions are those of the fixed frame.
  const rotating = document.querySelector(".rotating");
  if (rotating.checked) rotating.click();
  const frames = [];
  for (let frame = 0; frame < replay.frames; frame++) {
    replay.show(frame);
    frames.push([replay.time, replay.positions()]);
  }
  const [x0, , x1] = replay.view, drawn = replay.film.paths?.map((parts) => parts.map((part) => Boolean(part)));
  return { file: replay.file, frames, width: x1 - x0, drawn };
})()"""
INSTANTS = """(async () => {
  const found = [];
  for (const time of %s) {
    await replay.seek(time, replay.file);
    found.push(replay.positions());
  }
  return found;
})()"""
RUNS = "document.querySelectorAll('script.film').length"


def called(*words):
    """What a program prints if it fails."""
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True)
    return "" if done.returncode == 0 else f"{' '.join(map(str, words))} failed: {done.stdout}{done.stderr}"


def record(programs, name, frames, folder, *more):
    """Records an experiment with this number of frames, or one per step if there are fewer steps."""
    settings = [*more, "--set", "replicates=1", "--output", folder, EXPERIMENTS / f"{name}.toml"]
    failure = called(programs / "run-experiment", "--quiet", "--set", f"record.frames={frames}", *settings)
    if steps := re.search(r"the run has only (\d+) steps", failure):
        failure = called(programs / "run-experiment", "--quiet", "--set", f"record.frames={steps[1]}", *settings)
    if failure:
        sys.exit(failure)


def without_key(file):
    """The name of a recording without the key of its inputs, which the number of frames changes."""
    return file.rsplit("__", 1)[0]


def truth(programs, name, frames, file, folder, *more):
    """Time and positions of every particle in each frame of the dense run."""
    if not (folder / name).exists():
        record(programs, name, frames, folder, *more)
    (recording,) = (path for path in (folder / name).glob("*.mcap") if without_key(path.name) == without_key(file))
    tables = folder / name / recording.stem
    if failure := called(programs / "kinetoscope", "export", "--quiet", "--format", "csv", "--output", tables, recording):
        sys.exit(failure)
    (table,) = tables.rglob("state.csv")
    instants = {}
    with open(table, newline="") as lines:
        rows = csv.reader(lines)
        # Coordinates of the sweep come before the frame, and names of columns end with their units.
        columns = [column.split("_")[0] for column in next(rows)]
        time, particle, x, y = (columns.index(column, columns.index("frame")) for column in ("time", "particle", "x", "y"))
        for row in rows:
            instants.setdefault(float(row[time]), {})[int(row[particle])] = (float(row[x]), float(row[y]))
    return instants


def chord(frames, place, time, number):
    """The place of a particle on the line between two frames."""
    (t0, before), (t1, after) = frames[place], frames[place + 1]
    part = (time - t0) / (t1 - t0)
    one, other = (next(entry for entry in entries if entry[0] == number) for entries in (before, after))
    return [one[axis] + part * (other[axis] - one[axis]) for axis in (1, 2)]


def distances(seen, shown, instants):
    """The largest distances, in percent of the width: anywhere, on drawn parts, and of the chords of these."""
    times = [time for time, _ in seen["frames"]]
    anywhere = on_path = of_chord = 0.0
    for (time, places), drawn in zip(instants.items(), shown):
        frame = min(bisect_right(times, time) - 1, len(times) - 2)
        for number, x, y in drawn:
            true_x, true_y = places[number]
            percent = 100 * math.hypot(x - true_x, y - true_y) / seen["width"]
            anywhere = max(anywhere, percent)
            if seen.get("drawn") and number < len(seen["drawn"]) and seen["drawn"][number][frame]:
                on_path = max(on_path, percent)
                x, y = chord(seen["frames"], frame, time, number)
                of_chord = max(of_chord, 100 * math.hypot(x - true_x, y - true_y) / seen["width"])
    return anywhere, on_path, of_chord


def main(programs, recordings, names):
    worst, worst_chord = 0.0, 0.0
    with tempfile.TemporaryDirectory() as folder, Browser(folder) as browser:
        folder = Path(folder)
        for name in names:
            browser.open((recordings / name / "report.html").resolve().as_uri(), (1280, 800))
            runs = browser.value(RUNS)
            for run in sorted({0, runs - 1}):
                seen = browser.value(FRAMES % run)
                instants = truth(programs, name, DENSER * (len(seen["frames"]) - 1), seen["file"], folder)
                shown = browser.value(INSTANTS % json.dumps(list(instants)))
                anywhere, on_path, of_chord = distances(seen, shown, instants)
                parts = sum(map(sum, seen.get("drawn") or []))
                print(f"{without_key(seen['file'])}: {len(instants)} instants of {len(seen['frames'])} frames; {anywhere:.3f} % anywhere, "
                      f"{on_path:.3f} % on {parts} drawn parts, {of_chord:.3f} % for their chords", flush=True)
                # Where no model's paths are drawn, a particle must be true at any instant.
                worst = max(worst, anywhere if seen.get("drawn") is None else on_path)
                worst_chord = max(worst_chord, of_chord)
    print(f"largest distance: {worst:.3f} % of the width; of chords: {worst_chord:.3f} %")
    if worst > MOST_PERCENT:
        sys.exit(f"more than {MOST_PERCENT} %")
    if names == NAMES and worst_chord <= MOST_PERCENT:
        sys.exit(f"the control is not found: chords within {MOST_PERCENT} %")


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]), sys.argv[3:] or NAMES)
