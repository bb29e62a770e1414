"""Do reports run a changed manifest in Chromium and Firefox, and mark the result as the reader's?

Usage: python engine_reruns.py REPORT.html ...    (package: websockets; programs: chromium, firefox-esr)

The reports are of a program that was built with the engine (`src/browser/build.sh`). In each page, from a file:
- the unchanged manifest gives the recorded numbers, digit by digit;
- after a change of the first number, frames appear, and at least one number is another one; the mark names the change;
- the unchanged run's curves are those of the recorded one, which is gray, and a slider that is let go runs what it has changed;
- a text that is changed during a run is not called that of its results;
- typing a number keeps the lines of the text, and a change without spaces is named;
- an invalid number gives the program's error with its key; a manifest of 300 kB and one of 10^8 particles are rejected with a message;
- a long run is stopped by the reader, and after the stop the page runs again.
Prints a table with the times of the first frame and of the numbers, and of the longest task, which may have waited for a processor; in Chromium, also its
processor time. Exit code 1 for a fault.
"""

import json
import sys
import tempfile
from pathlib import Path

from engine_verifies import Chromium, Firefox

# Changes the text or the first field, presses the button, waits for its end or, after a time, presses it again.
PRESS = """async () => {
  const change = %s;
  const box = document.querySelector(".rerun");
  if (!box || box.hidden) return JSON.stringify({ status: "no section" });
  const [button, reset] = box.querySelectorAll("button"), text = box.querySelector("textarea"), field = box.querySelector(".keys input");
  const status = box.querySelector("[role=status]"), canvas = box.querySelector("canvas"), table = box.querySelector("table");
  box.open = true;
  reset.click();
  if (change.wait) await new Promise((done) => setTimeout(done, change.wait));
  if (change.factor) { field.value = Number(field.value) * change.factor; field.oninput(); }
  const count = text.value.split("\\n").length;
  for (const value of change.typed ?? []) { field.value = value; field.oninput(); }
  if (change.slide) {
    const slider = box.querySelector("[type=range]");
    Object.assign(slider, { value: change.slide });
    slider.oninput();
  }
  if (change.replace) text.value = text.value.replace(new RegExp(change.replace[0], "m"), change.replace[1]);
  const added = text.value.split("\\n").length - count;
  if (change.length) text.value += "#".repeat(change.length);
  let longest = 0, first;
  try { new PerformanceObserver((seen) => seen.getEntries().forEach((task) => (longest = Math.max(longest, task.duration)))).observe({ type: "longtask" }); } catch {}
  const started = performance.now();
  if (change.slide) box.querySelector("[type=range]").onchange();
  else button.click();
  if (change.during) setTimeout(() => { field.value = change.during; field.oninput(); });
  while (button.textContent === "Stop") {
    await new Promise((done) => setTimeout(done, 5));
    if (!canvas.hidden) first ??= performance.now() - started;
    if (change.stop && performance.now() - started > change.stop) button.click();
  }
  await new Promise((done) => setTimeout(done, 200));
  const rows = [...table.tBodies[0].rows].map((row) => [...row.cells].map((cell) => cell.textContent));
  const shown = [...box.querySelectorAll(".plots figure")];
  const lines = (figure, isGray) => [...figure.querySelectorAll("svg.sheet .curve:not(.theory):not(.fit)")].filter((line) => line.getAttribute("style").includes("c-1") === isGray)
    .map((line) => line.getAttribute("d").split("L").length);
  const pixels = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
  return JSON.stringify({
    status: status.textContent, rows: table.hidden ? [] : rows, first: first ?? 0, all: performance.now() - started, longest,
    charts: shown.map((figure) => [lines(figure, true), lines(figure, false)]), added, mark: box.querySelector(".mark").textContent, painted: !canvas.hidden && pixels.some((value) => value > 0),
  });
}"""

def has_pairs(found):
    """Whether the run has charts, each with the recorded curves in gray and curves of its own."""
    return found["charts"] and all(gray and own for gray, own in found["charts"])


