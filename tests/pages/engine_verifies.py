"""Do reports verify their runs in Chromium and Firefox, from files and from a server on loopback?

Usage: python engine_verifies.py REPORT.html ...    (package: websockets; programs: chromium, firefox-esr)

The reports are of a program that was built with the engine (`src/browser/build.sh`). Each page's button is pressed, and all of its runs
must be equal. Then, in copies of the first report of one run, a character of the engine, of the claims and of nothing is changed, and the engine is
removed: these controls must not be called equal; a recording of another version of the physics is called one before it is compared. Prints a table; exit code 1 if a run differs or a control is not found.

    python engine_verifies.py --page docs/browsers.md RECORDINGS/*/report.html    also writes the counts as a page, if nothing is at fault
    python engine_verifies.py --changed MODULE.wasm.gz REPORT.html ...    with the engine of changed_engine.py: each page must name a frame
"""

import base64
import functools
import hashlib
import http.server
import json
import re
import shutil
import sys
import tempfile
import threading
from pathlib import Path

sys.path += [str(Path(__file__).parent), str(Path(__file__).parents[1] / "interop")]
import chromium
import report_in_firefox

# Presses the button and, where the page asks, that for all frames; reports the lines, the times of the first and the last one, and the
# longest task of the page.
PRESS = """async () => {
  const section = document.querySelector(".engine");
  if (!section) return JSON.stringify({ lines: [document.querySelector(".folds, main").textContent.match(/This page cannot[^.]*/)?.[0] ?? "no section"] });
  const button = section.querySelector("button"), list = section.querySelector("ul");
  const lines = () => [...list.children].map((line) => line.textContent);
  if (button.disabled) return JSON.stringify({ lines: lines() });
  let longest = 0;
  try { new PerformanceObserver((seen) => seen.getEntries().forEach((task) => (longest = Math.max(longest, task.duration)))).observe({ type: "longtask" }); } catch {}
  const started = performance.now();
  let first;
  button.click();
  while (button.textContent === "Stop") {
    await new Promise((done) => setTimeout(done, 5));
    [...list.querySelectorAll("button")].at(-1)?.click();
    if (list.children.length) first ??= performance.now() - started;
  }
  return JSON.stringify({ lines: lines(), first: first ?? 0, all: performance.now() - started, longest });
}"""
OTHER_VERSION = "another version of the physics"
EQUAL = re.compile(r"all \d+ frames of the repeated run equal those of the recording \(")


class Chromium(chromium.Browser):
    name = "Chromium"

    def press(self, address):
        self.open(address)
        return json.loads(self.value(f"({PRESS})()"))


class Firefox(report_in_firefox.Browser):
    name = "Firefox"

    def __init__(self, folder):
        super().__init__(folder, is_dark=False, axe=None)

    def press(self, address):
        self.call("browsingContext.navigate", context=self.tab, url=address, wait="complete")
        found = self.result_of(PRESS)
        return found if "lines" in found else {"lines": found}


def served(folder):
    """The address of a server of this folder."""
    class Quiet(http.server.SimpleHTTPRequestHandler):
        def log_message(self, *_):
            pass

    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(Quiet, directory=folder))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    return f"http://127.0.0.1:{server.server_address[1]}"


def changed(text, place):
    """The text with another letter of base64 at a place."""
    return text[:place] + ("A" if text[place] != "A" else "B") + text[place + 1:]


def of_another_version(claim):
    """The claim of a recording of the next version of the physics: a checksum, three texts after their lengths, and the version."""
    body = bytearray(base64.b64decode(claim)[32:])
    place = 0
    for _ in range(3):
        length = shift = 0
        while True:
            byte = body[place]
            length |= (byte & 0x7F) << shift
            place, shift = place + 1, shift + 7
            if byte < 0x80:
                break
        place += length
    body[place] += 1
    return base64.b64encode(hashlib.sha256(body).digest() + body).decode()


def controls(report, folder):
    """Copies of a report with faults, and what the page must say. The engine is next to the page, or in it, as in a bundle."""
    page, script = report.read_text(), report.parent / "kinetoscope-engine.js"
    engine = script.read_text() if script.exists() else None
    claim = page.index(">", page.index('class="claim"')) + 1
    claim_length = page.index("<", claim) - claim
    cases = {"no change": (page, engine, "equal those of the recording")}
    if engine:
        cases["no engine"] = (page, None, "is missing next to this page")
    other = of_another_version(page[claim:claim + claim_length])
    cases[OTHER_VERSION] = (page[:claim] + other + page[claim + claim_length:], engine, "recorded with version")
    text = engine or page
    start = text.index('kinetoscopeEngine="') + 19
    length = text.index('"', start) - start
    for part in (0.01, 0.5, 0.99):
        damaged = changed(text, start + int(part * (length - 3)))
        cases[f"engine changed at {part}"] = (page, damaged, "damaged") if engine else (damaged, None, "damaged")
        cases[f"claim changed at {part}"] = (changed(page, claim + int(part * (claim_length - 3))), engine, "damaged")
    for name, (page, engine, expected) in cases.items():
        place = folder / name.replace(" ", "_")
        place.mkdir()
        (place / "report.html").write_text(page)
        if engine:
            (place / "kinetoscope-engine.js").write_text(engine)
        yield name, place / "report.html", expected


