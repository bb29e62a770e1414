"""Do pages with the engine withstand changed links and changed reports, in Chromium and Firefox?

Usage: python engine_withstands.py [--count N] FOLDER/report.html    (package: websockets; programs: chromium, firefox-esr)

The play page is next to the report, whose program was built with the engine (`src/browser/build.sh`).
- N changed links [default: 1000]: letters of the address are changed, removed or inserted, or numbers and letters of the manifest in it; in addition, links that
  are huge, unpack to 50 MB, ask for 10^9 particles, or never end. Each gives a message or a run; the page answers within the limit, and no script fails.
- N changed reports: a bit of the module, of a claim (manifest and hashes) or of the stated hash of the module is changed, or a letter
  of the manifest that the page shows. Each must give a message and never
  "equal". Control: without a change, the report is equal, and a link that is not changed runs to its end.
Prints the number of each message; exit code 1 for a fault.
"""

import sys
import tempfile
from collections import Counter
from pathlib import Path

from engine_reruns import Pages
from engine_verifies import EQUAL, Chromium, Firefox

COMMON = """async () => {
  let state = %d;
  const random = (below) => { state = (Math.imul(state, 1664525) + 1013904223) >>> 0; return Math.floor(state / 4294967296 * below); };
  const flipped = (text) => { const at = random(text.length); return text.slice(0, at) + (text[at] === "A" ? "B" : "A") + text.slice(at + 1); };
  const wait = (ms) => new Promise((done) => setTimeout(done, ms));
  const found = [];
  // The longest time without an answer while the page is at work.
  let gap = 0, last;
  const pulse = setInterval(() => { if (last) { gap = Math.max(gap, performance.now() - last); last = performance.now(); } }, 10);
"""
LINKS = COMMON + """
  const box = document.querySelector(".rerun"), [button] = box.querySelectorAll("button"), text = box.querySelector("textarea");
  const status = box.querySelector("[role=status]"), starters = JSON.parse(box.querySelector("script.given").textContent).runs.map((run) => run.manifest);
  const link = async (words) => {
    const packed = new Uint8Array(await new Response(new Blob([words]).stream().pipeThrough(new CompressionStream("deflate"))).arrayBuffer());
    return btoa(Array.from(packed, (byte) => String.fromCharCode(byte)).join("")).replaceAll("+", "-").replaceAll("/", "_").replaceAll("=", "");
  };
  const changes = [
    (manifest) => manifest,
    (manifest) => { const numbers = [...manifest.matchAll(/= [-\\d.e]+/g)], one = numbers[random(numbers.length)];
      const other = ["0", "-1", "1e300", "nan", "7", "1000000000", "1e-12", "0x", "[[1]]"][random(9)];
      return manifest.slice(0, one.index) + "= " + other + manifest.slice(one.index + one[0].length); },
    (manifest) => { const at = random(manifest.length); return manifest.slice(0, at) + String.fromCharCode(random(0x3000)) + manifest.slice(at + random(40)); },
  ];
  const damage = [flipped, (words) => words.slice(0, random(words.length)), (words) => words + words.slice(random(words.length)),
    (words) => { const at = random(words.length); return words.slice(0, at) + "\\"<&%%=#"[random(7)] + words.slice(at); }];
  const special = async (index) => [
    () => "A".repeat(900000), async () => (await link("#".repeat(255000))) + "AAAA", () => link("\\0".repeat(50000000)),
    () => link(starters[1].replace(/^particles = .*$/m, "particles = 1000000000")), () => link(starters[0].replace(/^duration_s = .*$/m, "duration_s = 1e9")),
    () => link("<img src=x onerror=alert(1)><script>alert(1)</" + "script>"), () => link("[".repeat(200000)), () => link(""),
    () => link("q = 1" + " ".repeat(100000) + "x\\n[model.gas]\\nq = 1\\n")][index]();
  for (let index = 0; index < %d; index += 1) {
    const manifest = starters[random(starters.length)], first = %d + index;
    let letters = first < 1009 && first >= 1000 ? await special(first - 1000) : first < 0 ? await link(manifest) : await link(changes[random(3)](manifest));
    if (first >= 0 && first < 1000 && random(2)) letters = damage[random(4)](letters);
    status.textContent = text.value = "";
    location.hash = "";
    await wait(0);
    last = performance.now();
    location.hash = "#manifest=" + letters;
    for (let tries = 0; !status.textContent && tries < 1000; tries += 1) await wait(1);
    let words = status.textContent || "no message";
    if (words.startsWith("The manifest of the link")) {
      button.click();
      const started = performance.now();
      // Until its first frame; a run that is not changed, to its end.
      while (button.textContent === "Stop" && performance.now() - started < 65000 && (first < 0 || status.textContent === "starting")) await wait(2);
      if (button.textContent === "Stop") button.click();
      words = status.textContent;
    }
    last = undefined;
    found.push(words.split("\\n")[0]);
  }
  clearInterval(pulse);
  return JSON.stringify({ status: "", found, gap });
}"""
REPORTS = COMMON + """
  const section = document.querySelector(".engine"), button = section.querySelector("button"), list = section.querySelector("ul");
  const [claim] = document.querySelectorAll("script.claim"), manifest = document.querySelector("pre[data-file]");
  const whole = [self.kinetoscopeEngine, claim.textContent, section.dataset.module, manifest.textContent];
  for (let index = 0; index < %d; index += 1) {
    const parts = [...whole], part = random(4);
    // The last letters of base64 have bits without a meaning.
    if (%d) parts[part] = flipped(parts[part].slice(0, -4)) + parts[part].slice(-4);
    [self.kinetoscopeEngine, claim.textContent, section.dataset.module, manifest.textContent] = parts;
    button.click();
    while (button.textContent === "Stop") await wait(1);
    found.push([...list.children].map((line) => line.textContent).join(" "));
    [self.kinetoscopeEngine, claim.textContent, section.dataset.module, manifest.textContent] = whole;
  }
  clearInterval(pulse);
  return JSON.stringify({ status: "", found, gap });
}"""
BATCH = 50
# A page that answers no sooner has a loop that grows faster than its link, ms.
MOST_GAP_MS = 5000


