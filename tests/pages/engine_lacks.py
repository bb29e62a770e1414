"""What do pages with the engine say where the browser lacks something: 128-bit registers, WebAssembly, or JavaScript?

Usage: python engine_lacks.py FOLDER/report.html    (package: websockets; program: chromium)

The play page is next to the report, whose program was built with the engine (`src/browser/build.sh`). In Chromium, from files:
- without registers (an option of its compiler) and without WebAssembly, the button and the rerun give a message, and nothing is called equal;
- without JavaScript, the page shows its question and its answer, says what needs it, and offers no button of the engine.
Control: with all of them, the run is equal and the rerun is complete. Exit code 1 for a fault.
"""

import json
import re
import sys
import tempfile
from pathlib import Path

import engine_reruns
from chromium import Browser
from engine_verifies import EQUAL, PRESS

# What is missing, and the words of the page.
LACKS = {"nothing": EQUAL.pattern, "registers": "cannot be run here", "WebAssembly": "no WebAssembly"}
VISIBLE = """(() => ({ text: document.body.innerText, head: [...document.querySelectorAll("h1, .result")].filter((part) => part.checkVisibility()).length,
  buttons: [...document.querySelectorAll(".engine button, .rerun button")].filter((button) => button.checkVisibility()).length }))()"""


def with_scripts(report, folder, lack):
    """The faults of a browser that lacks something."""
    faults = []
    options = ["--js-flags=--no-enable-ssse3"] if lack == "registers" else []
    with Browser(folder, options) as browser:
        if lack == "WebAssembly":
            browser.call("Page.addScriptToEvaluateOnNewDocument", source="delete self.WebAssembly")
        browser.open(report.as_uri())
        lines = json.loads(browser.value(f"({PRESS})()"))["lines"]
        if not any(re.search(LACKS[lack], line) for line in lines) or lack != "nothing" and any("equal" in line for line in lines):
            faults.append(f"without {lack}, the button says {lines}")
        for page in (report, report.parent / "play.html"):
            browser.open(page.as_uri())
            status = json.loads(browser.value(f"({engine_reruns.PRESS % '{}'})()"))["status"]
            print(f"without {lack}, {page.name}: {lines[0][:100]} | {status[:100]}")
            if ("complete" in status) != (lack == "nothing") or not status:
                faults.append(f"without {lack}, {page.name} says {status!r}")
    return faults


def without_scripts(report, folder):
    faults = []
    with Browser(folder) as browser:
        browser.call("Emulation.setScriptExecutionDisabled", value=True)
        # The question and the answer of a report, the title of the play page.
        for page, words, head in ((report, "allow JavaScript", 2), (report.parent / "play.html", "need JavaScript", 1)):
            browser.open(page.as_uri())
            found = browser.value(VISIBLE)
            print(f"without JavaScript, {page.name}: {found['buttons']} buttons of the engine, {len(found['text'])} letters")
            if words not in found["text"] or found["head"] != head or found["buttons"]:
                faults.append(f"without JavaScript, {page.name} shows {found}")
    return faults


def main(report):
    faults = []
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        for lack in LACKS:
            faults += with_scripts(report, Path(folder) / lack, lack)
        faults += without_scripts(report, Path(folder) / "scripts")
    print("\n".join(f"FAULT {fault}" for fault in faults))
    return int(bool(faults))


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]).resolve()))