def with_changed(module, page):
    """Puts another engine next to a page, which states its hash."""
    data = module.read_bytes()
    text = re.sub('data-module="[0-9a-f]*"', f'data-module="{hashlib.sha256(data).hexdigest()}"', page.read_text())
    page.write_text(text)
    (page.parent / "kinetoscope-engine.js").write_text(f'self.kinetoscopeEngine="{base64.b64encode(data).decode()}";\n')


def changed_is_found(module, reports):
    """Whether each page names the first frame that differs with a changed engine, in both browsers."""
    faults = 0
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        folder = Path(folder)
        for browser_class in (Chromium, Firefox):
            (profile := folder / browser_class.name).mkdir()
            with browser_class(profile) as browser:
                for number, report in enumerate(reports):
                    place = folder / f"{browser.name}{number}"
                    place.mkdir()
                    page = Path(shutil.copy(report, place / report.name))
                    with_changed(module, page)
                    lines = browser.press(page.as_uri())["lines"]
                    faults += not (lines and all("differs: /" in line for line in lines))
                    print(f"{browser.name}, {report.parent.name}: {lines[0] if lines else 'nothing'}", flush=True)
    return int(faults > 0)


def version(browser):
    """The browser's name and the first number of its version."""
    agent = "() => JSON.stringify([navigator.userAgent])"
    found = json.loads(browser.value(f"({agent})()")) if browser.name == "Chromium" else browser.result_of(agent)
    return f"{browser.name} {re.search(r'(?:Chrome|Firefox)/([0-9]+)', found[0])[1]}"


def counts_as_page(rows, report):
    """The table as a document."""
    module = re.search('data-module="([0-9a-f]*)"', report.read_text())[1]
    lines = [
        "# The same messages in browsers", "",
        "Generated by `tests/pages/engine_verifies.py`: do not edit. The reports of the shipped experiments, with the fewer runs that [the comparison of architectures](architectures.md) lists, "
        "repeat their runs in the page (\"Verify in this browser\") and compare the messages of all frames with those of the recording. An experiment is equal if all frames of all its runs are.", "",
        f"SHA-256 of the engine: `{module}`.", "",
        "| browser | page opened from | experiments | equal |", "|---|---|---|---|",
        *(f"| {browser} | {origin} | {count} | {equal} |" for browser, origin, count, equal in rows),
    ]
    return "\n".join(lines) + "\n"


def main(reports, page_of_counts=None):
    faults, rows = 0, []
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        folder = Path(folder)
        copies = folder / "pages"
        for number, report in enumerate(reports):
            shutil.copytree(report.parent, copies / f"{number}_{report.parent.name}", ignore=shutil.ignore_patterns("*.mcap", ".analysis*"))
        pages = [place / report.name for place, report in zip(sorted(copies.iterdir(), key=lambda path: int(path.name.split("_")[0])), reports)]
        # A report of one run: those that are not damaged are equal.
        single = next(page for page in pages if page.read_text().count('class="claim"') == 1)
        damaged = list(controls(single, folder / "pages"))
        address = served(copies)
        for browser_class in (Chromium, Firefox):
            (profile := folder / browser_class.name).mkdir()
            with browser_class(profile) as browser:
                for origin in ("file", "loopback"):
                    of = lambda page: page.as_uri() if origin == "file" else f"{address}/{page.relative_to(copies)}"
                    equal = 0
                    for page in pages:
                        found = browser.press(of(page))
                        is_equal = bool(found["lines"]) and all(EQUAL.search(line) for line in found["lines"])
                        equal += is_equal
                        if not is_equal:
                            print(f"{browser.name}, {origin}, {page.parent.name}: {found['lines']}")
                        elif page is pages[0]:
                            print(f"{browser.name}, {origin}, {page.parent.name}: first line {found['first']:.0f} ms, all {found['all']:.0f} ms, "
                                  f"longest task {found['longest']:.0f} ms: {found['lines'][0]}", flush=True)
                    print(f"{browser.name}, {origin}: {equal} of {len(pages)} equal", flush=True)
                    faults += len(pages) - equal
                    rows.append((version(browser), "a file" if origin == "file" else "a server on loopback", len(pages), equal))
                    for name, page, expected in damaged:
                        lines = browser.press(of(page))["lines"]
                        is_found = any(expected in line for line in lines) and (name in ("no change", OTHER_VERSION) or not any("equal" in line for line in lines))
                        faults += not is_found
                        if not is_found:
                            print(f"{browser.name}, {origin}, control {name}: expected {expected!r}, found {lines}")
                    print(f"{browser.name}, {origin}: {len(damaged)} controls", flush=True)
                if browser.errors:
                    print(f"{browser.name}: {browser.errors[:3]}")
    if page_of_counts and not faults:
        page_of_counts.write_text(counts_as_page(rows, reports[0]))
    return int(faults > 0)


if __name__ == "__main__":
    option = next((word for word in sys.argv[1:2] if word in ("--changed", "--page")), None)
    words = [Path(word).resolve() for word in sys.argv[1:] if word != option]
    sys.exit(changed_is_found(words[0], words[1:]) if option == "--changed" else main(words[1:], words[0]) if option else main(words))