def asked(browser, function, faults):
    found = Pages.call(browser, function)
    if "found" not in found:
        faults.append(f"the page does not answer: {found}")
        return [], 0
    return found["found"], found["gap"]


def kind(words):
    """The beginning of a message, for the table."""
    return " ".join(words.split()[:7])


def examine(browser, report, count):
    faults, kinds, gap = [], Counter(), 0
    Pages.open(browser, (report.parent / "play.html").as_uri())
    (unchanged, _) = asked(browser, LINKS % (1, 4, -4), faults)
    faults += [f"a link that is not changed: {words}" for words in unchanged if "the run is complete" not in words]
    # The links after the 1000th are the special ones.
    for first in [*range(0, count, BATCH), 1000]:
        found, slowest = asked(browser, LINKS % (first + 7, min(BATCH, count - first) if first < 1000 else 9, first), faults)
        gap = max(gap, slowest)
        kinds.update(map(kind, found))
        faults += [f"a changed link: {words}" for words in found if not words or words == "no message" or "equal" in words]
    for words, number in kinds.most_common(12):
        print(f"{browser.name}, links: {number:5} {words}")
    faults += [f"a link stops the page for {gap:.0f} ms"] if gap > MOST_GAP_MS else []
    print(f"{browser.name}: {sum(kinds.values())} changed links, longest time without an answer {gap:.0f} ms", flush=True)
    Pages.open(browser, report.as_uri())
    (unchanged, _) = asked(browser, REPORTS % (1, 1, 0), faults)
    faults += [f"a report that is not changed: {words}" for words in unchanged if not EQUAL.search(words)]
    kinds.clear()
    for first in range(0, count, BATCH):
        found, _ = asked(browser, REPORTS % (first + 3, min(BATCH, count - first), 1), faults)
        kinds.update(map(kind, found))
        faults += [f"a changed report: {words}" for words in found if not words or "equal" in words]
    for words, number in kinds.most_common():
        print(f"{browser.name}, reports: {number:5} {words}")
    return faults + [f"a script failed: {error}" for error in browser.errors]


def main(report, count):
    faults = []
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        for browser_class in (Chromium, Firefox):
            (profile := Path(folder) / browser_class.name).mkdir()
            with browser_class(profile) as browser:
                found = examine(browser, report, count)
            faults += found
            print("\n".join(f"FAULT {browser_class.name}: {text[:300]}" for text in found[:10]), flush=True)
    return int(bool(faults))


if __name__ == "__main__":
    words = sys.argv[1:]
    number = int(words[words.index("--count") + 1]) if "--count" in words else 1000
    sys.exit(main(Path(words[-1]).resolve(), number))
