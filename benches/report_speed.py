"""How fast reports open and play: the first paint, and the script's time per frame of the replay, at 10,000 discs.

Usage: python benches/report_speed.py KINETOSCOPE [REPORT.html ...]    (package: websockets; program: chromium)

Without reports, it records 10,000 discs of the gas model and of the packing model for 100 intervals each, and measures their reports. Prints
for each report the median of five openings and the median of 100 frames, and for comparison, the time of an empty page. The script's time is
that of decoding a frame's numbers, drawing it and moving the marks of the plots; the browser paints the result afterward. The time from frame to frame is the median
during playback, 16.7 ms at 60 Hz. Exit code 1 if a first paint takes more than a second, or the script more than 8 ms per frame.
"""

import os
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests/pages"))
from chromium import Browser  # noqa: E402

OPENINGS, FRAMES = 5, 100
MAX_PAINT_MS, MAX_FRAME_MS = 1000, 8

MANIFESTS = {
    "ten_thousand_particles": """name = "ten_thousand_particles"
[model.gas]
particles = 10000
duration_s = 0.005
[record]
frames = 100
""",
    "ten_thousand_discs": """name = "ten_thousand_discs"
[model.packing]
discs = 10000
width = 260.0
height = 260.0
radius = 1.0
events_per_disc = 20
[record]
frames = 100
""",
}

PAINT = """new Promise((done) => {
  const painted = () => performance.getEntriesByName("first-contentful-paint")[0]?.startTime;
  const look = () => painted() === undefined ? setTimeout(look, 10) : done(painted());
  look();
})"""
READY = "(async () => { await window.replay?.ready; return performance.now(); })()"
PLAY = """(async () => {
  const times = [], intervals = [];
  for (let i = 0; i < %d; i++) {
    const began = performance.now();
    replay.show(i %% replay.frames);
    times.push(performance.now() - began);
    await new Promise(requestAnimationFrame);
  }
  replay.show(0);
  document.querySelector(".play").click();
  let before = await new Promise(requestAnimationFrame);
  for (let i = 0; i < %d; i++) {
    const now = await new Promise(requestAnimationFrame);
    intervals.push(now - before);
    before = now;
  }
  return [times, intervals];
})()""" % (FRAMES, FRAMES)


def recorded(kinetoscope, folder):
    """The reports of 10,000 particles."""
    reports = []
    for name, text in MANIFESTS.items():
        manifest = Path(folder) / f"{name}.toml"
        manifest.write_text(text)
        subprocess.run([kinetoscope, "run", "--quiet", "--output", folder, manifest], check=True)
        subprocess.run([kinetoscope, "analyze", "--quiet", Path(folder) / name], check=True, stdout=subprocess.DEVNULL)
        reports.append(Path(folder) / name / "report.html")
    return reports


def measured(browser, page):
    """First paint, complete replay, the script's times of frames, and the times from frame to frame, ms."""
    paints, readies = [], []
    for _ in range(OPENINGS):
        browser.open(page)
        paints.append(browser.value(PAINT))
        readies.append(browser.value(READY))
    frames, intervals = browser.value(PLAY) if browser.value("Boolean(window.replay)") else ([], [])
    return statistics.median(paints), statistics.median(readies), frames, intervals


def main(kinetoscope, reports):
    is_slow = False
    with tempfile.TemporaryDirectory() as folder:
        reports = reports or recorded(kinetoscope, folder)
        empty = Path(folder) / "empty.html"
        empty.write_text("<!doctype html><title>empty</title><body><p>text</p></body>")
        with Browser(folder) as browser:
            paint, *_ = measured(browser, empty.as_uri())
            print(f"empty page: first paint {paint:.0f} ms; load of the machine: {os.getloadavg()[0]:.1f}")
            for report in reports:
                paint, ready, frames, intervals = measured(browser, report.resolve().as_uri())
                text = f"{report.parent.name}: {report.stat().st_size / 1e6:.2f} MB, first paint {paint:.0f} ms, replay ready after {ready:.0f} ms"
                if frames:
                    middle = statistics.median(frames)
                    text += f", script per frame {middle:.1f} ms (median of {len(frames)}; largest {max(frames):.1f} ms), {statistics.median(intervals):.1f} ms from frame to frame"
                    is_slow |= middle > MAX_FRAME_MS
                is_slow |= paint > MAX_PAINT_MS
                print(text)
    sys.exit(is_slow)


if __name__ == "__main__":
    main(sys.argv[1], [Path(page) for page in sys.argv[2:]])
