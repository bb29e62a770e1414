"""What a reader sees first of each report, and how long and heavy the pages are.

Usage: python tests/pages/first_screens_fit.py RECORDINGS    (package: websockets; program: chromium)

RECORDINGS: the folder of `index.html` and of one folder per report. Prints one line per report, and their medians and extremes. Exit code 1 if a page misses one of
the bars below, has an error, is wider than its window, or squeezes a label of an axis. Control: a copy of the first report with a tall element, a metric's name, an error
and a squeezed label at its start must be found.
"""

import re
import statistics
import sys
import tempfile
from pathlib import Path

from chromium import Browser

SCREEN, PHONE = (1280, 800), (390, 844)
# The top of the replay on a screen, px; it must be complete on a screen, and begin on that of a phone.
MOST_TOP = 260
# Median heights of the pages on a screen and on a phone, px.
MOST_HEIGHTS = {SCREEN: 2600, PHONE: 4000}
MOST_MEDIAN_BYTES, MOST_SCRIPT_BYTES = 700_000, 60_000
MOST_SCREENS_OF_INDEX = 4

METRIC = re.compile(r"\b[a-z][a-z0-9]*(?:_[a-z0-9]+)*\.[a-z][a-z0-9]*(?:_[a-z0-9]+)*\b")
FILE = re.compile(r"\.(mcap|csv|json|svg|toml|html)$")

PROBE = """(async () => {
  await window.replay?.ready;
  await window.replay?.second?.ready;
  for (let i = 0; i < 3; i++) await new Promise(requestAnimationFrame);
  const texts = [];
  for (const part of document.querySelectorAll("h1, h2, h3, p, li, td, th, dt, dd, figcaption, label, summary, text")) {
    const box = part.getBoundingClientRect();
    if (box.width && box.top < innerHeight && box.bottom > 0) texts.push(part.textContent);
  }
  const boxes = [...document.querySelectorAll("canvas")].filter((canvas) => canvas.checkVisibility()).map((canvas) => canvas.getBoundingClientRect());
  const script = [...document.querySelectorAll("script:not([type])")].reduce((sum, each) => sum + each.textContent.length, 0);
  const page = document.documentElement;
  const squeezed = [...document.querySelectorAll(".sheet text[textLength]")].map((text) => text.textContent);
  return { text: texts.join(" "), top: Math.min(...boxes.map((box) => box.top)), bottom: Math.max(...boxes.map((box) => box.bottom)),
    replays: boxes.length, squeezed, height: page.scrollHeight, isWide: page.scrollWidth > page.clientWidth, script };
})()"""


def seen(browser, page):
    """What a page shows at both sizes, and what is wrong with it."""
    found, faults = {}, []
    for size in (SCREEN, PHONE):
        browser.open(page.resolve().as_uri(), size)
        found[size] = one = browser.value(PROBE)
        faults += [f"error at {size[0]} px: {error}" for error in browser.errors]
        if one["isWide"]:
            faults.append(f"wider than {size[0]} px")
        faults += [f"squeezed at {size[0]} px: {label}" for label in one["squeezed"]]
    screen, phone = found[SCREEN], found[PHONE]
    if screen["replays"] and (screen["top"] >= MOST_TOP or screen["bottom"] > SCREEN[1]):
        faults.append(f"the replay is from {screen['top']:.0f} to {screen['bottom']:.0f} px")
    if phone["replays"] and phone["top"] >= PHONE[1]:
        faults.append(f"the replay begins at {phone['top']:.0f} px on a phone")
    names = sorted({name for name in METRIC.findall(screen["text"]) if not FILE.search(name)})
    if names:
        faults.append(f"names of metrics: {' '.join(names)}")
    if screen["script"] > MOST_SCRIPT_BYTES:
        faults.append(f"{screen['script']} bytes of script")
    return found, faults


def require_control(browser, page, folder):
    """Faults that are there must be found."""
    start = '<main><div style="height: 900px; width: 2000px"><p>energy.max_residual</p></div><svg class="sheet"><text textLength="9">label</text></svg><script>undefined.x</script>'
    faulty = Path(folder) / "control.html"
    faulty.write_text(page.read_text().replace("<main>", start))
    faults = " ".join(seen(browser, faulty)[1])
    for fault in ("error at", "wider than", "the replay is from", "on a phone", "names of metrics", "squeezed at"):
        if fault not in faults:
            sys.exit(f"the control is not found: {fault} in {faults}")


def summary(name, values, unit):
    print(f"{name}: median {statistics.median(values):.0f}, {min(values):.0f} to {max(values):.0f} {unit}")
    return statistics.median(values)


def main(recordings):
    reports = sorted(recordings.glob("*/report.html"))
    if not reports or not (recordings / "index.html").exists():
        sys.exit(f"{recordings} has no reports with an index.html: analyze the folder")
    all_faults, screens, phones, sizes = [], [], [], []
    with tempfile.TemporaryDirectory() as folder, Browser(folder) as browser:
        require_control(browser, reports[0], folder)
        for report in reports:
            found, faults = seen(browser, report)
            screen, phone, size = found[SCREEN], found[PHONE], report.stat().st_size
            replay = f"replay from {screen['top']:.0f} to {screen['bottom']:.0f} px, phone from {phone['top']:.0f} px" if screen["replays"] else "no replay"
            print(f"{report.parent.name}: {replay}; page {screen['height']} px, phone {phone['height']} px; {size / 1e6:.2f} MB", *faults, sep="; " if faults else "")
            all_faults += faults
            screens.append(screen)
            phones.append(phone)
            sizes.append(size / 1e3)
        replays, on_phones = ([one for one in all_of if one["replays"]] for all_of in (screens, phones))
        summary("top of the replay", [one["top"] for one in replays], "px")
        summary("top of the replay on a phone", [one["top"] for one in on_phones], "px")
        for size, all_of in ((SCREEN, screens), (PHONE, phones)):
            if summary(f"height at {size[0]} px", [one["height"] for one in all_of], "px") > MOST_HEIGHTS[size]:
                all_faults.append(f"pages are too long at {size[0]} px")
        if summary("weight", sizes, "kB") > MOST_MEDIAN_BYTES / 1e3:
            all_faults.append("pages are too heavy")
        index, faults = seen(browser, recordings / "index.html")
        screens_of_index = index[SCREEN]["height"] / SCREEN[1]
        print(f"script: {screens[0]['script'] / 1e3:.1f} kB; index: {screens_of_index:.1f} screens", *faults)
        all_faults += faults
        if screens_of_index > MOST_SCREENS_OF_INDEX:
            all_faults.append("the index is too long")
    print(f"{len(reports)} reports, {len(replays)} with a replay: {len(all_faults)} faults")
    sys.exit(bool(all_faults))


if __name__ == "__main__":
    main(Path(sys.argv[1]))