CASES = {
    "unchanged": ({"wait": 1500}, lambda found: found["rows"] and all(row[1] == row[2] for row in found["rows"]) and "Nothing is changed" in found["mark"]
                  and has_pairs(found)),
    "changed": ({"factor": 2}, lambda found: any(row[1] != row[2] for row in found["rows"]) and "→" in found["mark"]
                and "not the recorded run" in found["mark"] and found["painted"] and has_pairs(found)),
    "slider": ({"slide": 90}, lambda found: any(row[1] != row[2] for row in found["rows"]) and "→" in found["mark"] and "complete" in found["status"]),
    "invalid": ({"factor": -1}, lambda found: not found["rows"] and "error" in found["status"]),
    "typed": ({"typed": ["", "3", "", "30"], "stop": 1}, lambda found: found["added"] == 0),
    "other spaces": ({"replace": ["^(\\w+) = ([1-9]\\d*)$", "$1=1$2"]}, lambda found: "→" in found["mark"]),
    "no manifest": ({"replace": ["^seed.*$", "seed = ["]}, lambda found: not found["rows"] and "error" in found["status"]),
    "changed during the run": ({"during": "33"}, lambda found: "before this change" in found["status"]),
    "too long": ({"length": 300_000}, lambda found: "256 kB" in found["status"]),
    "too large": ({"replace": ["^(particles|discs) = .*$", "$1 = 100000000"]}, lambda found: not found["rows"] and "complete" not in found["status"]),
    "stopped": ({"replace": ["^(duration_s|duration_days|events_per_disc) = .*$", "$1 = 1000000"], "stop": 120},
                lambda found: "stopped by you" in found["status"] and not found["rows"]),
    "again": ({}, lambda found: found["rows"] and all(row[1] == row[2] for row in found["rows"])),
}


class Pages:
    """What both browsers can do: open a page, and call a function in it."""

    @staticmethod
    def open(browser, address):
        if browser.name == "Chromium":
            browser.open(address)
        else:
            browser.call("browsingContext.navigate", context=browser.tab, url=address, wait="complete")

    @staticmethod
    def call(browser, function):
        return json.loads(browser.value(f"({function})()")) if browser.name == "Chromium" else browser.result_of(function)

    @staticmethod
    def press(browser, change):
        found = Pages.call(browser, PRESS % json.dumps(change))
        return found if "status" in found else {"status": str(found), "rows": [], "mark": "", "first": 0, "all": 0, "longest": 0, "painted": False}


def traced(browser, change):
    """What the page shows after a change, and the longest task of a page by processor time, in words."""
    if browser.name != "Chromium":
        return Pages.press(browser, change), ""
    browser.trace.clear()
    browser.call("Tracing.start", categories="toplevel", transferMode="ReportEvents")
    found = Pages.press(browser, change)
    browser.call("Tracing.end")
    browser.until(lambda message: message.get("method") == "Tracing.tracingComplete")
    pages = {(event["pid"], event["tid"]) for event in browser.trace if event["name"] == "thread_name" and event["args"]["name"] == "CrRendererMain"}
    tasks = [event.get("tdur", 0) for event in browser.trace if event["name"] == "ThreadControllerImpl::RunTask" and (event["pid"], event["tid"]) in pages]
    return found, f" ({max(tasks) / 1000:.0f} ms of a processor)"


def main(reports):
    faults = 0
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        for browser_class in (Chromium, Firefox):
            (profile := Path(folder) / browser_class.name).mkdir()
            with browser_class(profile) as browser:
                for report in reports:
                    Pages.open(browser, report.as_uri())
                    for name, (change, is_right) in CASES.items():
                        # Orbits have no number of particles.
                        if name == "too large" and "model.orbit" in report.read_text():
                            continue
                        found, processor = traced(browser, change) if name == "changed" else (Pages.press(browser, change), "")
                        if not is_right(found):
                            faults += 1
                            print(f"FAULT {browser.name}, {report.parent.name}, {name}: {json.dumps(found)[:600]}", flush=True)
                        elif name == "changed":
                            print(f"{browser.name}, {report.parent.name}: first frame {found['first']:.0f} ms, numbers {found['all']:.0f} ms, "
                                  f"longest task {found['longest']:.0f} ms{processor}: {found['mark'][:90]}", flush=True)
                if browser.errors:
                    faults += 1
                    print(f"{browser.name}: {browser.errors[:3]}")
    print(f"{len(reports)} reports, {len(CASES)} cases, {faults} faults")
    return int(faults > 0)


if __name__ == "__main__":
    sys.exit(main([Path(word).resolve() for word in sys.argv[1:]]))
